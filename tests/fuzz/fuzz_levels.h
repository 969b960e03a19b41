// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg::fuzz {

/// Walks through the levels of every component from the coarsest to the finest, with up to
/// `submesh_count` labels. What does not hold on the way, or null: neighbours are those that share
/// an edge, weights and loads add up, sound sub-meshes stay sound, and the finest level is the
/// mesh.
const char* find_bad_level(PreparedMesh& prepared, int submesh_count, int thread_count);

} // namespace spheroseg::fuzz
