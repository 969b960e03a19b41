// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one where passing faces got
/// stuck. A sub-mesh that is off is cut anew (TreeCut): with the neighbour that is nearest to one
/// that can make up for it, which gets what it is off; where those two can not be cut like that,
/// with the next one on that way, too; or, as evenly as possible, with one to four around it. So
/// what is off goes away, or wanders from sub-mesh to sub-mesh until it meets one that can make up
/// for it. All sub-meshes must be connected and free of bowties, and stay so; their boundaries get
/// longer, and their loads are never farther off than before. Rings may open and close, whatever
/// `may_close_rings` says. The cuts that it makes, of large sub-meshes several for each, are taken
/// off `cuts_left`. Returns false when it made no progress for long; when no cuts are left at the
/// end of a round (up to 48 for each sub-mesh that is off); and, when `deadline` (may be null) has
/// expired, after 20,000 faces and a cut more. Deterministic but for the deadline. Throws Cancelled
/// when the progress callback asks for it.
bool recut_to_balance(Patchwork& patchwork,
                      std::int64_t& cuts_left,
                      const Deadline* deadline = nullptr,
                      const Progress& progress = {});

} // namespace spheroseg
