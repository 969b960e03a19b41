// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hierarchy.h"
#include "patchwork.h"

namespace spheroseg {

/// Coarse versions of a mesh as patchworks, and the way back. A face of a coarse mesh weighs as
/// much as the faces of the input mesh that it stands for. The k-independent part of a
/// segmentation.
///
/// Cells are numbered in the order in which they appear, coarse ones first, so that every level
/// is a prefix of the next one.
class Multilevel {
public:
    /// `hierarchy` must outlive this object. `weights` has one whole number >= 1 per face of the
    /// input mesh, with a sum below 2^30; empty: all 1. O(F).
    Multilevel(const CollapseHierarchy& hierarchy,
               int face_count,
               const std::vector<int>& weights = {});
    /// The finest level only, its cells in the order of the faces.
    Multilevel(const TriangleMesh& mesh,
               const DualGraph& dual_graph,
               const std::vector<int>& weights = {});

    /// The coarsest level with at least `min_face_count` faces (the finest one if there is none),
    /// with all labels 0.
    Patchwork coarsen(int min_face_count, int submesh_count) const;

    /// Undoes collapses, round by round, until there are at least `min_face_count` faces or all.
    /// New faces get the label of a neighbour, so that loads stay the same, and every sub-mesh
    /// stays connected and free of bowties.
    void uncoarsen(Patchwork& patchwork, int min_face_count) const;

    /// Labels of the finest level in the order of the input mesh's faces.
    std::vector<int> labels(const Patchwork& patchwork) const;

    /// The reverse, on the finest level: takes one label per face of the input mesh; -1:
    /// unassigned.
    void set_labels(Patchwork& patchwork, const std::vector<int>& labels) const;

    int face_count() const { return static_cast<int>(cell_of_face_.size()); }
    /// Sum of the weights of all faces.
    int total_weight() const { return total_weight_; }

private:
    Multilevel(const CollapseHierarchy* hierarchy, int face_count, const std::vector<int>& weights);
    void undo(Patchwork& patchwork, int step) const;
    int undo_side(Patchwork& patchwork, int step, bool first) const;

    const CollapseHierarchy* hierarchy_; // null without coarse levels
    /// Number of faces before each step is undone; falls with the steps.
    std::vector<int> faces_before_;
    std::vector<int> cell_of_face_;
    /// Weight of each face when it was collapsed, or at the end.
    std::vector<int> weight_;
    int total_weight_ = 0;
    Patchwork base_;
};

} // namespace spheroseg
