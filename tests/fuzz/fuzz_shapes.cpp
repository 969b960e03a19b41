// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_shapes.h"

#include "../engine/test_meshes.h"

namespace spheroseg::fuzz {

TriangleMesh glued_grid(int columns, int rows, int glue_columns, int glue_rows) {
    TriangleMesh mesh;
    const auto at = [&](int x, int y) {
        if (x == columns && glue_columns > 0) {
            x = 0;
            y = glue_columns == 2 ? rows - y : y;
        }
        if (y == rows && glue_rows > 0) {
            y = 0;
            x = glue_rows == 2 && x > 0 ? columns - x : x;
        }
        return y * (columns + 1) + x;
    };
    for (int y = 0; y <= rows; ++y) {
        for (int x = 0; x <= columns; ++x) {
            mesh.positions.push_back({1.0 * x, 1.0 * y, 0.1 * x * y});
            if (x < columns && y < rows) {
                mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
                mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
            }
        }
    }
    return mesh;
}

TriangleMesh strip(int face_count) {
    TriangleMesh mesh;
    for (int v = 0; v < face_count + 2; ++v) {
        mesh.positions.push_back({1.0 * v, 1.0 * (v % 2), 0.0});
    }
    for (int f = 0; f < face_count; ++f) {
        mesh.faces.push_back(f % 2 == 0 ? Triangle{f, f + 1, f + 2} : Triangle{f + 1, f, f + 2});
    }
    return mesh;
}

TriangleMesh fan(int face_count, bool closed) {
    TriangleMesh mesh;
    mesh.positions.push_back({0, 0, 0});
    const int rim = closed ? face_count : face_count + 1;
    for (int v = 0; v < rim; ++v) {
        mesh.positions.push_back({std::cos(0.1 * v), std::sin(0.1 * v), 0.0});
    }
    for (int f = 0; f < face_count; ++f) {
        mesh.faces.push_back({0, 1 + f, 1 + (f + 1) % rim});
    }
    return mesh;
}

TriangleMesh read_shape(ByteReader& bytes) {
    switch (bytes.below(12)) {
    case 0:
        return test::tetrahedron();
    case 1:
        return test::octahedron();
    case 2:
        return test::icosphere(bytes.below(3));
    case 3:
        return test::bipyramid(bytes.between(3, 40));
    case 4: {
        const int around = bytes.between(3, 6);
        return test::long_thin_limb(around, bytes.between(1, 12));
    }
    case 5:
        return test::slivers(bytes.between(1, 30), bytes.below(2) == 1, bytes.byte());
    case 6:
        return strip(bytes.between(1, 40));
    case 7: {
        const int face_count = bytes.between(3, 40);
        return fan(face_count, bytes.below(2) == 1);
    }
    case 8:
        return triangle_tree(bytes, bytes.between(1, 24));
    case 9:
        return test::flipped_sphere(1, bytes.between(1, 200), bytes.byte());
    default: {
        const int columns = bytes.between(1, 8);
        const int rows = bytes.between(1, 8);
        const int glue = bytes.below(9);
        return glued_grid(columns, rows, glue % 3, glue / 3);
    }
    }
}

} // namespace spheroseg::fuzz
