// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

#include <common/parameters/rich_parameter_list.h>

namespace spheroseg {

/// The dialog of the segmentation filter for a mesh of `face_count` faces.
RichParameterList segmentation_parameters(int face_count);

/// Throws InvalidOptions for a submesh_count below 1 where it counts: without initial labels and
/// triangles_per_submesh. The engine's `validate` checks the rest against the mesh.
SegmentOptions segment_options(const RichParameterList& parameters);

/// Are `initial_labels` to be read from the face quality?
bool starts_from_face_quality(const RichParameterList& parameters);

RichParameterList parametrization_parameters();

} // namespace spheroseg
