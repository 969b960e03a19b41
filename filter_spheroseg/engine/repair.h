// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

namespace spheroseg {

/// Makes every sub-mesh edge-connected and free of bowties, whatever the labels (each in
/// [0, submesh_count)): frees all but the largest piece of each sub-mesh and all but its largest
/// fan around each vertex, gives empty sub-meshes a face, and grows all of them over what is free.
/// Where the patchwork does not allow rings around limbs, holes and handles, it keeps what grows
/// without one from the deepest face of each sub-mesh; where faces are left over then, it is made
/// to allow them. Loads are brought up to date; they may be far from balanced. Returns the number
/// of faces that no sub-mesh could take without a bowtie; these got the label of a neighbour
/// nevertheless, and the patchwork is marked (`may_be_unsound`) if there are any.
int repair(Patchwork& patchwork);

/// The same, but sub-meshes that are edge-connected and free of bowties already keep all their
/// faces. Every face is in a sub-mesh.
int repair_unsound(Patchwork& patchwork);

} // namespace spheroseg
