// SPDX-License-Identifier: GPL-3.0-or-later
#include "dual_graph.h"

#include "errors.h"
#include "threads.h"

#include <algorithm>
#include <string>

namespace spheroseg {

namespace {

/// Vertices that a thread takes at a time.
constexpr int kVerticesPerTask = 4096;

/// The side of a face: 3 * face + corner, seen from the lower of its two vertices.
struct BucketSide {
    int other_vertex;
    int side;

    bool operator<(const BucketSide& other) const {
        return other_vertex != other.other_vertex ? other_vertex < other.other_vertex
                                                  : side < other.side;
    }
};

void check_indices(const TriangleMesh& mesh) {
    const int vertex_count = mesh.vertex_count();
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int v : mesh.faces[f]) {
            if (v < 0 || v >= vertex_count) {
                throw InvalidInput("Face " + std::to_string(f) + " refers to vertex " +
                                   std::to_string(v) + ", but vertex indices must lie in [0, " +
                                   std::to_string(vertex_count) +
                                   "). Repair or re-export the mesh.");
            }
        }
    }
}

/// The sides of all faces in one bucket per lower vertex: those of vertex v from begin[v] up to
/// begin[v + 1].
struct Buckets {
    std::vector<int> begin;
    std::vector<BucketSide> sides;
};

Buckets bucket_sides(const TriangleMesh& mesh) {
    const int vertex_count = mesh.vertex_count();
    Buckets buckets;
    buckets.begin.assign(vertex_count + 1, 0);
    for (const Triangle& face : mesh.faces) {
        for (int c = 0; c < 3; ++c) {
            ++buckets.begin[std::min(face[c], face[(c + 1) % 3]) + 1];
        }
    }
    for (int v = 0; v < vertex_count; ++v) {
        buckets.begin[v + 1] += buckets.begin[v];
    }
    buckets.sides.resize(3 * mesh.faces.size());
    std::vector<int> fill(buckets.begin.begin(), buckets.begin.end() - 1);
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            const int a = mesh.faces[f][c];
            const int b = mesh.faces[f][(c + 1) % 3];
            buckets.sides[fill[std::min(a, b)]++] = {std::max(a, b), 3 * f + c};
        }
    }
    return buckets;
}

/// Makes the faces of two sides of one edge neighbours.
void join(const TriangleMesh& mesh, int first, int second, DualGraph& graph) {
    const int f = first / 3;
    const int g = second / 3;
    const bool has_length = mesh.faces[f][first % 3] != mesh.faces[f][(first % 3 + 1) % 3];
    if (f != g && has_length) {
        graph.neighbors[f][first % 3] = g;
        graph.neighbors[g][second % 3] = f;
    }
}

} // namespace

void check_size(std::size_t face_count, std::size_t vertex_count) {
    const auto refuse = [](std::size_t found, const char* what, int most) {
        throw InvalidInput("The mesh has " + std::to_string(found) + what + ", but at most " +
                           std::to_string(most) + " are possible. Simplify it, or part it first.");
    };
    if (face_count > std::size_t{kMaxFaces}) {
        refuse(face_count, " triangles", kMaxFaces);
    }
    constexpr int kMaxVertices = 1 << 30; // leaves numbers for those that close holes
    if (vertex_count > std::size_t{kMaxVertices}) {
        refuse(vertex_count, " vertices", kMaxVertices);
    }
}

DualGraph build_dual_graph(const TriangleMesh& mesh, int thread_count) {
    check_size(mesh.faces.size(), mesh.positions.size());
    check_indices(mesh);
    const int vertex_count = mesh.vertex_count();
    DualGraph graph;
    graph.neighbors.assign(mesh.face_count(), {-1, -1, -1});
    Buckets buckets = bucket_sides(mesh);
    const int threads = threads_for(thread_count, vertex_count, kVerticesPerTask);
    int edge_count = 0;
#pragma omp parallel for schedule(dynamic, kVerticesPerTask) num_threads(threads)                  \
    reduction(+ : edge_count)
    for (int v = 0; v < vertex_count; ++v) {
        const auto begin = buckets.sides.begin() + buckets.begin[v];
        const auto end = buckets.sides.begin() + buckets.begin[v + 1];
        std::sort(begin, end);
        for (auto run = begin; run != end;) {
            auto run_end = run;
            while (run_end != end && run_end->other_vertex == run->other_vertex) {
                ++run_end;
            }
            ++edge_count;
            if (run_end - run == 2) {
                join(mesh, run[0].side, run[1].side, graph);
            }
            run = run_end;
        }
    }
    graph.edge_count = edge_count;
    return graph;
}

} // namespace spheroseg
