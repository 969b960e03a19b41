// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

namespace spheroseg {

/// Coherent start: labels 0 .. submesh_count - 1 by recursive bisection of the points across their
/// principal axis. The counts of the labels differ by at most one (`submesh_count` in [1, F]).
/// O(F log submesh_count); the same on every run.
std::vector<int> balanced_sphere_labels(const std::vector<Vec3>& face_centroids, int submesh_count);

} // namespace spheroseg
