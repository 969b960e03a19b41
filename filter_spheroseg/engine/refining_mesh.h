// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hierarchy.h"

namespace spheroseg {

/// The mesh that a hierarchy leads back to, from its base faces up, with adjacency at every level.
/// Faces and vertices have their input indices; those that are not there yet have -1 entries.
class RefiningMesh {
public:
    struct Face {
        Triangle vertices;
        /// As in DualGraph.
        std::array<int, 3> neighbors;
    };

    /// Starts with the base faces. `hierarchy` must outlive this object.
    explicit RefiningMesh(const CollapseHierarchy& hierarchy, int face_count, int vertex_count);

    /// Undoes the last round that is not undone. The result does not depend on `thread_count`.
    void undo_round(int thread_count);

    /// Rounds that are still to be undone.
    int round() const { return round_; }
    int live_face_count() const { return live_face_count_; }
    const std::vector<Face>& faces() const { return faces_; }
    /// Number of faces around a vertex.
    int degree(int v) const { return degrees_[v]; }

    /// Calls visit(face, ring vertex) for the faces (v, ring vertex, next ring vertex) around `v`,
    /// counter-clockwise. The fan of `v` must be closed.
    template <class Visit> void for_each_in_star(int v, Visit&& visit) const {
        const int first = vertex_faces_[v];
        int f = first;
        do {
            const int c = corner_of(f, v);
            visit(f, faces_[f].vertices[(c + 1) % 3]);
            f = faces_[f].neighbors[(c + 2) % 3];
        } while (f != first);
    }

private:
    /// What lies beyond the two edges at which the faces of a step return, and on which of its
    /// sides; -1 for a border.
    struct Seam {
        std::array<int, 2> beyond;
        std::array<int, 2> side;
    };
    /// The side of a returned face towards what lies beyond.
    static constexpr int kBeyond = 1;

    int corner_of(int face, int vertex) const {
        return spheroseg::corner_of(faces_[face].vertices, vertex);
    }
    /// The faces at which the first and the last of a star return.
    std::array<int, 2> keepers(int step) const {
        return {hierarchy_.heir_face(step, true), hierarchy_.heir_face(step, false)};
    }
    std::array<int, 2> keeper_sides(int step) const;
    Seam find_seam(int step) const;
    void undo_step(int step, const Seam& seam);
    void link_beyond(int step, const Seam& seam);

    const CollapseHierarchy& hierarchy_;
    std::vector<Face> faces_;
    std::vector<int> vertex_faces_;
    std::vector<int> degrees_;
    std::vector<Seam> seams_;
    int round_;
    int live_face_count_;
};

} // namespace spheroseg
