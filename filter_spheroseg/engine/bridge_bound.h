// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// However the faces of a patchwork, of unit weight, are cut into connected sub-meshes, there are
/// at least so many too many or too few, measured at the loads that are asked for: at even_loads a
/// lower bound on misplaced(patchwork). 0 where nothing hangs on the rest by a single edge, as on
/// closed surfaces; at most 1001, whatever the number is.
///
/// A part that hangs on the rest by one edge (a bridge of the dual graph) shares only one sub-mesh
/// with it. For each number of faces that this one may have of the part, the least is counted that
/// is misplaced in the part then, from that of the smaller parts in it: exactly where three of them
/// meet at a face, and as if any cut was possible where faces lie around a vertex. So it is the
/// least of all for meshes whose dual graph is a tree, but for the number of sub-meshes, which may
/// be any.
///
/// O(F) without bridges. Each bridge takes as many steps as there are faces beyond it, and three at
/// a face the products of these numbers, none of them counted further than the largest load + 1000;
/// where it would be more than 100 F + 1e8 steps the bound is 0. Source of the bridges: Tarjan, A
/// Note on Finding the Bridges of a Graph, 1974.
std::int64_t least_misplaced(const Patchwork& patchwork, const LoadRange& asked);

} // namespace spheroseg
