// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"
#include "progress.h"

namespace spheroseg {

/// A sequence of half-edge collapses, in rounds of independent vertices: the stars of two vertices
/// that are removed in the same round share no face, so that a round can be undone in parallel.
///
/// Step i removes `vertex[i]` by collapsing it into `target[i]`. Its star at that moment is
/// ring_vertices[star_begin[i] .. star_begin[i + 1]) in counter-clockwise order, rotated so that
/// the first ring vertex is the target; star_faces[j] is the face (vertex, ring[j], ring[j + 1])
/// (cyclic). The first and the last star face contain the target and disappear; in the others
/// `vertex` becomes `target`. Face and vertex indices are those of the input mesh; greater ones
/// belong to caps that close its holes. A vertex on a border has faces of a cap in its star, and
/// one of them is the first or the last. Where the face next to that in the star is of the mesh,
/// the step closes the hole: that face and the one beyond the cap become neighbours. The face that
/// takes the place of a face of the mesh is never one of a cap.
struct CollapseHierarchy {
    std::vector<int> vertex;
    std::vector<int> target;
    std::vector<int> star_begin; // steps + 1 entries
    std::vector<int> ring_vertices;
    std::vector<int> star_faces;
    /// Round r holds the steps [round_begin[r], round_begin[r + 1]).
    std::vector<int> round_begin;
    /// The numbers of rounds after which a subdivision is undone, where the mesh comes from some
    /// (find_subdivision), increasing: each face stands for exactly four of those that there were
    /// after the number before, or of the mesh.
    std::vector<int> quartered_rounds;
    /// The faces that are left after the last step, and their vertices.
    std::vector<int> base_faces;
    std::vector<Triangle> base_triangles;

    int step_count() const { return static_cast<int>(vertex.size()); }
    int round_count() const { return static_cast<int>(round_begin.size()) - 1; }

    /// The star of a step: so many faces, these, and as many ring vertices.
    int degree(int step) const { return star_begin[step + 1] - star_begin[step]; }
    const int* star(int step) const { return star_faces.data() + star_begin[step]; }
    const int* ring(int step) const { return ring_vertices.data() + star_begin[step]; }
    /// Of the first or the last face of a star, which disappear: the face, and the one beside it in
    /// the star, which takes its place.
    int removed_face(int step, bool first) const {
        return star(step)[first ? 0 : degree(step) - 1];
    }
    int heir_face(int step, bool first) const { return star(step)[first ? 1 : degree(step) - 2]; }
};

/// Collapses a closed manifold genus-0 mesh to a tetrahedron (4 base faces) in O(F log F), in
/// parallel. Vertices are removed where the fewest input faces gather, so that the coarse faces
/// stand for about the same number of input faces each, and the degrees stay small; a round removes
/// about a quarter of the vertices, some very few. Subdivisions of the whole mesh are undone first:
/// so all coarse edges stand for as many fine ones. Positions are not used.
/// On other meshes it ends where the link condition allows no more. Vertices on borders are removed
/// along these; holes are closed once there are many of them for the faces that are left. What is
/// left of a connected mesh stays connected. Vertices whose faces, with the caps, are not one
/// closed fan, or run along an edge in the same direction, are never removed. The result does not
/// depend on the number of threads. Throws Cancelled.
CollapseHierarchy build_hierarchy(const TriangleMesh& mesh,
                                  const DualGraph& dual_graph,
                                  int thread_count = 0,
                                  const Progress& progress = {});

} // namespace spheroseg
