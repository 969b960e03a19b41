// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

namespace spheroseg {

/// Lloyd's relaxation on the dual graph (Lloyd: Least Squares Quantization in PCM, 1982): each
/// sub-mesh is replaced by the faces nearest to its deepest face, counted in steps between
/// neighbours plus an offset that grows while the sub-mesh is too heavy. Rounds the sub-meshes and
/// evens out their loads; every sub-mesh keeps at least its centre and stays edge-connected.
/// O(iterations * F); parallel, the same for any number of threads. Throws Cancelled.
/// Loads must be up to date. Of `control` the phases are the iterations; boundary edges are those
/// before each.
void relax(Patchwork& patchwork, int iterations, int thread_count, const AnnealControl& control);

} // namespace spheroseg
