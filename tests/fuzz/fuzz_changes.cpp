// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_changes.h"

#include "../engine/test_meshes.h"
#include "fuzz_shapes.h"

#include <limits>

namespace spheroseg::fuzz {

namespace {

bool has_edge(const TriangleMesh& mesh, int a, int b) {
    return std::any_of(mesh.faces.begin(), mesh.faces.end(), [&](const Triangle& t) {
        return std::find(t.begin(), t.end(), a) != t.end() &&
            std::find(t.begin(), t.end(), b) != t.end();
    });
}

} // namespace

void replace_vertex(TriangleMesh& mesh, int from, int to) {
    for (Triangle& t : mesh.faces) {
        std::replace(t.begin(), t.end(), from, to);
    }
}

void flip_edge(TriangleMesh& mesh, int face, int corner, bool only_to_new_edge) {
    const Triangle t = mesh.faces[face];
    const int a = t[corner];
    const int b = t[(corner + 1) % 3];
    for (Triangle& other : mesh.faces) {
        for (int c = 0; c < 3; ++c) {
            if (other[c] == b && other[(c + 1) % 3] == a) {
                const int left = t[(corner + 2) % 3];
                const int right = other[(c + 2) % 3];
                if (only_to_new_edge && has_edge(mesh, left, right)) {
                    return;
                }
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

void cut_hole(TriangleMesh& mesh, int vertex) {
    const auto touches = [&](const Triangle& t) {
        return t[0] == vertex || t[1] == vertex || t[2] == vertex;
    };
    mesh.faces.erase(std::remove_if(mesh.faces.begin(), mesh.faces.end(), touches),
                     mesh.faces.end());
}

void detach_corner(TriangleMesh& mesh, int face, int corner) {
    int& v = mesh.faces[face][corner];
    mesh.positions.push_back(mesh.positions[v]);
    v = mesh.vertex_count() - 1;
}

namespace {

void spoil_vertex(TriangleMesh& mesh, int vertex, int how) {
    const double values[] = {std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity(),
                             -1e308,
                             5e-324};
    mesh.positions[vertex].y = values[how];
}

} // namespace

void change(TriangleMesh& mesh, ByteReader& bytes) {
    const int kind = bytes.below(20);
    if (mesh.faces.empty() || kind < 2) {
        test::append(mesh, read_shape(bytes));
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
        detach_corner(mesh, face, corner);
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

} // namespace spheroseg::fuzz
