// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

#include <algorithm>
#include <limits>

namespace spheroseg {

/// A mesh that shrinks by half-edge collapses; the working storage of build_hierarchy. Each hole is
/// closed by a cap: one triangle, or a fan of triangles around an added vertex, one for each border
/// edge. Vertices and faces of caps are numbered after those of the input, and such faces weigh
/// nothing.
struct CollapseMesh {
    struct Face {
        Triangle vertices;
        /// As in DualGraph.
        std::array<int, 3> neighbors;
        /// Number of input faces that this face stands for.
        int weight;
        /// -1 while the face exists; else the face of its star that stands in its place.
        int heir;
    };
    struct Vertex {
        /// Any one of its faces. Which one may depend on the threads; no result depends on it.
        int face;
        int degree;
        /// Sum of the weights of its faces.
        int weight;
        /// Index of its collapse in the current round, or -1.
        int slot;
    };

    std::vector<Face> faces;
    std::vector<Vertex> vertices;
    /// Vertices without one closed fan of at least three faces that are oriented alike: never
    /// removed, never a target.
    std::vector<char> is_fixed;
    /// While a subdivision is undone: the only two targets that each vertex may collapse into, in
    /// the layout of find_subdivision, and the most faces that a target may have. Empty otherwise;
    /// it must be when `keep` is called, which does not renumber it.
    std::vector<std::array<int, 2>> ends;
    int max_target_degree = std::numeric_limits<int>::max();
    /// The first vertex and the first face of caps.
    int first_cap_vertex;
    int first_cap_face;
    /// The original indices, increasing, of faces and vertices that `keep` has renumbered; empty
    /// before the first call, when indices are the original ones.
    std::vector<int> face_names;
    std::vector<int> vertex_names;

    CollapseMesh(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count);

    int face_name(int f) const { return face_names.empty() ? f : face_names[f]; }
    int vertex_name(int v) const { return vertex_names.empty() ? v : vertex_names[v]; }

    /// Compacts the arrays to the faces and vertices that exist, given in increasing order, and
    /// renumbers them, so that removed ones take up no cache lines.
    void keep(const std::vector<int>& live_faces,
              const std::vector<int>& live_vertices,
              int thread_count);

    int corner_of(int face, int vertex) const {
        return spheroseg::corner_of(faces[face].vertices, vertex);
    }

    /// May the vertex be a target of `v`?
    bool may_take(int target, int v) const {
        return !is_fixed[target] && target < first_cap_vertex &&
            (ends.empty() ||
             ((target == ends[v][0] || target == ends[v][1]) &&
              vertices[target].degree <= max_target_degree));
    }

    /// May the vertex be removed? One in the middle of a cap only leaves a triangle.
    bool is_removable(int v) const {
        return !is_fixed[v] && (v < first_cap_vertex || vertices[v].degree == 3) &&
            (ends.empty() || ends[v][0] >= 0);
    }

    /// How many of the faces, in increasing order, are not of caps.
    int count_mesh_faces(const std::vector<int>& live_faces) const {
        return static_cast<int>(
            std::lower_bound(live_faces.begin(), live_faces.end(), first_cap_face) -
            live_faces.begin());
    }

    /// Calls visit(face, ring vertex) for the faces (v, ring vertex, next ring vertex) of the
    /// closed fan of `v`, counter-clockwise, until it answers false.
    template <class Visit> void for_each_in_star(int v, Visit&& visit) const {
        const int first = vertices[v].face;
        int f = first;
        do {
            const int c = corner_of(f, v);
            if (!visit(f, faces[f].vertices[(c + 1) % 3])) {
                return;
            }
            f = faces[f].neighbors[(c + 2) % 3];
        } while (f != first);
    }
};

/// The collapses of one round, in the layout of CollapseHierarchy; `target` is -1 for a vertex
/// that can not be removed now.
struct CollapseRound {
    std::vector<int> vertex;
    std::vector<int> target;
    std::vector<int> star_begin;
    std::vector<int> ring_vertices;
    std::vector<int> star_faces;

    int size() const { return static_cast<int>(vertex.size()); }
};

/// Fills `round` for the vertices in round.vertex, no two of which are neighbours: their stars and
/// targets. The target is the ring vertex of least degree that satisfies the link condition. A
/// vertex on a border collapses along the border; if the border has three edges this closes the
/// hole, where `may_close_holes`. Where a subdivision is undone the target is one of the vertex's
/// `ends`, and every face that vanishes has an heir in the same triangle of the coarse mesh. Of two
/// collapses that would make the same edge, the one of higher `keys[vertex]` gets no target.
void plan_collapses(CollapseMesh& mesh,
                    CollapseRound& round,
                    const std::vector<std::uint64_t>& keys,
                    bool may_close_holes,
                    int thread_count);

/// Carries out the collapses that have a target.
void apply_collapses(CollapseMesh& mesh, const CollapseRound& round, int thread_count);

} // namespace spheroseg
