// SPDX-License-Identifier: GPL-3.0-or-later
#include "refining_mesh.h"

#include "threads.h"

#include <algorithm>
#include <utility>

namespace spheroseg {

namespace {

/// Steps that a thread should have.
constexpr int kStepsPerThread = 512;

} // namespace

RefiningMesh::RefiningMesh(const CollapseHierarchy& hierarchy, int face_count, int vertex_count)
    : hierarchy_(hierarchy), faces_(face_count, {{-1, -1, -1}, {-1, -1, -1}}),
      vertex_faces_(vertex_count, -1), degrees_(vertex_count, 0), step_of_face_(face_count, -1),
      round_(hierarchy.round_count()),
      live_face_count_(static_cast<int>(hierarchy.base_faces.size())) {
    TriangleMesh base;
    base.positions.resize(vertex_count);
    base.faces = hierarchy.base_triangles;
    const DualGraph base_graph = build_dual_graph(base, 1);
    for (int i = 0; i < live_face_count_; ++i) {
        Face& face = faces_[hierarchy.base_faces[i]];
        face.vertices = base.faces[i];
        for (int c = 0; c < 3; ++c) {
            const int neighbor = base_graph.neighbors[i][c];
            face.neighbors[c] = neighbor < 0 ? -1 : hierarchy.base_faces[neighbor];
            vertex_faces_[face.vertices[c]] = hierarchy.base_faces[i];
            ++degrees_[face.vertices[c]];
        }
    }
}

/// Sides of the second and the last but one star face at which the first and the last return.
std::array<int, 2> RefiningMesh::seam_sides(int step) const {
    const int* const faces = star_faces(step);
    const int target = hierarchy_.target[step];
    return {corner_of(faces[1], target), (corner_of(faces[star_size(step) - 2], target) + 2) % 3};
}

RefiningMesh::Seam RefiningMesh::find_seam(int step) const {
    const int degree = star_size(step);
    const std::array<int, 2> keepers = {star_faces(step)[1], star_faces(step)[degree - 2]};
    const std::array<int, 2> sides = seam_sides(step);
    Seam seam;
    for (int k = 0; k < 2; ++k) {
        const int g = faces_[keepers[k]].neighbors[sides[k]];
        seam.beyond[k] = g;
        seam.side[k] = -1;
        if (g < 0) {
            continue;
        }
        // The edge runs the other way in g.
        const int start = faces_[keepers[k]].vertices[(sides[k] + 1) % 3];
        const int side = corner_of(g, start);
        const int other = step_of_face_[g];
        if (other >= 0) {
            const int* const other_faces = star_faces(other);
            const int other_degree = star_size(other);
            const std::array<int, 2> other_sides = seam_sides(other);
            if (other_faces[1] == g && other_sides[0] == side) {
                seam.beyond[k] = other_faces[0];
                continue;
            }
            if (other_faces[other_degree - 2] == g && other_sides[1] == side) {
                seam.beyond[k] = other_faces[other_degree - 1];
                continue;
            }
        }
        seam.side[k] = side;
    }
    return seam;
}

void RefiningMesh::undo_step(int step, const Seam& seam) {
    const int degree = star_size(step);
    const int* const faces = star_faces(step);
    const int* const ring = &hierarchy_.ring_vertices[hierarchy_.star_begin[step]];
    const int v = hierarchy_.vertex[step];
    const int target = ring[0];
    const std::array<int, 2> sides = seam_sides(step);
    const int first = faces[0];
    const int last = faces[degree - 1];
    for (int j = 1; j + 1 < degree; ++j) {
        faces_[faces[j]].vertices[corner_of(faces[j], target)] = v;
    }
    faces_[faces[1]].neighbors[sides[0]] = first;
    faces_[faces[degree - 2]].neighbors[sides[1]] = last;
    faces_[first] = {{v, target, ring[1]}, {last, seam.beyond[0], faces[1]}};
    faces_[last] = {{v, ring[degree - 1], target}, {faces[degree - 2], seam.beyond[1], first}};
    if (seam.side[0] >= 0) {
        faces_[seam.beyond[0]].neighbors[seam.side[0]] = first;
    }
    if (seam.side[1] >= 0) {
        faces_[seam.beyond[1]].neighbors[seam.side[1]] = last;
    }
    vertex_faces_[v] = first;
    degrees_[v] = degree;
    for (const auto& [r, change] :
         {std::pair{target, 4 - degree}, {ring[1], 1}, {ring[degree - 1], 1}}) {
#pragma omp atomic
        degrees_[r] += change;
    }
    // The target may have lost the face that it was known by; that face is in one star at most, so
    // that only one step of the round writes here.
    int known;
#pragma omp atomic read
    known = vertex_faces_[target];
    if (std::find(faces, faces + degree, known) != faces + degree) {
#pragma omp atomic write
        vertex_faces_[target] = first;
    }
}

void RefiningMesh::undo_round(int thread_count) {
    --round_;
    const int first = hierarchy_.round_begin[round_];
    const int count = hierarchy_.round_begin[round_ + 1] - first;
    const int threads = threads_for(thread_count, count, kStepsPerThread);
    seams_.resize(count);
    // As with apply_collapses: an edge may open on both sides in the same round.
    for_each_item(count, threads, [&](int i) {
        step_of_face_[star_faces(first + i)[1]] = first + i;
        step_of_face_[star_faces(first + i)[star_size(first + i) - 2]] = first + i;
    });
    for_each_item(count, threads, [&](int i) { seams_[i] = find_seam(first + i); });
    for_each_item(count, threads, [&](int i) {
        undo_step(first + i, seams_[i]);
        step_of_face_[star_faces(first + i)[1]] = -1;
        step_of_face_[star_faces(first + i)[star_size(first + i) - 2]] = -1;
    });
    live_face_count_ += 2 * count;
}

} // namespace spheroseg
