// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one where the faces hang
/// together by few edges, as in nests (stacked triangulations) and on narrow limbs: there what is
/// off has few ways to go, and recut_to_balance, which cuts few sub-meshes at a time, gets stuck.
///
/// A region around a sub-mesh that is off, so large that its faces can be shared out evenly, is
/// cut anew as a whole; where that fails a larger one, up to all faces. Its faces are joined to
/// blocks, two at a time, such that each block has few outer edges. For each block the ways to cut
/// it are listed from those of the two that it was made of, as far as they differ at its outer
/// edges: which of these lead into the same sub-mesh, and how many faces of it are inside (dynamic
/// programming on a branch decomposition of the dual graph). What a sub-mesh has of a block must
/// not be too large, and where no outer edge leads to it, not too small and without bowties. From
/// long lists some ways are drawn by chance, so that a cut may be missed.
///
/// Only for sub-meshes of at most 250 faces, beyond which the lists are too short, and for regions
/// of at most 65,536 faces whose blocks have at most 12 outer edges; does nothing elsewhere.
///
/// All sub-meshes must be connected and free of bowties, and stay so; no load gets farther from
/// balance. Takes what it does off `work_left`, in pairs of ways that were looked at, and ends when
/// none is left. Returns whether the loads are balanced. Deterministic but for `deadline` (may be
/// null). Throws Cancelled when the progress callback asks for it.
/// Source of the principle: Cook, Seymour, Tour Merging via Branch-Decomposition, 2003.
bool cut_narrow_regions(Patchwork& patchwork,
                        std::int64_t& work_left,
                        const Deadline* deadline = nullptr,
                        const Progress& progress = {});

} // namespace spheroseg
