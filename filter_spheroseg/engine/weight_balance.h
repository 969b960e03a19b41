// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

namespace spheroseg {

/// The largest load.
int heaviest_load(const Patchwork& patchwork);

/// The load below which nothing is gained any more: a thousandth above the mean.
int near_enough(const Patchwork& patchwork);

/// Lowers the heaviest load towards the mean in steps (3 %, 1 %, 0.3 %, 0.1 % above it), each by
/// `lower_loads`, where that gets stuck after annealing with a strong pull towards the mean, and
/// by exchanges that keep below what was reached (`exchanges`, all steps together). Ends when a
/// step is out of reach; then between the last two. The result is the patchwork with the least
/// heaviest load that was met, or one that is near enough. When the time of `control` is up no
/// further step is begun and the running one ends; but the first one begins in any case, and lowers
/// loads until `first_deadline` (may be null). The phases of all exchanges together are those that
/// `control` allows. Throws Cancelled.
void balance_by_weight(Patchwork& patchwork,
                       const AnnealSchedule& exchanges,
                       const AnnealControl& control,
                       const Deadline* first_deadline = nullptr);

} // namespace spheroseg
