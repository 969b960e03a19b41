// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

namespace spheroseg {

/// Makes every sub-mesh edge-connected and free of bowties, whatever the labels (each in
/// [0, submesh_count)): unassigns the faces in the way (free_faults), gives empty sub-meshes a
/// face, and grows all of them over the unassigned faces. Where `may_close_rings` is false,
/// sub-meshes are shrunk to disks first (shrink_to_disks); if faces are left over in the end, it is
/// set and the repair starts again. Loads are brought up to date; they may be far from balanced.
///
/// Returns the number of faces that no sub-mesh could take without a bowtie: they got the label of
/// a neighbour nevertheless. `may_be_unsound` tells whether there are any.
int repair(Patchwork& patchwork);

/// The same, but sub-meshes that are sound already (sound_submeshes) keep all their faces as far as
/// possible. On entry every face is in a sub-mesh.
int repair_unsound(Patchwork& patchwork);

} // namespace spheroseg
