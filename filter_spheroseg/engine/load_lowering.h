// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

namespace spheroseg {

/// Brings the loads of all sub-meshes to `limit` or below, as far as it can: faces are passed along
/// shortest chains of sub-meshes from one above the limit to one that has room, such that no other
/// one comes above it. All sub-meshes stay connected and free of bowties, and no load that was at
/// or below the limit ends above it. Ends early when `deadline` (may be null) has expired. Returns
/// true when no load is above the limit any more. Deterministic but for the deadline. Throws
/// Cancelled when the progress callback asks for it.
bool lower_loads(Patchwork& patchwork,
                 int limit,
                 const Deadline* deadline = nullptr,
                 const Progress& progress = {});

} // namespace spheroseg
