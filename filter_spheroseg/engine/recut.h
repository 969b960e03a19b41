// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>

namespace spheroseg {

/// Makes the loads of a patchwork of unit weights differ by at most one where passing faces got
/// stuck. A sub-mesh that is off is cut anew together with one to four around it, as evenly as
/// possible (cut_evenly). So what is off goes away, or wanders from sub-mesh to sub-mesh until it
/// meets one that can make up for it. All sub-meshes must be connected and free of bowties, and
/// stay so; their boundaries get longer. Returns false when it made no progress for long, about
/// `cuts_left` cuts were made, of which those that were are taken off, or, when `deadline` (may be
/// null) is overdue, soon. The loads are never farther off than before. Deterministic but for the
/// deadline. Throws Cancelled when the progress callback asks for it.
bool recut_to_balance(Patchwork& patchwork,
                      std::int64_t& cuts_left,
                      const Deadline* deadline = nullptr,
                      const Progress& progress = {});

} // namespace spheroseg
