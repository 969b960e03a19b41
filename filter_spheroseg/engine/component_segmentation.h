// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

class AnnealDevice;

/// The method `fast`: shares the sub-meshes among the components (share_submeshes) and segments
/// each component on its own: large ones one after the other on all threads, small ones side by
/// side. Labels are numbered component after component. Fills labels, iterations and times of
/// `result`; the labels do not depend on the number of threads, nor on `device` (may be null),
/// which anneals the large components or the only one.
void segment_fast(PreparedMesh& prepared,
                  const SegmentOptions& options,
                  int submesh_count,
                  const Deadline& deadline,
                  const Progress& progress,
                  AnnealDevice* device,
                  Segmentation& result);

} // namespace spheroseg
