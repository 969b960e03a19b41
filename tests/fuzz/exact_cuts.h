// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "recount.h"

namespace spheroseg::fuzz {

enum class Answer { no, yes, unknown };

/// Whether connected sub-meshes without bowties exist whose triangle counts differ by at most
/// `count_difference`: an exhaustive search over all of them, for 64 faces at most and as far as a
/// bounded number of steps goes.
Answer can_be_cut(const Surface& surface, int submesh_count, int count_difference);

} // namespace spheroseg::fuzz
