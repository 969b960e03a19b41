// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>

namespace spheroseg {

/// Turns labels of any origin into a start for the refinement: afterwards every sub-mesh is
/// edge-connected and free of bowties and has a load between half and twice the mean, as far as
/// that is possible. `patchwork` is on the finest level, its labels are in [0, submesh_count) or
/// -1; a face with -1 takes the label of the nearest face that has one.
///
/// Sound sub-meshes with such loads keep their faces. Of the others the largest piece stays; those
/// that are too light are dissolved, and those that are too heavy are divided by bisection: the
/// first part keeps the label, the others get labels that became free. Loads are brought up to
/// date; `may_be_unsound` is set as by `repair`. Deterministic; `seed` shifts the bisections.
/// Reports progress with the value 0. Throws Cancelled when the callback asks for it.
void adopt_labels(Patchwork& patchwork, std::uint64_t seed, const Progress& progress = {});

/// Renumbers `labels` by a permutation of [0, submesh_count) so that many faces get the label that
/// they have in `names` (-1: none). Greedy: pairs of a label and a name are matched in the order of
/// the faces that they have in common, the most first. Idempotent. O(F log F).
void rename_like(std::vector<int>& labels, const std::vector<int>& names, int submesh_count);

/// Number of different labels.
int distinct_label_count(const std::vector<int>& labels);

/// The labels numbered 0, 1, ... in increasing order, without gaps.
std::vector<int> compacted(const std::vector<int>& labels);

} // namespace spheroseg
