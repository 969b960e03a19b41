// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// Unassigns (label -1) the faces that keep sub-meshes from being edge-connected and free of
/// bowties: all but the largest piece of each sub-mesh, and all but its largest fan around each
/// vertex. Sub-meshes with a non-zero entry in `sound` (one per sub-mesh) are both already and keep
/// all their faces. Faces may be unassigned on entry. Loads are brought up to date. O(F).
void free_faults(Patchwork& patchwork, const std::vector<std::uint8_t>& sound);

} // namespace spheroseg
