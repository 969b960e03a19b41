// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "chord_swaps.h"

namespace spheroseg {

/// Iterations without a new least energy after which cohesion gives up.
constexpr int kCohesionPatience = 32;

/// p / |p|, or the origin.
Vec3 unit_or_zero(const Vec3& p);

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

} // namespace spheroseg
