// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"
#include "swap_iterations.h"

namespace spheroseg {

/// Sum of Eq. 1 over the faces, each in its own sub-mesh.
double refinement_energy(const DualGraph& dual_graph, const std::vector<int>& labels);

/// Algorithms 3 and 4: in every iteration all pairs of faces on boundaries are met in round-robin
/// rounds, and a pair swaps its labels when that lowers the cost of Eq. 1 of the two faces,
/// evaluated on the labels before and after the swap (also where the two are neighbours). Faces
/// inside a sub-mesh take no part: they have no boundary to refine, and where Eq. 1 alone would let
/// them swap it would make them islands. Eq. 1 looks at the two faces, not at the whole, so swaps
/// may undo each other: ends, as in the paper, after the first iteration that does not lower the
/// number of boundary edges, and takes that one back.
///
/// A pair is decided on the labels at the start of its round. It yields, until the next iteration,
/// to a pair of an earlier slot that decided to swap a face within two steps of one of its own:
/// so every swap that is made lowers the cost as decided, and the result does not depend on the
/// number of threads. `dual_graph` is that of a closed mesh. `labels` is changed in place; the
/// count of each label stays. O(F^2) per iteration, of two one-byte numbers per pair. Throws
/// Cancelled. Source: Spherical Parametric Measurement for Continuous and Balanced Mesh
/// Segmentation, sec. 4.
SwapIterations refine_all_pairs(const DualGraph& dual_graph,
                                const SwapLimits& limits,
                                std::vector<int>& labels,
                                const Progress& progress = {});

} // namespace spheroseg
