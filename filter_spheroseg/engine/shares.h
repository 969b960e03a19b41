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

/// Distributes `submesh_count` sub-meshes over components of `face_counts` faces so that the
/// triangle counts of the largest and the smallest sub-mesh differ least. Ties are broken by the
/// smaller largest count, then by the smaller sum of squared counts. Where all counts are m or m +
/// 1, that still leaves a choice: the fraction of sub-meshes with m + 1 is then about equal in all
/// components, and components with only one of the two counts, which are the hardest to cut, are
/// avoided as far as possible. Requires face_counts.size() <= submesh_count <= sum of face_counts
/// and every face count > 0. O((m c + r) log F) for c components: m <= min(smallest face count, F /
/// k) lower bounds of the counts are tried, mostly far fewer, and r <= k sub-meshes are given out
/// one by one.
Shares share_submeshes(const std::vector<int>& face_counts, int submesh_count);

/// The same by weight: each component gets one sub-mesh, then always the component with the largest
/// weight per sub-mesh, of those with more faces than sub-meshes, gets one more. No other shares
/// make the largest weight per sub-mesh smaller. O(k log c).
std::vector<int> share_submeshes_by_weight(const std::vector<double>& weights,
                                           const std::vector<int>& face_counts,
                                           int submesh_count);

} // namespace spheroseg
