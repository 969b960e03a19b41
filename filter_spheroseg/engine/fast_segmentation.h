// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

/// What the user gave for the faces of one component; empty: nothing.
struct FaceData {
    /// Finite, >= 0.
    std::vector<double> weights;
    /// In [0, submesh_count), or -1 for none.
    std::vector<int> initial_labels;
};

/// The method `fast` on one component: a start on a coarse version of the mesh by recursive
/// bisection and Lloyd's relaxation of the dual graph, annealing of the boundaries on every level,
/// exact balance by chains of moves, and exchanges at exact balance. Uses only the connectivity of
/// the mesh, never its coordinates. Every sub-mesh stays connected and free of bowties at every
/// moment; when the balance can not be reached, it is tried again from other starts, and the best
/// result is kept.
/// With weights, the heaviest load is lowered (balance_by_weight) instead of the exact balance.
/// With initial labels, the first start is these, adopted (adopt_labels) and refined on the finest
/// level; if they are valid and balanced already, they also compete with the results.
///
/// Fills labels (one in [0, submesh_count) per face of the component), iterations and times of
/// `result`. The time limit cuts the annealing short, not what makes the result valid. `whole` is
/// the mesh that the component is where that can be mapped to the sphere, else null.
void segment_component(Component& component,
                       PreparedMesh* whole,
                       const SegmentOptions& options,
                       int submesh_count,
                       const FaceData& data,
                       const Deadline& deadline,
                       const Progress& progress,
                       Segmentation& result);

} // namespace spheroseg
