// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <common/ml_document/mesh_document.h>

#include <vector>

namespace spheroseg {

/// Layers that a filter adds to a document: without `keep` they are removed again, and the current
/// mesh is the one that was. From the second one on, MeshLab's list of layers is hidden until the
/// filter has ended: while it is seen it is built anew for each, 200 times for 200 layers, which
/// takes minutes.
class NewLayers {
public:
    explicit NewLayers(MeshDocument& document);
    ~NewLayers();
    NewLayers(const NewLayers&) = delete;
    NewLayers& operator=(const NewLayers&) = delete;

    /// Does not become the current mesh. `name` gets a number where another layer has it.
    MeshModel& add(const QString& name);
    int count() const { return static_cast<int>(ids_.size()); }
    void keep() { is_kept_ = true; }

private:
    MeshDocument& document_;
    const int current_;
    std::vector<int> ids_;
    bool is_kept_ = false;
    QWidget* hidden_list_ = nullptr;
};

} // namespace spheroseg
