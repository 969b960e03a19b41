// SPDX-License-Identifier: GPL-3.0-or-later
#include "coloring.h"

#include <algorithm>
#include <set>
#include <utility>

namespace spheroseg {

// Found by a random search for colours that are far apart for four kinds of sight, within bounds of
// lightness and chroma.
const std::array<Rgb, 8> kPalette = {{{237, 238, 84},
                                      {107, 255, 223},
                                      {112, 83, 80},
                                      {90, 67, 198},
                                      {113, 124, 9},
                                      {210, 154, 129},
                                      {43, 146, 153},
                                      {182, 185, 255}}};

namespace {

constexpr int kPaletteSize = 8;

/// Neighbours of each sub-mesh, sorted.
using Adjacency = std::vector<std::vector<int>>;

void add_pair(Adjacency& adjacency, int a, int b) {
    adjacency[a].push_back(b);
    adjacency[b].push_back(a);
}

void sort_unique(Adjacency& adjacency) {
    for (std::vector<int>& neighbors : adjacency) {
        std::sort(neighbors.begin(), neighbors.end());
        neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
    }
}

Adjacency
edge_adjacency(const DualGraph& dual_graph, const std::vector<int>& labels, int submesh_count) {
    Adjacency adjacency(submesh_count);
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        for (int g : dual_graph.neighbors[f]) {
            if (g > f && labels[f] != labels[g]) {
                add_pair(adjacency, labels[f], labels[g]);
            }
        }
    }
    sort_unique(adjacency);
    return adjacency;
}

/// Sub-meshes that share a vertex. A vertex with more sub-meshes than the palette has colours is
/// left out: they can not all differ.
Adjacency
vertex_adjacency(const TriangleMesh& mesh, const std::vector<int>& labels, int submesh_count) {
    // Of the vertices with several labels only: pairs of vertex and label.
    std::vector<std::pair<int, int>> corners;
    std::vector<int> first_label(mesh.positions.size(), -1);
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int v : mesh.faces[f]) {
            if (first_label[v] < 0) {
                first_label[v] = labels[f];
            } else if (first_label[v] != labels[f]) {
                corners.emplace_back(v, first_label[v]);
                corners.emplace_back(v, labels[f]);
            }
        }
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    Adjacency adjacency(submesh_count);
    for (std::size_t begin = 0, end = 0; begin < corners.size(); begin = end) {
        while (end < corners.size() && corners[end].first == corners[begin].first) {
            ++end;
        }
        for (std::size_t i = begin; i < end && end - begin <= kPaletteSize; ++i) {
            for (std::size_t j = i + 1; j < end; ++j) {
                add_pair(adjacency, corners[i].second, corners[j].second);
            }
        }
    }
    sort_unique(adjacency);
    return adjacency;
}

/// Smallest-last order: colouring from its front needs at most six colours in a planar graph.
std::vector<int> smallest_last_order(const Adjacency& adjacency) {
    const int count = static_cast<int>(adjacency.size());
    std::vector<int> degree(count);
    std::set<std::pair<int, int>> remaining;
    for (int s = 0; s < count; ++s) {
        degree[s] = static_cast<int>(adjacency[s].size());
        remaining.emplace(degree[s], s);
    }
    std::vector<int> order;
    order.reserve(count);
    while (!remaining.empty()) {
        const int s = remaining.begin()->second;
        remaining.erase(remaining.begin());
        degree[s] = -1;
        order.push_back(s);
        for (int t : adjacency[s]) {
            if (degree[t] >= 0) {
                remaining.erase({degree[t], t});
                remaining.emplace(--degree[t], t);
            }
        }
    }
    std::reverse(order.begin(), order.end());
    return order;
}

/// How often the neighbours have each palette colour; colours beyond the palette go to `beyond`.
std::array<int, kPaletteSize> count_colors(const std::vector<int>& neighbors,
                                           const std::vector<int>& colors,
                                           std::set<int>* beyond = nullptr) {
    std::array<int, kPaletteSize> counts = {};
    for (int t : neighbors) {
        if (colors[t] >= kPaletteSize && beyond) {
            beyond->insert(colors[t]);
        } else if (colors[t] >= 0 && colors[t] < kPaletteSize) {
            ++counts[colors[t]];
        }
    }
    return counts;
}

} // namespace

std::vector<int> color_submeshes(const TriangleMesh& mesh,
                                 const DualGraph& dual_graph,
                                 const std::vector<int>& labels,
                                 int submesh_count) {
    const Adjacency by_edge = edge_adjacency(dual_graph, labels, submesh_count);
    const Adjacency by_vertex = vertex_adjacency(mesh, labels, submesh_count);
    std::vector<int> colors(submesh_count, -1);
    std::array<int, kPaletteSize> used = {};
    for (int s : smallest_last_order(by_edge)) {
        std::set<int> beyond;
        const auto at_edges = count_colors(by_edge[s], colors, &beyond);
        const auto at_vertices = count_colors(by_vertex[s], colors);
        int best = -1;
        for (int c = 0; c < kPaletteSize; ++c) {
            if (at_edges[c] == 0 &&
                (best < 0 ||
                 std::pair(at_vertices[c], used[c]) < std::pair(at_vertices[best], used[best]))) {
                best = c;
            }
        }
        if (best < 0) {
            best = kPaletteSize;
            while (beyond.count(best) != 0) {
                ++best;
            }
        } else {
            ++used[best];
        }
        colors[s] = best;
    }
    return colors;
}

Rgb palette_color(int color_index) {
    Rgb color = kPalette[color_index % kPaletteSize];
    const int round = color_index / kPaletteSize;
    if (round == 0) {
        return color;
    }
    const double target = round % 2 == 1 ? 255.0 : 0.0;
    const double share = 1.0 - 1.0 / (1.0 + 0.35 * ((round + 1) / 2));
    for (std::uint8_t& channel : color) {
        channel = static_cast<std::uint8_t>(std::lround(channel + (target - channel) * share));
    }
    return color;
}

std::vector<Rgb> submesh_colors(const TriangleMesh& mesh,
                                const DualGraph& dual_graph,
                                const std::vector<int>& labels,
                                int submesh_count) {
    std::vector<Rgb> colors;
    colors.reserve(submesh_count);
    for (int c : color_submeshes(mesh, dual_graph, labels, submesh_count)) {
        colors.push_back(palette_color(c));
    }
    return colors;
}

} // namespace spheroseg
