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
      vertex_faces_(vertex_count, -1), degrees_(vertex_count, 0), round_(hierarchy.round_count()),
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

std::array<int, 2> RefiningMesh::keeper_sides(int step) const {
    const auto [first, last] = keepers(step);
    const int target = hierarchy_.target[step];
    return {corner_of(first, target), (corner_of(last, target) + 2) % 3};
}

RefiningMesh::Seam RefiningMesh::find_seam(int step) const {
    const std::array<int, 2> faces = keepers(step);
    const std::array<int, 2> sides = keeper_sides(step);
    Seam seam;
    for (int k = 0; k < 2; ++k) {
        const Face& keeper = faces_[faces[k]];
        seam.beyond[k] = keeper.neighbors[sides[k]];
        // The face beyond has the edge in the opposite direction.
        const int start = keeper.vertices[(sides[k] + 1) % 3];
        seam.side[k] = seam.beyond[k] < 0 ? -1 : corner_of(seam.beyond[k], start);
    }
    return seam;
}

void RefiningMesh::undo_step(int step, const Seam& seam) {
    const int degree = hierarchy_.degree(step);
    const int* const faces = hierarchy_.star(step);
    const int* const ring = hierarchy_.ring(step);
    const int v = hierarchy_.vertex[step];
    const int target = ring[0];
    const std::array<int, 2> sides = keeper_sides(step);
    const int first = faces[0];
    const int last = faces[degree - 1];
    for (int j = 1; j + 1 < degree; ++j) {
        faces_[faces[j]].vertices[corner_of(faces[j], target)] = v;
    }
    faces_[faces[1]].neighbors[sides[0]] = first;
    faces_[faces[degree - 2]].neighbors[sides[1]] = last;
    faces_[first] = {{v, target, ring[1]}, {last, seam.beyond[0], faces[1]}};
    faces_[last] = {{v, ring[degree - 1], target}, {faces[degree - 2], seam.beyond[1], first}};
    vertex_faces_[v] = first;
    degrees_[v] = degree;
    for (const auto& [r, change] :
         {std::pair{target, 4 - degree}, {ring[1], 1}, {ring[degree - 1], 1}}) {
#pragma omp atomic
        degrees_[r] += change;
    }
    // The face of the target may now belong to `v`; a face is in one star at most, so that only one
    // step of the round writes here.
    int known;
#pragma omp atomic read
    known = vertex_faces_[target];
    if (std::find(faces, faces + degree, known) != faces + degree) {
#pragma omp atomic write
        vertex_faces_[target] = first;
    }
}

/// Makes the returned faces neighbours of the faces beyond their outer edges. Where another step of
/// the round returned a face at the same edge, that one is the face beyond.
void RefiningMesh::link_beyond(int step, const Seam& seam) {
    const std::array<int, 2> faces = keepers(step);
    const std::array<int, 2> returned = {hierarchy_.removed_face(step, true),
                                         hierarchy_.removed_face(step, false)};
    for (int k = 0; k < 2; ++k) {
        if (seam.beyond[k] < 0) {
            continue;
        }
        int& there = faces_[seam.beyond[k]].neighbors[seam.side[k]];
        if (there == faces[k]) {
            there = returned[k];
        } else {
            faces_[returned[k]].neighbors[kBeyond] = there;
        }
    }
}

void RefiningMesh::undo_round(int thread_count) {
    --round_;
    const int first = hierarchy_.round_begin[round_];
    const int count = hierarchy_.round_begin[round_ + 1] - first;
    const int threads = threads_for(thread_count, count, kStepsPerThread);
    seams_.resize(count);
    for_each_item(count, threads, [&](int i) { seams_[i] = find_seam(first + i); });
    for_each_item(count, threads, [&](int i) { undo_step(first + i, seams_[i]); });
    for_each_item(count, threads, [&](int i) { link_beyond(first + i, seams_[i]); });
    live_face_count_ += 2 * count;
}

} // namespace spheroseg
