// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>

namespace spheroseg {

/// The seed of a start of `fast`, from that of the user. Start 0 has the user's.
constexpr std::uint64_t seed_of_start(std::uint64_t seed, int start) {
    return seed + 0x9E3779B9ULL * static_cast<std::uint64_t>(start);
}

/// The seed of a trial, from that of its start. Trial 0 has the start's.
constexpr std::uint64_t seed_of_trial(std::uint64_t seed, int trial) {
    return seed + 0x51ED270BULL * static_cast<std::uint64_t>(trial);
}

/// What the steps of a start add to its seed, or to that of the step that they are a part of. The
/// levels begin at the seed itself. A step counts on by ones, per level, cut or try, of which there
/// are fewer than lie between two steps.
namespace seed_offset {
constexpr std::uint64_t kShaking = 1000;
constexpr std::uint64_t kExchanges = 2000;
constexpr std::uint64_t kBranches = 3000;
constexpr std::uint64_t kRounds = 4000;
} // namespace seed_offset

} // namespace spheroseg
