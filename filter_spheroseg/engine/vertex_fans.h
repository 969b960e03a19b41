// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

#include <algorithm>

namespace spheroseg {

/// A corner (3 * face + corner) of a vertex, and the side of its face by which a walk around the
/// vertex leaves it.
struct FanStep {
    int corner;
    int exit;
};

/// The next step of a walk around a vertex; its corner is -1 where the dual graph ends. Corners and
/// steps make paths and cycles: a walk comes to no corner twice before it is at its first one
/// again.
inline FanStep next_step(const TriangleMesh& mesh, const DualGraph& dual_graph, FanStep step) {
    const int face = step.corner / 3;
    const int corner = step.corner % 3;
    const int next = dual_graph.neighbors[face][step.exit];
    if (next < 0) {
        return {-1, 0};
    }
    const int far = mesh.faces[face][step.exit == corner ? (step.exit + 1) % 3 : step.exit];
    const Triangle& entered = mesh.faces[next];
    const int at = corner_of(entered, mesh.faces[face][corner]);
    return {3 * next + at, entered[(at + 1) % 3] == far ? (at + 2) % 3 : at};
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
    /// Appends the corners beyond the side `exit` of a corner's face; true when they lead back.
    bool follow(int start, int exit, std::vector<int>& corners) {
        FanStep step = {start, exit};
        for (;;) {
            step = next_step(mesh_, dual_graph_, step);
            if (step.corner < 0) {
                return false;
            }
            if (visited_[step.corner]) {
                return step.corner == start;
            }
            visited_[step.corner] = 1;
            corners.push_back(step.corner);
        }
    }

    const TriangleMesh& mesh_;
    const DualGraph& dual_graph_;
    std::vector<std::uint8_t> visited_;
};

} // namespace spheroseg
