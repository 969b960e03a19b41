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
struct Side {
    int other_vertex;
    int side;
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

} // namespace

DualGraph build_dual_graph(const TriangleMesh& mesh, int thread_count) {
    check_indices(mesh);
    const int face_count = mesh.face_count();
    const int vertex_count = mesh.vertex_count();
    DualGraph graph;
    graph.neighbors.assign(face_count, {-1, -1, -1});

    const auto lower_vertex = [&](int f, int c) {
        return std::min(mesh.faces[f][c], mesh.faces[f][(c + 1) % 3]);
    };
    // Sides sorted into one bucket per lower vertex. Filling in face order keeps each bucket
    // sorted by side index, so that the result does not depend on threads.
    std::vector<int> bucket_begin(vertex_count + 1, 0);
    for (int f = 0; f < face_count; ++f) {
        for (int c = 0; c < 3; ++c) {
            ++bucket_begin[lower_vertex(f, c) + 1];
        }
    }
    for (int v = 0; v < vertex_count; ++v) {
        bucket_begin[v + 1] += bucket_begin[v];
    }
    std::vector<Side> sides(3 * static_cast<std::size_t>(face_count));
    std::vector<int> fill(bucket_begin.begin(), bucket_begin.end() - 1);
    for (int f = 0; f < face_count; ++f) {
        for (int c = 0; c < 3; ++c) {
            const int a = mesh.faces[f][c];
            const int b = mesh.faces[f][(c + 1) % 3];
            sides[fill[std::min(a, b)]++] = {std::max(a, b), 3 * f + c};
        }
    }
    const int threads = threads_for(thread_count, vertex_count, kVerticesPerTask);
    int edge_count = 0;
#pragma omp parallel for schedule(dynamic, kVerticesPerTask) num_threads(threads)                  \
    reduction(+ : edge_count)
    for (int v = 0; v < vertex_count; ++v) {
        const auto begin = sides.begin() + bucket_begin[v];
        const auto end = sides.begin() + bucket_begin[v + 1];
        std::stable_sort(begin, end, [](const Side& a, const Side& b) {
            return a.other_vertex < b.other_vertex;
        });
        for (auto run = begin; run != end;) {
            auto run_end = run;
            while (run_end != end && run_end->other_vertex == run->other_vertex) {
                ++run_end;
            }
            ++edge_count;
            if (run_end - run == 2) {
                const int f = run[0].side / 3;
                const int g = run[1].side / 3;
                const int cf = run[0].side % 3;
                const int cg = run[1].side % 3;
                if (f != g && mesh.faces[f][cf] != mesh.faces[f][(cf + 1) % 3]) {
                    graph.neighbors[f][cf] = g;
                    graph.neighbors[g][cg] = f;
                }
            }
            run = run_end;
        }
    }
    graph.edge_count = edge_count;
    return graph;
}

} // namespace spheroseg
