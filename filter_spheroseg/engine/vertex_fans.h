// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

#include <algorithm>

namespace spheroseg {

/// Walks around the vertex of corner `start` (3 * face + corner), leaving its face across the side
/// `exit`, one of the two at that corner. Calls visit(corner) for each further corner of the fan,
/// in order. Returns true when the walk comes back to `start`, false when it ends at a side across
/// which the dual graph has no neighbour. Works for any orientation of the faces; the dual graph
/// must not join faces that name a vertex twice.
template <typename Visit>
bool follow_fan(const TriangleMesh& mesh,
                const DualGraph& dual_graph,
                int start,
                int exit,
                const Visit& visit) {
    const int vertex = mesh.faces[start / 3][start % 3];
    for (int corner = start;;) {
        const int face = corner / 3;
        const int next = dual_graph.neighbors[face][exit];
        if (next < 0) {
            return false;
        }
        const int far = mesh.faces[face][exit == corner % 3 ? (exit + 1) % 3 : exit];
        const Triangle& entered = mesh.faces[next];
        const int at = corner_of(entered, vertex);
        corner = 3 * next + at;
        if (corner == start) {
            return true;
        }
        visit(corner);
        exit = entered[(at + 1) % 3] == far ? (at + 2) % 3 : at;
    }
}

/// The fans of a mesh: the faces around a vertex that the dual graph joins. A manifold vertex has
/// one; where an input is pinched, a vertex has several. Needs no common orientation of the faces.
class VertexFans {
public:
    VertexFans(const TriangleMesh& mesh, const DualGraph& dual_graph)
        : mesh_(mesh), dual_graph_(dual_graph), visited_(3 * mesh.faces.size(), 0) {}

    /// The corners (3 * face + corner) of one fan in the order in which they lie side by side.
    struct Fan {
        std::vector<int> corners;
        /// The last one lies beside the first one too.
        bool closed = false;
    };

    /// Collects the fan of a corner into `fan`; false when it was collected before. O(its size).
    bool collect(int corner, Fan& fan) {
        if (visited_[corner]) {
            return false;
        }
        fan.corners.assign(1, corner);
        visited_[corner] = 1;
        fan.closed = follow(corner, corner % 3, fan.corners);
        if (!fan.closed) {
            std::reverse(fan.corners.begin(), fan.corners.end());
            follow(corner, (corner % 3 + 2) % 3, fan.corners);
        }
        return true;
    }

private:
    bool follow(int corner, int exit, std::vector<int>& corners) {
        return follow_fan(mesh_, dual_graph_, corner, exit, [&](int beyond) {
            visited_[beyond] = 1;
            corners.push_back(beyond);
        });
    }

    const TriangleMesh& mesh_;
    const DualGraph& dual_graph_;
    std::vector<std::uint8_t> visited_;
};

} // namespace spheroseg
