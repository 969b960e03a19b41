// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// Labels the cells by recursive level-set bisection of their dual graph: each part of the graph
/// is ordered breadth first from a face at its end, and cut where the weights of both sides are as
/// the numbers of sub-meshes that they will hold. Every label in [0, submesh_count) gets at least
/// one face, if there are as many; sub-meshes may come out disconnected. O(F log k), parallel; the
/// result does not depend on the number of threads. `seed` shifts where each search begins.
/// Throws Cancelled; the patchwork is as before then.
void bisect(Patchwork& patchwork,
            int submesh_count,
            std::uint64_t seed,
            int thread_count,
            const Progress& progress = {});

/// One step of that, on labels that may have changed since the last one: cuts every sub-mesh l with
/// parts[l] > 1 into parts[l] / 2 and the rest of its parts, as their weights are. The first side
/// keeps the label, the other gets the next new one; `parts` (one entry >= 1 per sub-mesh) and
/// loads are brought up to date. A sub-mesh with fewer cells than parts may leave an empty one.
void cut_in_two(Patchwork& patchwork, std::vector<int>& parts, std::uint64_t seed);

} // namespace spheroseg
