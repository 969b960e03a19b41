// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

namespace spheroseg {

/// Makes every sub-mesh edge-connected and free of bowties, whatever the labels (each in
/// [0, submesh_count)): keeps of each sub-mesh what grows without a bowtie from its face that
/// lies deepest, gives empty sub-meshes a face, and grows all of them over what is left. They close
/// around limbs, holes and handles where they did before, if the patchwork allows that; where faces
/// are left over otherwise, it is made to allow it.
/// Loads are brought up to date; they may be far from balanced. Returns the number of faces that
/// no sub-mesh could take without a bowtie; these got the label of a neighbour nevertheless, and
/// the patchwork is marked (`may_be_unsound`) if there are any.
int repair(Patchwork& patchwork);

/// The same, but sub-meshes that are edge-connected and free of bowties already keep all their
/// faces. Every face is in a sub-mesh.
int repair_unsound(Patchwork& patchwork);

} // namespace spheroseg
