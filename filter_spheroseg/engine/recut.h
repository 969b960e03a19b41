// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"
#include "tree_cut.h"

#include <cstdint>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one where balance_exactly got
/// stuck, by cutting small regions into sub-meshes anew (TreeCut, cut_evenly).
///
/// A region is a sub-mesh with a wrong load and (a) the neighbour that is nearest to a sub-mesh
/// which can compensate: the neighbour takes over the deviation or a part of it; (b) where the two
/// can not be cut like that, also the next one on the way there, which takes it over; or (c) one to
/// four sub-meshes around it: the region is cut as evenly as possible. So a deviation vanishes, or
/// wanders until it meets one of the opposite sign.
///
/// All sub-meshes must be connected and free of bowties, and stay so. Their boundaries get longer;
/// all loads together get no farther from balance (`misplaced`), a single one may. Rings may open
/// and close, whatever `may_close_rings` says. Each cut is taken off `cuts_left`; one of a large
/// region counts as several. Returns whether the loads are balanced; false after many cuts without
/// progress, when no cuts are left at the end of a round (up to 48 for each sub-mesh that is off),
/// when no more than `least_misplaced` faces are too many or too few, and at most 20,000 faces and
/// a cut after `deadline` (may be null) has expired. Deterministic but for the deadline. Throws
/// Cancelled when the progress callback asks for it.
bool recut_to_balance(Patchwork& patchwork,
                      std::int64_t& cuts_left,
                      TreeTurns turns = TreeTurns::random,
                      const Deadline* deadline = nullptr,
                      const Progress& progress = {},
                      std::int64_t least_misplaced = 0);

} // namespace spheroseg
