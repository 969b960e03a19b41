// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// For each sub-mesh whether it has a face, is edge-connected and free of bowties. Every face is in
/// a sub-mesh. O(F).
std::vector<std::uint8_t> sound_submeshes(const Patchwork& patchwork);

bool are_all_sound(const std::vector<std::uint8_t>& sound_submeshes);

/// Is that so for all of them, whatever was repaired?
bool is_sound(const Patchwork& patchwork);

} // namespace spheroseg
