// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// For each sub-mesh whether it is sound: 1 when it has a face, is edge-connected and has no
/// bowtie, else 0. On entry every face is in a sub-mesh. O(F).
std::vector<std::uint8_t> sound_submeshes(const Patchwork& patchwork);

/// Are all entries of such a list non-zero?
bool are_all_sound(const std::vector<std::uint8_t>& sound_submeshes);

/// Are all sub-meshes sound? Examines the labels; does not trust `may_be_unsound`. O(F).
bool is_sound(const Patchwork& patchwork);

} // namespace spheroseg
