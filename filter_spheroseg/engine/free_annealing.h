// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

namespace spheroseg {

/// The same annealing of single faces as `anneal`, but sub-meshes may come apart and have bowties
/// on the way, so that boundaries find their way through holes and over handles, which they can
/// not do while all stay connected. No sub-mesh loses its last face. Meant for a start on a coarse
/// mesh, with `repair` after it. Runs on one thread; stops early when `deadline` has expired.
void anneal_freely(Patchwork& patchwork, const AnnealSchedule& schedule, const Deadline& deadline);

} // namespace spheroseg
