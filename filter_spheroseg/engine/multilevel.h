// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "levels.h"
#include "patchwork.h"

#include <memory>

namespace spheroseg {

/// The levels of a mesh as patchworks: coarsens, and carries labels back to finer levels. A cell
/// weighs as much as the faces that it stands for. Does not depend on k, so one serves for all.
class Multilevel {
public:
    /// See build_levels.
    Multilevel(const CollapseHierarchy& hierarchy, int face_count, int thread_count = 1);
    /// The finest level only.
    Multilevel(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count = 1);

    /// The same levels, which are not copied, with weights: one whole number >= 1 per face of the
    /// input mesh, with a sum below 2^30.
    Multilevel with_weights(const std::vector<int>& weights) const;

    /// The coarsest level with at least `min_face_count` cells (the finest one if there is none),
    /// with all labels 0.
    Patchwork coarsen(int min_face_count, int submesh_count, int thread_count = 1) const;

    /// The cells of that level.
    int cell_count(int min_face_count) const { return level_with(min_face_count).cell_count(); }

    /// The same among only the finest level and those that undone subdivisions leave, on which all
    /// edges stand for equally many fine ones.
    int quartered_cell_count(int min_face_count) const;

    /// Turns a patchwork into that of the next finer level, if there is one. Cells get the labels
    /// of those that stood for them, so that loads stay the same, and every sub-mesh stays
    /// connected and free of bowties; unless holes open that were closed, then it returns true.
    bool uncoarsen(Patchwork& patchwork, int thread_count = 1) const;

    /// Labels of the finest level in the order of the input mesh's faces.
    std::vector<int> labels(const Patchwork& patchwork) const;

    /// The reverse, on the finest level: takes one label per face of the input mesh; -1:
    /// unassigned.
    void set_labels(Patchwork& patchwork, const std::vector<int>& labels) const;

    int face_count() const { return static_cast<int>(levels_->face_at.size()); }
    int level_count() const { return static_cast<int>(levels_->levels.size()); }
    /// Sum of the weights of all faces.
    int total_weight() const { return weight_before(face_count()); }

private:
    const Level& level_with(int min_face_count) const;
    const Level& level_of(const Patchwork& patchwork) const;
    /// The weight of the first cells of the finest level.
    int weight_before(int finest) const {
        return weight_before_.empty() ? finest : weight_before_[finest];
    }
    void fill(Patchwork& patchwork, const Level& level, int first, int end, int label) const;

    std::shared_ptr<const MeshLevels> levels_;
    std::vector<int> weight_before_; // empty: all weights are 1
};

} // namespace spheroseg
