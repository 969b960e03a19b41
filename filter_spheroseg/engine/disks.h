// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// Shrinks sub-meshes to topological disks. A disk grows breadth first inside its sub-mesh, from
/// the face that is farthest from the sub-mesh's boundary, and takes a face only where it neither
/// touches itself nor closes to a ring; the faces that it does not take become unassigned (label
/// -1). Sub-meshes with a non-zero entry in `sound` (one per sub-mesh) keep all their faces. On
/// entry every face is in a sub-mesh. Loads are brought up to date. O(F).
void shrink_to_disks(Patchwork& patchwork, const std::vector<std::uint8_t>& sound);

} // namespace spheroseg
