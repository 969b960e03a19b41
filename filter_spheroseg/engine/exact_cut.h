// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "random.h"

#include <vector>

namespace spheroseg {

/// Limits within which a search that fails takes some tens of milliseconds, 0.3 s with the most
/// faces.
constexpr int kMaxFacesToSearch = 1000;
constexpr int kMaxSearchSteps = 20000;

/// Cuts a patchwork of unit weights, in one or several pieces, into connected sub-meshes without
/// bowties of `least` to `most` faces each, by a search with backtracking: sub-mesh after sub-mesh
/// around the face with the fewest free neighbours, such that what is left over can still be
/// parted. Meant for surfaces whose dual graph is nearly a tree, where moves along boundaries get
/// stuck. Gives up after `max_steps` faces were placed (fewer where many others could have been),
/// and after 20 more searches in other orders of a fifth of that each; then it returns false and
/// the labels mean nothing. Deterministic.
bool cut_exactly(Patchwork& patchwork, int least, int most, int max_steps);

/// Cuts the sub-meshes of a region anew by one such search in a random order, into as many whose
/// sizes differ by at most one. Returns false when none was found in `max_steps`; then the labels
/// of the region and their loads mean nothing.
bool cut_evenly(Patchwork& patchwork, const Region& region, int max_steps, Random& random);

} // namespace spheroseg
