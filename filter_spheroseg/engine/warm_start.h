// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"

#include <cstdint>

namespace spheroseg {

/// Makes labels that somebody else chose (each in [0, submesh_count) or -1: that of the nearest
/// face that has one; on the finest level) a start for the refinement: every sub-mesh
/// edge-connected and free of bowties, with a load between half and twice the mean as far as that
/// is possible. Sound sub-meshes of such loads keep their faces. Of the others the largest piece
/// stays; those that are too light are dissolved, and those that are too heavy are parted by
/// bisection, where the first part keeps the label and the others get the labels that became free.
/// Loads are brought up to date. The patchwork is marked as by `repair` where that left a bowtie.
/// Deterministic; `seed` shifts bisections. Throws Cancelled when the progress callback asks for
/// it.
void adopt_labels(Patchwork& patchwork, std::uint64_t seed, const Progress& progress = {});

/// Gives `labels` new names (numbers in [0, submesh_count)) so that many faces have the name that
/// they have in `names` (-1: none): pairs of old and new name with the most common faces first.
/// To do it again changes nothing.
void rename_like(std::vector<int>& labels, const std::vector<int>& names, int submesh_count);

/// Number of different labels.
int distinct_label_count(const std::vector<int>& labels);

/// The labels numbered 0, 1, ... in increasing order, without gaps.
std::vector<int> compacted(const std::vector<int>& labels);

} // namespace spheroseg
