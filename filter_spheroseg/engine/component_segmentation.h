// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

class AnnealDevice;

/// The method `fast`: shares the sub-meshes among the components (share_submeshes) and segments
/// each component on its own: large ones one after the other on all threads, small ones side by
/// side. Labels are numbered component after component. The result has labels, iterations, times
/// and `best_max_triangle_count_difference`; labels do not depend on the number of threads, nor on
/// `device` (may be null), which anneals the large components or the only one.
Segmentation segment_fast(PreparedMesh& prepared,
                          const SegmentOptions& options,
                          const Deadline& deadline,
                          const Progress& progress,
                          AnnealDevice* device);

} // namespace spheroseg
