// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "byte_reader.h"
#include "types.h"

#include <utility>
#include <vector>

namespace spheroseg::fuzz {

/// Rows and columns of squares cut in two. Opposite sides may be glued, straight (1) or reversed
/// (2): cylinder, Moebius band, torus, Klein bottle, projective plane.
TriangleMesh glued_grid(int columns, int rows, int glue_columns, int glue_rows);

/// Triangles in a row; the dual graph is a path.
TriangleMesh strip(int face_count);

/// Triangles around one vertex; open unless `closed`.
TriangleMesh fan(int face_count, bool closed);

/// A triangle to which others are glued, each at an open edge: the dual graph is a tree.
/// `choices.below(count)` chooses the edges.
template <class Choices> TriangleMesh triangle_tree(Choices& choices, int face_count) {
    TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    std::vector<std::pair<int, int>> open = {{0, 1}, {1, 2}, {2, 0}};
    while (mesh.face_count() < face_count) {
        const auto side = choices.below(static_cast<int>(open.size()));
        const auto [a, b] = open[side];
        const int v = mesh.vertex_count();
        mesh.positions.push_back({0.3 * v, 1.0 * (v % 3), 0.1 * (v % 5)});
        mesh.faces.push_back({b, a, v});
        open[side] = {a, v};
        open.push_back({v, b});
    }
    return mesh;
}

/// A simple surface of some dozens of faces.
TriangleMesh read_shape(ByteReader& bytes);

} // namespace spheroseg::fuzz
