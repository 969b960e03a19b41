// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

namespace spheroseg {

/// Lloyd's relaxation on the dual graph: in each iteration the centre of a sub-mesh is a face
/// farthest from its boundary, and each face joins the sub-mesh whose centre is nearest, by steps
/// between neighbours plus an offset per sub-mesh that grows while the sub-mesh is too heavy. Makes
/// sub-meshes rounder and loads more even; every sub-mesh keeps at least its centre and becomes
/// edge-connected. Loads must be up to date on entry, and are afterwards.
///
/// `control` limits and records iterations as if they were phases; the recorded numbers of boundary
/// edges are those before each iteration. O(iterations * F); parallel, the result does not depend
/// on the number of threads. Throws Cancelled. Source: Lloyd, Least Squares Quantization in PCM,
/// 1982.
void relax(Patchwork& patchwork, int iterations, int thread_count, const AnnealControl& control);

} // namespace spheroseg
