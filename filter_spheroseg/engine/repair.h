// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// Makes every sub-mesh edge-connected and free of bowties, whatever the labels (each in
/// [0, submesh_count)): keeps of each sub-mesh what grows without a bowtie from its face that
/// lies deepest, gives empty sub-meshes a face, and grows all of them over what is left. They close
/// around limbs, holes and handles where they did before, if the patchwork allows that.
/// Loads are brought up to date; they may be far from balanced. Returns the number of faces that
/// no sub-mesh could take without a bowtie; these got the label of a neighbour nevertheless.
int repair(Patchwork& patchwork);

/// The same, but the sub-meshes with a non-zero entry in `sound` (one entry per sub-mesh), which
/// have a face, are edge-connected and free of bowties, keep all their faces.
int repair(Patchwork& patchwork, const std::vector<std::uint8_t>& sound);

} // namespace spheroseg
