// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_mesh.h"

#include "../engine/test_meshes.h"

#include <limits>

namespace spheroseg::fuzz {

namespace {

constexpr int kMaxSteps = 48;

TriangleMesh face_list(ByteReader& bytes) {
    TriangleMesh mesh;
    const int vertex_count = bytes.between(3, 14);
    for (int v = 0; v < vertex_count; ++v) {
        mesh.positions.push_back({std::cos(v), std::sin(2.0 * v), 0.1 * v});
    }
    while (!bytes.empty() && mesh.face_count() < 60) {
        const int a = bytes.below(vertex_count);
        const int b = bytes.below(vertex_count);
        mesh.faces.push_back({a, b, bytes.below(vertex_count)});
    }
    return mesh;
}

/// Rows and columns of squares cut in two. Opposite sides may be glued, straight or reversed:
/// cylinder, Moebius band, torus, Klein bottle, projective plane.
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

/// Triangles in a row; the dual graph is a path.
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

/// Triangles around one vertex; open unless `closed`.
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

/// A triangle to which others are glued, each at an open edge: the dual graph is a tree.
TriangleMesh triangle_tree(ByteReader& bytes, int face_count) {
    TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    std::vector<std::pair<int, int>> open = {{0, 1}, {1, 2}, {2, 0}};
    while (mesh.face_count() < face_count) {
        const int side = bytes.below(static_cast<int>(open.size()));
        const auto [a, b] = open[side];
        const int v = mesh.vertex_count();
        mesh.positions.push_back({0.3 * v, 1.0 * (v % 3), 0.1 * (v % 5)});
        mesh.faces.push_back({b, a, v});
        open[side] = {a, v};
        open.push_back({v, b});
    }
    return mesh;
}

TriangleMesh shape(ByteReader& bytes) {
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

void replace_vertex(TriangleMesh& mesh, int from, int to) {
    for (Triangle& t : mesh.faces) {
        std::replace(t.begin(), t.end(), from, to);
    }
}

/// Flips the edge at a corner of a face, if another face shares it.
void flip_edge(TriangleMesh& mesh, int face, int corner) {
    const Triangle t = mesh.faces[face];
    const int a = t[corner];
    const int b = t[(corner + 1) % 3];
    for (Triangle& other : mesh.faces) {
        for (int c = 0; c < 3; ++c) {
            if (other[c] == b && other[(c + 1) % 3] == a) {
                const int left = t[(corner + 2) % 3];
                const int right = other[(c + 2) % 3];
                other = {b, left, right};
                mesh.faces[face] = {a, right, left};
                return;
            }
        }
    }
}

void split_face(TriangleMesh& mesh, int face) {
    const Triangle t = mesh.faces[face];
    const int v = mesh.vertex_count();
    mesh.positions.push_back((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) *
                             (1.0 / 3.0));
    mesh.faces[face] = {t[0], t[1], v};
    mesh.faces.push_back({t[1], t[2], v});
    mesh.faces.push_back({t[2], t[0], v});
}

/// Deletes the faces around a vertex: a hole.
void cut_hole(TriangleMesh& mesh, int vertex) {
    const auto touches = [&](const Triangle& t) {
        return t[0] == vertex || t[1] == vertex || t[2] == vertex;
    };
    mesh.faces.erase(std::remove_if(mesh.faces.begin(), mesh.faces.end(), touches),
                     mesh.faces.end());
}

void spoil_vertex(TriangleMesh& mesh, int vertex, int how) {
    const double values[] = {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(),
                             -1e308,
                             5e-324};
    mesh.positions[vertex].y = values[how];
}

void change(TriangleMesh& mesh, ByteReader& bytes) {
    const int kind = bytes.below(20);
    if (mesh.faces.empty() || kind < 2) {
        test::append(mesh, shape(bytes));
        return;
    }
    const int face = bytes.below(mesh.face_count());
    Triangle& t = mesh.faces[face];
    const int corner = bytes.below(3);
    switch (kind) {
    case 2:
    case 3:
    case 4:
        flip_edge(mesh, face, corner);
        break;
    case 5:
    case 6:
        mesh.faces.erase(mesh.faces.begin() + face);
        break;
    case 7:
    case 8:
        replace_vertex(mesh, t[corner], mesh.faces[bytes.below(mesh.face_count())][0]);
        break;
    case 9:
        mesh.faces.push_back(t);
        break;
    case 10:
        std::swap(t[0], t[1]);
        break;
    case 11:
    case 12:
        split_face(mesh, face);
        break;
    case 13:
        cut_hole(mesh, t[corner]);
        break;
    case 14:
        // The face gets a vertex of its own: a slit.
        mesh.positions.push_back(mesh.positions[t[corner]]);
        t[corner] = mesh.vertex_count() - 1;
        break;
    case 15:
        std::swap(t, mesh.faces[bytes.below(mesh.face_count())]);
        break;
    case 16:
        mesh.positions.push_back({0, 0, 0});
        break;
    case 17:
        mesh.positions[t[corner]] = mesh.positions[t[(corner + 1) % 3]];
        break;
    case 18:
        if (bytes.below(4) == 0) {
            spoil_vertex(mesh, t[corner], bytes.below(4));
        }
        break;
    default:
        if (bytes.below(4) == 0) {
            t[corner] = bytes.below(8) == 0 ? -1 : mesh.vertex_count() + bytes.below(3);
        }
        break;
    }
}

bool has_bad_index(const TriangleMesh& mesh) {
    for (const Triangle& t : mesh.faces) {
        for (int v : t) {
            if (v < 0 || v >= mesh.vertex_count()) {
                return true;
            }
        }
    }
    return false;
}

} // namespace

TriangleMesh read_mesh(ByteReader& bytes) {
    if (bytes.below(8) == 0) {
        return face_list(bytes);
    }
    TriangleMesh mesh = shape(bytes);
    for (int step = 0; step < kMaxSteps && !bytes.empty() && mesh.face_count() <= kMaxFaces;
         ++step) {
        change(mesh, bytes);
        if (has_bad_index(mesh)) {
            break;
        }
    }
    mesh.faces.resize(std::min<std::size_t>(mesh.faces.size(), kMaxFaces));
    return mesh;
}

} // namespace spheroseg::fuzz
