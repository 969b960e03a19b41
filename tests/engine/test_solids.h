// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace spheroseg::test {

constexpr double kPi = 3.14159265358979323846;

/// 4 vertices, 4 faces.
inline TriangleMesh tetrahedron() {
    return {{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
            {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
}

/// A tetrahedron with a third face at the edge between its vertices 0 and 1.
inline TriangleMesh tetrahedron_with_fin() {
    TriangleMesh mesh = tetrahedron();
    mesh.faces.push_back({0, 1, mesh.vertex_count()});
    mesh.positions.push_back({3, 3, 3});
    return mesh;
}

/// 6 vertices, 8 faces.
inline TriangleMesh octahedron() {
    return {
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
}

/// 12 vertices, 20 faces, on the unit sphere.
inline TriangleMesh icosahedron() {
    TriangleMesh mesh;
    const double g = (1.0 + std::sqrt(5.0)) / 2.0;
    const double s = 1.0 / std::sqrt(1.0 + g * g);
    for (int axis = 0; axis < 3; ++axis) {
        for (double a : {-s, s}) {
            for (double b : {-g * s, g * s}) {
                mesh.positions.push_back(axis == 0       ? Vec3{0, a, b}
                                             : axis == 1 ? Vec3{b, 0, a}
                                                         : Vec3{a, b, 0});
            }
        }
    }
    // The faces are the triples of vertices at the least mutual distance, 2 s.
    const auto near = [&](int i, int j) {
        return length(mesh.positions[i] - mesh.positions[j]) < 2.1 * s;
    };
    for (int i = 0; i < 12; ++i) {
        for (int j = i + 1; j < 12; ++j) {
            for (int k = j + 1; k < 12; ++k) {
                if (near(i, j) && near(j, k) && near(i, k)) {
                    const auto& p = mesh.positions;
                    const bool outward = dot(p[i], cross(p[j], p[k])) > 0.0;
                    mesh.faces.push_back(outward ? Triangle{i, j, k} : Triangle{i, k, j});
                }
            }
        }
    }
    return mesh;
}

/// Each face into four; new vertices at the middles of the edges. 4 F faces.
inline TriangleMesh subdivide(const TriangleMesh& mesh) {
    TriangleMesh result;
    result.positions = mesh.positions;
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int a, int b) {
        const auto [entry, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                         static_cast<int>(result.positions.size()));
        if (is_new) {
            result.positions.push_back((mesh.positions[a] + mesh.positions[b]) * 0.5);
        }
        return entry->second;
    };
    for (const Triangle& t : mesh.faces) {
        const int ab = middle(t[0], t[1]);
        const int bc = middle(t[1], t[2]);
        const int ca = middle(t[2], t[0]);
        result.faces.insert(result.faces.end(),
                            {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    return result;
}

/// 20 * 4^level faces on the unit sphere.
inline TriangleMesh icosphere(int level) {
    TriangleMesh mesh = icosahedron();
    for (int i = 0; i < level; ++i) {
        mesh = subdivide(mesh);
        for (Vec3& p : mesh.positions) {
            p = p * (1.0 / length(p));
        }
    }
    return mesh;
}

/// Puts a mesh beside another one, as components of their own.
inline void append(TriangleMesh& mesh, const TriangleMesh& other) {
    const int offset = mesh.vertex_count();
    mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
    for (const Triangle& t : other.faces) {
        mesh.faces.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
    }
}

} // namespace spheroseg::test
