// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace spheroseg {

/// How many sub-meshes each component of a mesh gets.
struct Shares {
    /// At least 1 and at most the component's face count each; their sum is k.
    std::vector<int> submesh_counts;
    /// Largest minus smallest triangle count when each component is parted as evenly as its count
    /// allows: no other shares make it smaller.
    int max_triangle_count_difference = 0;
    /// The least and the largest triangle count then.
    int least_count = 0;
    int largest_count = 0;
};

/// Shares `submesh_count` sub-meshes among components of `face_counts` faces so that the largest
/// and the smallest sub-mesh differ least; of such shares it takes those with the least largest
/// sub-mesh, and then the least sum of squared counts. Where counts are m or m + 1 this leaves a
/// choice: the parts of the sub-meshes with m + 1 are then about equal in all components, and no
/// component gets only the one or the other as long as other ones can take the rest. Requires
/// face_counts.size() <= submesh_count <= sum of face_counts and every face count > 0.
/// O((m c + r) log F) for c components, m at most the smallest face count or F / k, mostly far
/// fewer, and r of the sub-meshes, the rest over the fewest that the largest count allows.
Shares share_submeshes(const std::vector<int>& face_counts, int submesh_count);

/// The same by weight: one sub-mesh for each component, then always one more for the component
/// with the largest weight per sub-mesh among those with more faces than sub-meshes. No other
/// shares make that largest weight smaller. O(k log c).
std::vector<int> share_submeshes_by_weight(const std::vector<double>& weights,
                                           const std::vector<int>& face_counts,
                                           int submesh_count);

} // namespace spheroseg
