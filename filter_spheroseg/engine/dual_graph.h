// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

namespace spheroseg {

/// Dual graph of a triangle mesh: one node per face, one arc per pair of faces that share an edge.
/// `neighbors[f][c]` is the face on the other side of the edge from corner c to corner (c + 1) % 3
/// of face f, or -1 on an open border.
struct DualGraph {
    std::vector<std::array<int, 3>> neighbors;
    /// Edges of the mesh, each counted once, however many faces meet there.
    int edge_count = 0;

    int face_count() const { return static_cast<int>(neighbors.size()); }
};

/// What is known of the fans of faces that the dual graph joins around each vertex. One per vertex,
/// as in a manifold mesh (see MeshReport), saves walking around those inside a sub-mesh.
enum class VertexFanCount { unknown, one };

/// Builds the dual graph in O(F), in parallel. Two faces are joined across an edge when it has no
/// third one, however they are oriented; of an edge with more faces no pair is joined (-1).
/// Throws InvalidInput when a vertex index is out of range. The result does not depend on the
/// number of threads.
DualGraph build_dual_graph(const TriangleMesh& mesh, int thread_count = 0);

} // namespace spheroseg
