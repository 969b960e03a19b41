// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_sphere.h"

#include "all_pairs_cohesion.h"
#include "cohesion_state.h"
#include "pair_cohesion.h"
#include "parametrization.h"
#include "random.h"
#include "sphere_bisection.h"

#include <algorithm>
#include <cmath>

namespace spheroseg::fuzz {

namespace {

constexpr int kMaxIterations = 12;

/// One vertex on another one of its face, on the other side of the sphere, off the sphere or
/// nowhere.
std::vector<Vec3>
with_fault(const TriangleMesh& mesh, std::vector<Vec3> positions, Random& random) {
    const Triangle& t = mesh.faces[random.below(static_cast<std::uint32_t>(mesh.face_count()))];
    const int corner = static_cast<int>(random.below(3));
    Vec3& p = positions[t[corner]];
    switch (random.below(4)) {
    case 0:
        p = positions[t[(corner + 1) % 3]];
        break;
    case 1:
        p = p * -1.0;
        break;
    case 2:
        p = p * 1.5;
        break;
    default:
        p.x = std::nan("");
        break;
    }
    return positions;
}

std::vector<int> counts_of(const std::vector<int>& labels, int submesh_count) {
    std::vector<int> counts(static_cast<std::size_t>(submesh_count), 0);
    for (int label : labels) {
        ++counts[label];
    }
    return counts;
}

const char*
find_bad_cohesion(const std::vector<Vec3>& centroids, int seed, int thread_count, Random& random) {
    const auto face_count = static_cast<int>(centroids.size());
    const int submesh_count =
        1 + static_cast<int>(random.below(static_cast<std::uint32_t>(face_count / 2)));
    const std::vector<int> start = random.below(2) == 0
        ? balanced_sphere_labels(centroids, submesh_count)
        : random_balanced_labels(face_count, submesh_count, static_cast<std::uint64_t>(seed));
    const std::vector<int> counts = counts_of(start, submesh_count);
    const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
    if (*most - *least > 1) {
        return "a start on the sphere is balanced";
    }
    SwapLimits limits;
    limits.max_iterations = kMaxIterations;
    limits.thread_count = thread_count;
    std::vector<int> labels = start;
    cohere_pairs(centroids, submesh_count, limits, labels);
    limits.thread_count = 1 + thread_count % 3;
    std::vector<int> again = start;
    cohere_pairs(centroids, submesh_count, limits, again);
    if (counts_of(labels, submesh_count) != counts) {
        return "swaps keep the counts";
    }
    return labels == again ? nullptr : "the same swaps with any number of threads";
}

} // namespace

const char* find_bad_sphere(PreparedMesh& prepared, int seed, int thread_count) {
    const TriangleMesh& mesh = prepared.mesh();
    const std::vector<Vec3> positions = prepared.parametrization(thread_count).positions;
    Random random(static_cast<std::uint64_t>(seed), 2);
    if (!is_valid_parametrization(mesh, positions) ||
        measure_parametrization(mesh, positions).flipped_triangle_count != 0) {
        return "no flipped triangle";
    }
    if (prepared.set_parametrization(with_fault(mesh, positions, random))) {
        return "a map with a fault is refused";
    }
    if (!prepared.set_parametrization(positions)) {
        return "the map fits its mesh";
    }
    return find_bad_cohesion(face_centroids_on_sphere(mesh, positions), seed, thread_count, random);
}

} // namespace spheroseg::fuzz
