// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "random.h"

#include <vector>

namespace spheroseg {

/// Limits for callers of cut_exactly: within them a search that fails takes some tens of
/// milliseconds, 0.3 s with kMaxFacesToSearch faces.
constexpr int kMaxFacesToSearch = 1000;
constexpr int kMaxSearchSteps = 20000;

/// Cuts a patchwork of unit weights, connected or not, into connected sub-meshes without bowties of
/// `least` to `most` faces each, by backtracking: sub-meshes are grown one after the other, each
/// from the unassigned face with the fewest unassigned neighbours, and a branch of the search is
/// left when the sizes of the pieces of unassigned faces rule out a solution. Meant for surfaces
/// whose dual graph is nearly a tree, where moves along boundaries get stuck. Gives up after
/// `max_steps` faces were placed (a step counts for more where many other faces could have been
/// placed), and after 20 more searches in other orders with a fifth of the steps each; then it
/// returns false and the labels are undefined. Deterministic.
bool cut_exactly(Patchwork& patchwork, int least, int most, int max_steps);

/// Cuts a region anew, by one such search in a random order, into as many sub-meshes as it has,
/// whose sizes differ by at most one. Returns false when no cut was found in `max_steps`; then the
/// labels of the region and their loads are undefined.
bool cut_evenly(Patchwork& patchwork, const Region& region, int max_steps, Random& random);

} // namespace spheroseg
