// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

/// The method `all_pairs`: the paper's cohesion and refinement from random balanced labels, on the
/// GPU where that is asked for or expected to be faster. The result has labels, iterations, times,
/// `measures_after_cohesion` and `best_max_triangle_count_difference`. Throws InvalidInput where
/// the mesh can not be mapped, DeviceError where only `cuda` is allowed, Cancelled.
Segmentation segment_all_pairs(PreparedMesh& prepared,
                               const SegmentOptions& options,
                               const Deadline& deadline,
                               const Progress& progress);

} // namespace spheroseg
