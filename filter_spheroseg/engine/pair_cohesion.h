// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"
#include "progress.h"
#include "swap_iterations.h"
#include "types.h"

namespace spheroseg {

/// Cohesion that ends where `cohere_all_pairs` may end: the same energy and arithmetic, centroids
/// fixed within an iteration and updated after it, and after an iteration without a swap no pair
/// of faces is left, over all pairs of sub-meshes, whose swap lowers the sum of chord distances.
///
/// For fixed centroids the swap of a face in sub-mesh i with one in j helps exactly when their
/// gains add up to more than 0, so that only the largest gains of both sides can matter: they are
/// swapped from the top. Pairs of sub-meshes meet in the order of a round robin; those are left out
/// that lie too far apart for any gain, and those where nothing changed since they last met.
///
/// `face_centroids`: one unit vector per face. `labels`: in [0, submesh_count), changed in place;
/// the count of each label stays. The result does not depend on the number of threads. Coinciding
/// centroids are not parted, unlike there: begin with `balanced_sphere_labels`. Like there, it also
/// ends when 32 iterations have brought no new least energy. `boundary_edges` of the result is
/// empty without a dual graph (may be null). From a coherent start an iteration costs O(F), a sort
/// of the faces that may move, and a sweep over the sub-meshes along one axis for pairs that may
/// touch, about O(k^1.5); memory is O(F) and the number of those pairs. Throws Cancelled; the
/// labels are unchanged then.
SwapIterations cohere_pairs(const std::vector<Vec3>& face_centroids,
                            int submesh_count,
                            const SwapLimits& limits,
                            std::vector<int>& labels,
                            const Progress& progress = {},
                            const DualGraph* dual_graph = nullptr);

} // namespace spheroseg
