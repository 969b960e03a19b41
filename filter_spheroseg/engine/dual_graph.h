// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

namespace spheroseg {

/// Dual graph of a triangle mesh: one node per face, one arc per pair of faces that share an edge.
/// `neighbors[f][c]` is the face on the other side of the edge from corner c to corner (c + 1) % 3
/// of face f, or -1 on an open border.
struct DualGraph {
    std::vector<std::array<int, 3>> neighbors;

    int face_count() const { return static_cast<int>(neighbors.size()); }
};

/// Builds the dual graph in O(F), in parallel. Of an edge with more than two faces, or with two
/// faces that run along it in the same direction, no pair is joined (-1): `inspect` reports them.
/// Throws InvalidInput when a vertex index is out of range. The result does not depend on the
/// number of threads.
DualGraph build_dual_graph(const TriangleMesh& mesh, int thread_count = 0);

} // namespace spheroseg
