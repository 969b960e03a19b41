// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

namespace spheroseg {

/// Brings the loads of all sub-meshes to `limit` or below, as far as it can: faces are passed along
/// shortest chains of sub-meshes from one above the limit to one that has room, such that no other
/// one comes above it. All sub-meshes stay connected and free of bowties, and no load that was at
/// or below the limit ends above it. Returns true when no load is above the limit any more.
/// Deterministic. Throws Cancelled when the progress callback asks for it.
bool lower_loads(Patchwork& patchwork, int limit, const Progress& progress = {});

/// The largest load.
int heaviest_load(const Patchwork& patchwork);

/// The load below which nothing is gained any more: a thousandth above the mean.
int near_enough(const Patchwork& patchwork);

/// Lowers the heaviest load towards the mean in steps (3 %, 1 %, 0.3 %, 0.1 % above it), each by
/// `lower_loads`, where that gets stuck after annealing with a strong pull towards the mean, and
/// by exchanges that keep below what was reached (`exchanges`, all steps together). Ends when a
/// step is out of reach; then between the last two. The result is the patchwork with the least
/// heaviest load that was met. When the time is up no further step is begun. The phases of all
/// exchanges together are those that `control` allows. Throws Cancelled.
void balance_by_weight(Patchwork& patchwork,
                       const AnnealSchedule& exchanges,
                       const AnnealControl& control);

} // namespace spheroseg
