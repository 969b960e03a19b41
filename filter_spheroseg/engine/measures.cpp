// SPDX-License-Identifier: GPL-3.0-or-later
#include "measures.h"

#include "errors.h"

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

/// Corners (3 * face + corner) of each vertex: corners[begin[v] .. begin[v + 1]).
struct VertexCorners {
    std::vector<int> begin;
    std::vector<int> corners;
};

VertexCorners collect_corners(const TriangleMesh& mesh) {
    VertexCorners result;
    result.begin.assign(mesh.positions.size() + 1, 0);
    for (const Triangle& face : mesh.faces) {
        for (int v : face) {
            ++result.begin[v + 1];
        }
    }
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
        result.begin[v + 1] += result.begin[v];
    }
    result.corners.resize(3 * mesh.faces.size());
    std::vector<int> fill(result.begin.begin(), result.begin.end() - 1);
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            result.corners[fill[mesh.faces[f][c]]++] = 3 * f + c;
        }
    }
    return result;
}

/// Per sub-mesh: fans over all its vertices, and vertices.
struct FanCounts {
    std::vector<int> fans;
    std::vector<int> vertices;
};

/// The corner of the same vertex in the face across the side `side_offset` places after `corner`
/// (0: the side that leaves the vertex, 2: the side that arrives), or -1 where the label changes.
int turn(const TriangleMesh& mesh,
         const DualGraph& dual_graph,
         const std::vector<int>& labels,
         int corner,
         int side_offset) {
    const int f = corner / 3;
    const int c = corner % 3;
    const int g = dual_graph.neighbors[f][(c + side_offset) % 3];
    if (g < 0 || labels[g] != labels[f]) {
        return -1;
    }
    const int v = mesh.faces[f][c];
    const Triangle& face = mesh.faces[g];
    return 3 * g + (face[0] == v ? 0 : face[1] == v ? 1 : 2);
}

FanCounts count_fans(const TriangleMesh& mesh,
                     const DualGraph& dual_graph,
                     const std::vector<int>& labels,
                     int submesh_count) {
    const VertexCorners incidence = collect_corners(mesh);
    FanCounts counts;
    counts.fans.assign(submesh_count, 0);
    counts.vertices.assign(submesh_count, 0);
    std::vector<int> last_vertex(submesh_count, -1);
    std::vector<char> visited(incidence.corners.size(), 0);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        for (int i = incidence.begin[v]; i < incidence.begin[v + 1]; ++i) {
            const int start = incidence.corners[i];
            const int label = labels[start / 3];
            if (last_vertex[label] != v) {
                last_vertex[label] = v;
                ++counts.vertices[label];
            }
            if (visited[start]) {
                continue;
            }
            ++counts.fans[label];
            for (int side_offset : {2, 0}) {
                int corner = start;
                do {
                    visited[corner] = 1;
                    corner = turn(mesh, dual_graph, labels, corner, side_offset);
                } while (corner >= 0 && !visited[corner]);
            }
        }
    }
    return counts;
}

/// Edge-connected components of each sub-mesh.
std::vector<int>
count_components(const DualGraph& dual_graph, const std::vector<int>& labels, int submesh_count) {
    std::vector<int> components(submesh_count, 0);
    std::vector<char> visited(labels.size(), 0);
    std::vector<int> stack;
    for (int seed = 0; seed < dual_graph.face_count(); ++seed) {
        if (visited[seed]) {
            continue;
        }
        ++components[labels[seed]];
        visited[seed] = 1;
        stack.push_back(seed);
        while (!stack.empty()) {
            const int f = stack.back();
            stack.pop_back();
            for (int g : dual_graph.neighbors[f]) {
                if (g >= 0 && !visited[g] && labels[g] == labels[f]) {
                    visited[g] = 1;
                    stack.push_back(g);
                }
            }
        }
    }
    return components;
}

/// Sides of the faces of each sub-mesh that lead to a face of the same sub-mesh, and the mesh's
/// edges by kind.
struct EdgeCounts {
    std::vector<int> inner_sides;
    int boundary_edges = 0;
    int edges = 0;
};

EdgeCounts
count_edges(const DualGraph& dual_graph, const std::vector<int>& labels, int submesh_count) {
    EdgeCounts counts;
    counts.inner_sides.assign(submesh_count, 0);
    int joined_sides = 0;
    int boundary_sides = 0;
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        for (int g : dual_graph.neighbors[f]) {
            if (g >= 0) {
                ++joined_sides;
                boundary_sides += labels[f] != labels[g];
                counts.inner_sides[labels[f]] += labels[f] == labels[g];
            }
        }
    }
    counts.boundary_edges = boundary_sides / 2;
    counts.edges = 3 * dual_graph.face_count() - joined_sides / 2;
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

} // namespace

Measures measure(const TriangleMesh& mesh,
                 const DualGraph& dual_graph,
                 const std::vector<int>& labels,
                 int submesh_count) {
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

    const EdgeCounts edges = count_edges(dual_graph, labels, submesh_count);
    const FanCounts fans = count_fans(mesh, dual_graph, labels, submesh_count);
    const std::vector<int> components = count_components(dual_graph, labels, submesh_count);
    result.boundary_edge_count = edges.boundary_edges;
    if (edges.edges > 0) {
        result.boundary_edge_ratio = static_cast<double>(edges.boundary_edges) / edges.edges;
    }
    for (int s = 0; s < submesh_count; ++s) {
        const int bowties = fans.fans[s] - fans.vertices[s];
        const int triangles = result.submesh_triangles[s];
        const int edge_count = 3 * triangles - edges.inner_sides[s] / 2;
        const int euler_characteristic = fans.vertices[s] - edge_count + triangles;
        result.bowtie_count += bowties;
        result.disconnected_submesh_count += components[s] > 1;
        // Without bowties a connected sub-mesh is an oriented surface of genus g with b boundary
        // loops and Euler characteristic 2 - 2g - b: 1 means g = 0 and b = 1.
        result.disk_count += components[s] == 1 && bowties == 0 && euler_characteristic == 1;
    }
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
