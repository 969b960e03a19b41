// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

/// The method `fast` on one component: a start on a coarse version of the mesh by recursive
/// bisection and Lloyd's relaxation of the dual graph, annealing of the boundaries on every level,
/// exact balance by chains of moves, and exchanges at exact balance. Uses only the connectivity of
/// the mesh, never its coordinates. Every sub-mesh stays connected and free of bowties at every
/// moment; when the balance can not be reached, it is tried again from other starts, and the best
/// result is kept.
///
/// Fills labels (one in [0, submesh_count) per face of the component), iterations and times of
/// `result`. The time limit cuts the annealing short, not what makes the result valid. `whole` is
/// the mesh that the component is where that can be mapped to the sphere, else null.
void segment_component(Component& component,
                       PreparedMesh* whole,
                       const SegmentOptions& options,
                       int submesh_count,
                       const Deadline& deadline,
                       const Progress& progress,
                       Segmentation& result);

} // namespace spheroseg
