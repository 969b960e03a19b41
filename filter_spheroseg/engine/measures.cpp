// SPDX-License-Identifier: GPL-3.0-or-later
#include "measures.h"

#include "errors.h"
#include "parallel_failure.h"
#include "threads.h"
#include "vertex_fans.h"

#include <algorithm>
#include <string>

namespace spheroseg {

namespace {

void check_labels(const DualGraph& dual_graph, const std::vector<int>& labels, int submesh_count) {
    if (static_cast<int>(labels.size()) != dual_graph.face_count()) {
        throw InvalidInput("Expected one label per face (" +
                           std::to_string(dual_graph.face_count()) + "), found " +
                           std::to_string(labels.size()) + " labels. Label every face.");
    }
    for (std::size_t f = 0; f < labels.size(); ++f) {
        if (labels[f] < 0 || labels[f] >= submesh_count) {
            throw InvalidInput("Labels must lie in [0, " + std::to_string(submesh_count) +
                               "), but face " + std::to_string(f) + " has label " +
                               std::to_string(labels[f]) + ". Correct the labels.");
        }
    }
}

constexpr int kNoLabel = -1;
constexpr int kSeveralLabels = -2;

/// The label of all faces of each vertex, if there is one.
std::vector<int> labels_of_vertices(const TriangleMesh& mesh, const std::vector<int>& labels) {
    std::vector<int> label_of(mesh.positions.size(), kNoLabel);
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int v : mesh.faces[f]) {
            const bool fits = label_of[v] == kNoLabel || label_of[v] == labels[f];
            label_of[v] = fits ? labels[f] : kSeveralLabels;
        }
    }
    return label_of;
}

/// Per sub-mesh: its fans over all vertices, and its vertices. Each fan of the mesh counts as a
/// vertex of its own, so that a pinch of the input is no bowtie.
struct FanCounts {
    std::vector<int> fans;
    std::vector<int> vertices;
};

FanCounts count_fans(const TriangleMesh& mesh,
                     const DualGraph& dual_graph,
                     const std::vector<int>& labels,
                     int submesh_count,
                     VertexFanCount fans_per_vertex) {
    const bool walks_everywhere = fans_per_vertex == VertexFanCount::unknown;
    const std::vector<int> label_of_vertex =
        walks_everywhere ? std::vector<int>() : labels_of_vertices(mesh, labels);
    FanCounts counts;
    counts.fans.assign(submesh_count, 0);
    for (int label : label_of_vertex) {
        if (label >= 0) {
            ++counts.fans[label];
        }
    }
    counts.vertices = counts.fans;
    VertexFans fans(mesh, dual_graph);
    VertexFans::Fan fan;
    std::vector<int> last_fan(submesh_count, -1);
    const int corner_count = 3 * mesh.face_count();
    for (int corner = 0; corner < corner_count; ++corner) {
        const int vertex = mesh.faces[corner / 3][corner % 3];
        const bool walks = walks_everywhere || label_of_vertex[vertex] == kSeveralLabels;
        if (!walks || !fans.collect(corner, fan)) {
            continue;
        }
        // Corners side by side with one label are one fan of that sub-mesh.
        const int last_label = labels[fan.corners.back() / 3];
        int previous = fan.closed ? last_label : -1;
        bool changed = false;
        for (int c : fan.corners) {
            const int label = labels[c / 3];
            if (label != previous) {
                ++counts.fans[label];
                changed = true;
            }
            if (last_fan[label] != corner) {
                last_fan[label] = corner;
                ++counts.vertices[label];
            }
            previous = label;
        }
        counts.fans[last_label] += !changed;
    }
    return counts;
}

/// Edge-connected components of each sub-mesh.
std::vector<int>
count_components(const DualGraph& dual_graph, const std::vector<int>& labels, int submesh_count) {
    const FaceComponents found =
        face_components(dual_graph, [&](int f, int g) { return labels[f] == labels[g]; });
    std::vector<int> components(submesh_count, 0);
    for (int f : found.first_face) {
        ++components[labels[f]];
    }
    return components;
}

/// Sides of the faces of each sub-mesh that lead to a face of the same sub-mesh, and the edges
/// between sub-meshes.
struct EdgeCounts {
    std::vector<int> inner_sides;
    int boundary_edges = 0;
};

EdgeCounts
count_edges(const DualGraph& dual_graph, const std::vector<int>& labels, int submesh_count) {
    EdgeCounts counts;
    counts.inner_sides.assign(submesh_count, 0);
    int boundary_sides = 0;
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        for (int g : dual_graph.neighbors[f]) {
            if (g >= 0) {
                boundary_sides += labels[f] != labels[g];
                counts.inner_sides[labels[f]] += labels[f] == labels[g];
            }
        }
    }
    counts.boundary_edges = boundary_sides / 2;
    return counts;
}

void measure_balance(Measures& result) {
    const auto [least, most] =
        std::minmax_element(result.submesh_triangles.begin(), result.submesh_triangles.end());
    result.min_submesh_triangles = *least;
    result.max_submesh_triangles = *most;
    result.max_triangle_count_difference = *most - *least;
    const double mean = static_cast<double>(result.triangle_count) / result.submesh_count;
    double sum_of_squares = 0.0;
    for (int count : result.submesh_triangles) {
        sum_of_squares += (count - mean) * (count - mean);
    }
    if (mean > 0.0) {
        result.coefficient_of_variation = std::sqrt(sum_of_squares / result.submesh_count) / mean;
    }
}

/// What the validity of sub-meshes depends on besides their triangle counts.
struct Topology {
    EdgeCounts edges;
    FanCounts fans;
    std::vector<int> components;
};

Topology count_topology(const TriangleMesh& mesh,
                        const DualGraph& dual_graph,
                        const std::vector<int>& labels,
                        int submesh_count,
                        int thread_count,
                        VertexFanCount fans_per_vertex) {
    Topology topology;
    const int threads = threads_for(thread_count, mesh.face_count(), kFacesPerThread / 4);
    ParallelFailure failure;
#pragma omp parallel sections num_threads(std::min(threads, 2))
    {
#pragma omp section
        failure.guard([&] {
            topology.fans = count_fans(mesh, dual_graph, labels, submesh_count, fans_per_vertex);
        });
#pragma omp section
        failure.guard([&] {
            topology.edges = count_edges(dual_graph, labels, submesh_count);
            topology.components = count_components(dual_graph, labels, submesh_count);
        });
    }
    failure.rethrow();
    return topology;
}

/// Expects the triangle counts to be measured.
void measure_topology(const Topology& topology, Measures& result) {
    const auto& [edges, fans, components] = topology;
    for (int s = 0; s < result.submesh_count; ++s) {
        const int bowties = fans.fans[s] - fans.vertices[s];
        const int triangles = result.submesh_triangles[s];
        const int edge_count = 3 * triangles - edges.inner_sides[s] / 2;
        const int euler_characteristic = fans.vertices[s] - edge_count + triangles;
        result.bowtie_count += bowties;
        result.disconnected_submesh_count += components[s] > 1;
        // Without bowties a connected sub-mesh is a surface with b boundary loops and Euler
        // characteristic 2 - 2g - b (handles) or 2 - g - b (crosscaps): with a boundary, 1 means
        // g = 0 and b = 1.
        const bool has_boundary = edges.inner_sides[s] < 3 * triangles;
        result.disk_count +=
            components[s] == 1 && bowties == 0 && euler_characteristic == 1 && has_boundary;
    }
}

} // namespace

Measures measure(const TriangleMesh& mesh,
                 const DualGraph& dual_graph,
                 const std::vector<int>& labels,
                 int submesh_count,
                 int thread_count,
                 VertexFanCount fans_per_vertex) {
    check_labels(dual_graph, labels, submesh_count);
    Measures result;
    result.submesh_count = submesh_count;
    result.triangle_count = mesh.face_count();
    if (submesh_count <= 0) {
        return result;
    }
    result.submesh_triangles.assign(submesh_count, 0);
    for (int label : labels) {
        ++result.submesh_triangles[label];
    }
    measure_balance(result);

    const Topology topology =
        count_topology(mesh, dual_graph, labels, submesh_count, thread_count, fans_per_vertex);
    result.boundary_edge_count = topology.edges.boundary_edges;
    if (dual_graph.edge_count > 0) {
        result.boundary_edge_ratio =
            static_cast<double>(result.boundary_edge_count) / dual_graph.edge_count;
    }
    measure_topology(topology, result);
    return result;
}

int count_boundary_edges(const DualGraph& dual_graph, const std::vector<int>& labels) {
    int sides = 0;
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        for (int g : dual_graph.neighbors[f]) {
            sides += g >= 0 && labels[g] != labels[f];
        }
    }
    return sides / 2;
}

} // namespace spheroseg
