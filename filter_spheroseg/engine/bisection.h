// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// Labels the cells by recursive level-set bisection of their dual graph: each part is ordered
/// breadth first from a pseudo-peripheral face (the last one of an earlier search), and cut where
/// the weights of the two sides are proportional to the numbers of sub-meshes that they will hold.
/// Every label in [0, submesh_count) gets at least one face, if there are as many; sub-meshes may
/// come out disconnected. O(F log k), parallel; the result does not depend on the number of
/// threads. `seed` shifts where each search begins. Throws Cancelled; the patchwork is unchanged
/// then.
void bisect(Patchwork& patchwork,
            int submesh_count,
            std::uint64_t seed,
            int thread_count,
            const Progress& progress = {});

/// One level of that recursion, on labels that may have changed since the last one. parts[l] >= 1
/// is the number of sub-meshes that sub-mesh l is still to become. Each with parts[l] > 1 is cut
/// into a side for parts[l] / 2 of them, which keeps the label, and a side for the others, which
/// gets the next new label; `parts` and loads are brought up to date. A sub-mesh with fewer cells
/// than parts may leave an empty one.
void cut_in_two(Patchwork& patchwork, std::vector<int>& parts, std::uint64_t seed);

} // namespace spheroseg
