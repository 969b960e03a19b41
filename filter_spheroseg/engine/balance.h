// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one, by passing single faces
/// along shortest chains of sub-meshes from one that has too many to one that has too few, each
/// time the face that costs the fewest boundary edges; where many chains break, along chains whose
/// passes are planned one on the other (PlannedChains), and at last by passing faces together with
/// what would be cut off (Branches). All sub-meshes stay connected and
/// free of bowties. Returns false when it got stuck before that; the patchwork is still as good as
/// it can be made this way. Gives up when about `max_work` faces of boundaries were looked at, and,
/// when `deadline` (may be null) is overdue, as soon as it makes no progress. Deterministic but for
/// that. Throws Cancelled when the progress callback asks for it.
bool balance_exactly(Patchwork& patchwork,
                     std::int64_t max_work = std::int64_t{1} << 62,
                     const Deadline* deadline = nullptr,
                     const Progress& progress = {});

/// With unit weights: are at most a tenth of all faces too many where they are?
bool is_near_balance(const Patchwork& patchwork);

} // namespace spheroseg
