// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <vector>

namespace spheroseg {

/// The faces of each sub-mesh of a patchwork, for what cuts one region after another anew.
class SubmeshFaces {
public:
    /// O(F).
    explicit SubmeshFaces(const Patchwork& patchwork)
        : patchwork_(patchwork), faces_of_(patchwork.submesh_count()) {
        for (int f = 0; f < patchwork.face_count(); ++f) {
            faces_of_[patchwork.label(f)].push_back(f);
        }
    }

    const std::vector<int>& operator[](int label) const { return faces_of_[label]; }

    void add_to(Region& region, int label) const {
        const std::vector<int>& faces = faces_of_[label];
        region.labels.push_back(label);
        region.faces.insert(region.faces.end(), faces.begin(), faces.end());
    }

    /// After the faces of a region got new labels, which are of the region, too.
    void update(const Region& region) {
        for (int label : region.labels) {
            faces_of_[label].clear();
        }
        for (int f : region.faces) {
            faces_of_[patchwork_.label(f)].push_back(f);
        }
    }

private:
    const Patchwork& patchwork_;
    std::vector<std::vector<int>> faces_of_;
};

} // namespace spheroseg
