// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace spheroseg {

enum class Method { fast, all_pairs };
enum class Effort { draft, standard, high };
enum class Device { automatic, cpu, cuda };
enum class Balance { triangle_count, weight };

struct SegmentOptions {
    /// Number of sub-meshes k, in [1, F]; 0: 200, or ceil(F / 10) for meshes under 2,000 faces.
    int submesh_count = 0;
    /// If > 0, k = ceil(F / triangles_per_submesh) instead.
    int triangles_per_submesh = 0;
    Method method = Method::fast;
    /// How long `fast` refines; every effort gives the same guarantees.
    Effort effort = Effort::standard;
    Device device = Device::automatic;
    /// Same seed, same labels: for any thread count, on every run.
    std::uint64_t seed = 0;
    /// 0: all cores; at most 256, or as many as there are cores, are used.
    int thread_count = 0;
    /// 0: until converged. With a limit below what it does on all its levels `fast` makes no
    /// trials.
    int max_cohesion_iterations = 0;
    int max_refinement_iterations = 0;
    /// 0: none. When it is hit the result is still valid and balanced as far as the method
    /// guarantees it, and `time_limit_hit` is set; where that needs searches, they end when twice
    /// the limit and a second have passed, or ten times what a draft without them takes. What is
    /// prepared before the first sub-mesh is not limited.
    double time_limit_seconds = 0.0;
    /// What the sub-meshes shall have the same of; `weight` is for `fast` only.
    Balance balance = Balance::triangle_count;
    /// With `Balance::weight`: one finite weight >= 0 per face, not all 0. Empty: the areas.
    std::vector<double> face_weights;
    /// Labels >= 0 to start from, one per face; empty: none. k is then the number of different
    /// ones, and `submesh_count` and `triangles_per_submesh` are not used. For `fast` only.
    std::vector<int> initial_labels;
};

} // namespace spheroseg
