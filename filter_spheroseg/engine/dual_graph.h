// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

#include <cstddef>

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

/// Throws InvalidInput when a mesh has more than kMaxFaces faces or 2^30 vertices.
void check_size(std::size_t face_count, std::size_t vertex_count);

/// Builds the dual graph in O(F log d), in parallel; d: edges of a vertex, at most. Two faces are
/// joined across an edge when it has no third one, however they are oriented; of an edge with more
/// faces no pair is joined (-1). Throws InvalidInput when the mesh is too large or a vertex index
/// is out of range. The result does not depend on the number of threads.
DualGraph build_dual_graph(const TriangleMesh& mesh, int thread_count = 0);

/// Faces that hang together, numbered in the order of their first faces.
struct FaceComponents {
    std::vector<int> of_face;
    std::vector<int> first_face;

    int count() const { return static_cast<int>(first_face.size()); }
};

/// The components that are left of the dual graph with the arcs between faces f and g for which
/// `joined(f, g)` is true. O(F).
template <typename Joined>
FaceComponents face_components(const DualGraph& dual_graph, Joined joined) {
    FaceComponents components;
    components.of_face.assign(dual_graph.neighbors.size(), -1);
    std::vector<int> stack;
    for (int first = 0; first < dual_graph.face_count(); ++first) {
        if (components.of_face[first] >= 0) {
            continue;
        }
        const int number = components.count();
        components.first_face.push_back(first);
        components.of_face[first] = number;
        stack.push_back(first);
        while (!stack.empty()) {
            const int f = stack.back();
            stack.pop_back();
            for (int g : dual_graph.neighbors[f]) {
                if (g >= 0 && components.of_face[g] < 0 && joined(f, g)) {
                    components.of_face[g] = number;
                    stack.push_back(g);
                }
            }
        }
    }
    return components;
}

/// The components of the whole dual graph.
inline FaceComponents face_components(const DualGraph& dual_graph) {
    return face_components(dual_graph, [](int, int) { return true; });
}

} // namespace spheroseg
