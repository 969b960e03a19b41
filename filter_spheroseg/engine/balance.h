// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>
#include <limits>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one: single faces are passed
/// along shortest chains of adjacent sub-meshes, from one with too many faces to one with too few,
/// at each step the face that costs the fewest boundary edges. Where many chains break, the passes
/// of a chain are planned on each other (PlannedChains). All sub-meshes stay connected and free of
/// bowties; where a chain breaks its face stays, so that a load in between may end farther from
/// balance than it was.
///
/// Ends when the loads are balanced, when a round removes too small a part of the imbalance, when
/// `deadline` (may be null) has expired, or when about `most_work` faces were looked at; then what
/// is begun, a chain with all faces that it carries or a round of planned chains, is finished.
/// Returns whether the loads are balanced; recut_to_balance is the next resort. Deterministic but
/// for the deadline. Throws Cancelled when the progress callback asks for it.
bool balance_exactly(Patchwork& patchwork,
                     const Deadline* deadline = nullptr,
                     const Progress& progress = {},
                     std::int64_t most_work = std::numeric_limits<std::int64_t>::max());

/// After balance_exactly and recut_to_balance: are so many sub-meshes out of balance still that
/// more tries from here are very unlikely to balance them?
bool is_hopeless(const Patchwork& patchwork);

} // namespace spheroseg
