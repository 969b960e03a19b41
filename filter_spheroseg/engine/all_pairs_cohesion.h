// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"
#include "swap_iterations.h"

namespace spheroseg {

/// Labels 0 .. submesh_count - 1 in random order; their counts differ by at most one.
std::vector<int> random_balanced_labels(int face_count, int submesh_count, std::uint64_t seed);

/// Algorithms 1 and 2: in every iteration all pairs of faces are met in round-robin rounds, a pair
/// swaps its labels when that lowers the sum of chord distances, and then the centroids of the
/// sub-meshes are updated. Ends after an iteration without a swap. When centroids coincide then,
/// they are shifted by a random offset, once (section 3.1). Since the mean does not minimise a sum
/// of chords, the energy may rise when centroids move: it also ends when 32 iterations have brought
/// no new least energy.
///
/// `face_centroids`: one unit vector per face. `labels`: in [0, submesh_count), changed in place;
/// the count of each label stays. The pairs of a round are disjoint and the centroids fixed, so the
/// result does not depend on the number of threads; additions, products and IEEE roots in single
/// precision without contraction, and centroids from integer sums, make it the same on every
/// machine. O(F^2) per iteration. Throws Cancelled.
/// Source: Spherical Parametric Measurement for Continuous and Balanced Mesh Segmentation, sec. 3.
SwapIterations cohere_all_pairs(const DualGraph& dual_graph,
                                const std::vector<Vec3>& face_centroids,
                                int submesh_count,
                                std::uint64_t seed,
                                const SwapLimits& limits,
                                std::vector<int>& labels,
                                const Progress& progress = {});

} // namespace spheroseg
