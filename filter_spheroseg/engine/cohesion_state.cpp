// SPDX-License-Identifier: GPL-3.0-or-later
#include "cohesion_state.h"

#include <numeric>

namespace spheroseg {

namespace {

/// Coordinates are summed as multiples of 2^-36: exact whatever the order, up to 2^26
/// faces of one sub-mesh.
constexpr double kFixedPointScale = 0x1.0p36;

} // namespace

Vec3 unit_or_zero(const Vec3& p) {
    const double norm = length(p);
    return norm > 0.0 ? p * (1.0 / norm) : Vec3{};
}

std::vector<Vec3> face_centroids_on_sphere(const TriangleMesh& mesh,
                                           const std::vector<Vec3>& sphere_positions) {
    std::vector<Vec3> centroids;
    centroids.reserve(mesh.faces.size());
    for (const Triangle& face : mesh.faces) {
        centroids.push_back(unit_or_zero(sphere_positions[face[0]] + sphere_positions[face[1]] +
                                         sphere_positions[face[2]]));
    }
    return centroids;
}

ChordSwapState make_cohesion_state(const std::vector<Vec3>& face_centroids,
                                   const std::vector<int>& labels) {
    ChordSwapState state;
    state.face.resize(face_centroids.size());
    for (std::size_t f = 0; f < face_centroids.size(); ++f) {
        state.face.set(static_cast<int>(f), face_centroids[f]);
    }
    state.own.resize(face_centroids.size());
    state.distance.resize(face_centroids.size());
    state.label = labels;
    return state;
}

PointArrays submesh_centroids(const ChordSwapState& state, int submesh_count) {
    std::vector<std::array<std::int64_t, 3>> sums(submesh_count, {0, 0, 0});
    const auto fixed_point = [](float value) {
        return static_cast<std::int64_t>(std::llrint(value * kFixedPointScale));
    };
    for (int f = 0; f < state.face_count(); ++f) {
        auto& sum = sums[state.label[f]];
        sum[0] += fixed_point(state.face.x[f]);
        sum[1] += fixed_point(state.face.y[f]);
        sum[2] += fixed_point(state.face.z[f]);
    }
    PointArrays centroids;
    centroids.resize(submesh_count);
    for (int s = 0; s < submesh_count; ++s) {
        centroids.set(s,
                      unit_or_zero({static_cast<double>(sums[s][0]),
                                    static_cast<double>(sums[s][1]),
                                    static_cast<double>(sums[s][2])}));
    }
    return centroids;
}

void assign_centroids(ChordSwapState& state, const PointArrays& centroids) {
    for (int f = 0; f < state.face_count(); ++f) {
        state.own.copy(f, centroids, state.label[f]);
    }
    measure_distances(state);
}

double energy_of(const ChordSwapState& state) {
    return std::accumulate(state.distance.begin(), state.distance.end(), 0.0);
}

} // namespace spheroseg
