// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

namespace spheroseg {

/// As `anneal`, but what a face would cut off from its sub-mesh goes with it (Branches): where
/// limbs, or the ways between holes, are narrow, single faces and fans bring the loads to balance
/// only by long detours, or not at all. Serial, and slower by far. The schedule is that of one
/// thread. Stops early when `deadline` (may be null) has expired. Throws Cancelled.
void anneal_branches(Patchwork& patchwork,
                     const AnnealSchedule& schedule,
                     const Deadline* deadline,
                     const Progress& progress);

/// Are loads so far off as an annealing with a strong pull towards balance leaves them only where
/// limbs are narrow?
bool is_stuck(const Patchwork& patchwork);

} // namespace spheroseg
