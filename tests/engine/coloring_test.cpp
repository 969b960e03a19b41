// SPDX-License-Identifier: GPL-3.0-or-later
#include "coloring.h"

#include "random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace spheroseg {
namespace {

/// A grid of quads on a torus, each cut into two triangles: every vertex has six triangles.
TriangleMesh make_torus_grid(int columns, int rows) {
    TriangleMesh mesh;
    mesh.positions.resize(static_cast<std::size_t>(columns) * rows);
    const auto at = [&](int column, int row) { return row % rows * columns + column % columns; };
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const int a = at(column, row), b = at(column + 1, row);
            const int c = at(column + 1, row + 1), d = at(column, row + 1);
            mesh.faces.push_back({a, b, c});
            mesh.faces.push_back({a, c, d});
        }
    }
    return mesh;
}

bool edge_neighbors_differ(const DualGraph& dual_graph,
                           const std::vector<int>& labels,
                           const std::vector<int>& colors) {
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        for (int g : dual_graph.neighbors[f]) {
            if (g >= 0 && labels[f] != labels[g] && colors[labels[f]] == colors[labels[g]]) {
                return false;
            }
        }
    }
    return true;
}

using Row = std::array<double, 3>;

std::array<double, 3> multiply(const std::array<Row, 3>& matrix, const std::array<double, 3>& v) {
    std::array<double, 3> result;
    for (int i = 0; i < 3; ++i) {
        result[i] = matrix[i][0] * v[0] + matrix[i][1] * v[1] + matrix[i][2] * v[2];
    }
    return result;
}

/// CIELAB (D65) of an sRGB colour, seen through `sight`, a matrix on linear RGB.
std::array<double, 3> to_lab(const Rgb& rgb, const std::array<Row, 3>& sight) {
    std::array<double, 3> linear;
    for (int i = 0; i < 3; ++i) {
        const double c = rgb[i] / 255.0;
        linear[i] = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    }
    linear = multiply(sight, linear);
    for (double& c : linear) {
        c = std::clamp(c, 0.0, 1.0);
    }
    const std::array<Row, 3> to_xyz = {
        {{0.4124564 / 0.95047, 0.3575761 / 0.95047, 0.1804375 / 0.95047},
         {0.2126729, 0.7151522, 0.0721750},
         {0.0193339 / 1.08883, 0.1191920 / 1.08883, 0.9503041 / 1.08883}}};
    std::array<double, 3> f = multiply(to_xyz, linear);
    for (double& t : f) {
        t = t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0;
    }
    return {116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2])};
}

// Normal sight, and full protanopia, deuteranopia and tritanopia after Machado, Oliveira,
// Fernandes: A Physiologically-based Model for Simulation of Color Vision Deficiency, 2009.
const std::vector<std::array<Row, 3>> kSights = {{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                                 {{{0.152286, 1.052583, -0.204868},
                                                   {0.114503, 0.786281, 0.099216},
                                                   {-0.003882, -0.048116, 1.051998}}},
                                                 {{{0.367322, 0.860646, -0.227968},
                                                   {0.280085, 0.672501, 0.047413},
                                                   {-0.011820, 0.042940, 0.968881}}},
                                                 {{{1.255528, -0.076749, -0.178779},
                                                   {-0.078411, 0.930809, 0.147602},
                                                   {0.004733, 0.691367, 0.303900}}}};

TEST(Palette, AnyTwoColorsAreFarApartForEverySight) {
    for (const auto& sight : kSights) {
        for (std::size_t i = 0; i < kPalette.size(); ++i) {
            for (std::size_t j = i + 1; j < kPalette.size(); ++j) {
                const auto a = to_lab(kPalette[i], sight);
                const auto b = to_lab(kPalette[j], sight);
                EXPECT_GT(std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]), 20.0)
                    << "colours " << i << " and " << j;
            }
        }
    }
}

TEST(Palette, VariantsBeyondThePaletteAreDifferentColors) {
    std::set<Rgb> colors;
    for (int i = 0; i < 32; ++i) {
        colors.insert(palette_color(i));
    }
    EXPECT_EQ(colors.size(), 32u);
}

TEST(ColorSubmeshes, NeighborsInAGridOfPatchesDifferAlsoAtVertices) {
    const TriangleMesh mesh = make_torus_grid(40, 40);
    std::vector<int> labels(mesh.faces.size());
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int column = f / 2 % 40, row = f / 2 / 40;
        labels[f] = row / 5 * 8 + column / 5;
    }
    const std::vector<int> colors = color_submeshes(mesh, build_dual_graph(mesh), labels, 64);
    EXPECT_LT(*std::max_element(colors.begin(), colors.end()), 8);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        std::set<int> labels_here, colors_here;
        for (int f = 0; f < mesh.face_count(); ++f) {
            if (std::count(mesh.faces[f].begin(), mesh.faces[f].end(), v) != 0) {
                labels_here.insert(labels[f]);
                colors_here.insert(colors[labels[f]]);
            }
        }
        EXPECT_EQ(labels_here.size(), colors_here.size()) << "vertex " << v;
    }
}

TEST(ColorSubmeshes, EdgeNeighborsOfScatteredLabelsDifferEvenWhenThePaletteIsTooSmall) {
    const TriangleMesh mesh = make_torus_grid(50, 50);
    const DualGraph dual_graph = build_dual_graph(mesh);
    for (int submesh_count : {2, 5, 20, 60}) {
        std::vector<int> labels(mesh.faces.size());
        Random random(7, submesh_count);
        for (int& label : labels) {
            label = static_cast<int>(random.below(submesh_count));
        }
        const std::vector<int> colors = color_submeshes(mesh, dual_graph, labels, submesh_count);
        EXPECT_TRUE(edge_neighbors_differ(dual_graph, labels, colors)) << submesh_count;
    }
}

TEST(ColorSubmeshes, EveryFaceItsOwnLabelNeedsOnlyThePalette) {
    const TriangleMesh mesh = make_torus_grid(12, 12);
    const DualGraph dual_graph = build_dual_graph(mesh);
    std::vector<int> labels(mesh.faces.size());
    for (int f = 0; f < mesh.face_count(); ++f) {
        labels[f] = f;
    }
    const std::vector<int> colors = color_submeshes(mesh, dual_graph, labels, mesh.face_count());
    EXPECT_TRUE(edge_neighbors_differ(dual_graph, labels, colors));
    EXPECT_LT(*std::max_element(colors.begin(), colors.end()), 8);
}

TEST(ColorSubmeshes, EmptySubmeshesGetAColorToo) {
    const TriangleMesh mesh = make_torus_grid(3, 3);
    const std::vector<int> labels(mesh.faces.size(), 2);
    EXPECT_EQ(submesh_colors(mesh, build_dual_graph(mesh), labels, 4).size(), 4u);
}

} // namespace
} // namespace spheroseg
