// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// Leaves each sub-mesh, but those with a non-zero entry in `sound`, what grows without closing a
/// ring from that face of it which is farthest from its boundary; the other faces become free
/// (label -1). Every face is in a sub-mesh; loads are brought up to date. O(F).
void shrink_to_disks(Patchwork& patchwork, const std::vector<std::uint8_t>& sound);

} // namespace spheroseg
