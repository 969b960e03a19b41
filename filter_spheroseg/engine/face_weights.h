// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "options.h"
#include "types.h"

namespace spheroseg {

/// Throws InvalidOptions unless the weights that `options` ask for are one per face, all finite and
/// not negative, and at least one above 0; the message has the count of what is wrong and the first
/// face.
void check_face_weights(const SegmentOptions& options, const TriangleMesh& mesh);

/// Areas of the triangles; in units of the square of twice the largest coordinate, so that none
/// overflows.
std::vector<double> face_areas(const TriangleMesh& mesh);

/// The weights that `options` ask for: face_weights, or areas when there are none.
std::vector<double> weights_of(const SegmentOptions& options, const TriangleMesh& mesh);

/// The load that the sub-meshes of a surface would have if it could be cut anywhere but through
/// faces: T with k T = sum of min(weight, T). A face that weighs T or more fills a sub-mesh alone,
/// and the others share the rest. T over the heaviest weight, so that huge weights do not overflow;
/// 0 when fewer than k faces weigh anything. O(F log F).
double ideal_over_heaviest(const std::vector<double>& weights, int submesh_count);

/// The part of the ideal load T that each face makes: min(weight, T) / T. Where fewer than k faces
/// weigh anything, each of these fills a sub-mesh. Weights above T are cut to T because more would
/// only pull the others' mean away from what they can reach.
std::vector<double> load_shares(const std::vector<double>& weights, int submesh_count);

/// Weights as whole numbers >= 1 whose sum is below 2^30: the shares of the ideal load in units of
/// k / 2^29 of it, rounded; a zero counts as one unit. The load of n faces is off by at most n
/// units.
std::vector<int> quantized_weights(const std::vector<double>& weights, int submesh_count);

/// Heaviest sub-mesh over mean load, at least 1.
double weight_imbalance(const std::vector<double>& weights,
                        const std::vector<int>& labels,
                        int submesh_count);

} // namespace spheroseg
