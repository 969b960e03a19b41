// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_mesh.h"

#include "fuzz_changes.h"
#include "fuzz_large.h"
#include "fuzz_shapes.h"

#include <algorithm>
#include <cmath>

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

/// Changes a mesh step by step until the bytes are used up.
void change_often(TriangleMesh& mesh, ByteReader& bytes, int max_faces) {
    for (int step = 0; step < kMaxSteps && !bytes.empty() && mesh.face_count() <= max_faces;
         ++step) {
        change(mesh, bytes);
        if (has_bad_index(mesh)) {
            break;
        }
    }
    mesh.faces.resize(std::min<std::size_t>(mesh.faces.size(), max_faces));
}

} // namespace

TriangleMesh read_mesh(ByteReader& bytes, bool large) {
    TriangleMesh mesh;
    if (large) {
        mesh = read_large_mesh(bytes);
    } else if (bytes.below(8) == 0) {
        return face_list(bytes);
    } else {
        mesh = read_shape(bytes);
    }
    change_often(mesh, bytes, large ? kMaxLargeFaces : kMaxFaces);
    return mesh;
}

} // namespace spheroseg::fuzz
