// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>
#include <limits>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one, by passing single faces
/// along shortest chains of sub-meshes from one that has too many to one that has too few, each
/// time the face that costs the fewest boundary edges; where many chains break, along chains whose
/// passes are planned one on the other (PlannedChains). All sub-meshes stay connected and free of
/// bowties, and their loads are never farther off than before. Goes on as long as that takes off a
/// good part of what is off each time, `deadline` (may be null) has not expired, and about
/// `most_work` faces were not yet looked at. Returns false when anything is left: see
/// recut_to_balance. Deterministic but for the deadline. Throws Cancelled when the progress
/// callback asks for it.
bool balance_exactly(Patchwork& patchwork,
                     const Deadline* deadline = nullptr,
                     const Progress& progress = {},
                     std::int64_t most_work = std::numeric_limits<std::int64_t>::max());

/// After balance_exactly and recut_to_balance: are so many sub-meshes off that there is hardly a
/// balance to be found?
bool is_hopeless(const Patchwork& patchwork);

/// With unit weights: are at most a tenth of all faces too many where they are?
bool is_near_balance(const Patchwork& patchwork);

} // namespace spheroseg
