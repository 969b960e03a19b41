// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "chord_swaps.h"

namespace spheroseg {

/// p / |p|, or the origin.
Vec3 unit_or_zero(const Vec3& p);

/// Centroid of each face on the sphere, projected onto it.
std::vector<Vec3> face_centroids_on_sphere(const TriangleMesh& mesh,
                                           const std::vector<Vec3>& sphere_positions);

/// State with the faces and labels set, but not yet `own` and `distance`.
ChordSwapState make_cohesion_state(const std::vector<Vec3>& face_centroids,
                                   const std::vector<int>& labels);

/// Mean centroid of the faces of each sub-mesh, projected onto the sphere (the origin when it has
/// no direction), in single precision. Depends on the sets of faces only, not on their order.
PointArrays submesh_centroids(const ChordSwapState& state, int submesh_count);

/// Sets `own` and `distance` of every face.
void assign_centroids(ChordSwapState& state, const PointArrays& centroids);

/// Sum of the distances, in double precision and in the order of the faces.
double energy_of(const ChordSwapState& state);

/// When cohesion gives up: after so many iterations without a new least energy.
class LeastEnergy {
public:
    explicit LeastEnergy(double energy) : least_(energy) {}

    /// To be told of the energy after each iteration. False: give up.
    bool may_fall_after(double energy) {
        ++idle_iterations_;
        if (energy < least_) {
            least_ = energy;
            idle_iterations_ = 0;
        }
        return idle_iterations_ < kPatience;
    }

private:
    static constexpr int kPatience = 32;

    double least_;
    int idle_iterations_ = 0;
};

} // namespace spheroseg
