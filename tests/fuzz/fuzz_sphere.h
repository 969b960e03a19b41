// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg::fuzz {

/// Maps a closed mesh of genus 0 to the sphere and swaps faces between sub-meshes there. What does
/// not hold, or null: the map is one, maps with a fault are refused, swaps keep the counts and do
/// not depend on the number of threads.
const char* find_bad_sphere(PreparedMesh& prepared, int seed, int thread_count);

} // namespace spheroseg::fuzz
