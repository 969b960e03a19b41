// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheroseg::test {

/// A small mesh that is undone step by step: the faces that live now, by input index.
class Replay {
public:
    Replay(const CollapseHierarchy& hierarchy, int face_count)
        : hierarchy_(hierarchy), faces_(face_count, kNone) {
        for (std::size_t i = 0; i < hierarchy.base_faces.size(); ++i) {
            faces_[hierarchy.base_faces[i]] = hierarchy.base_triangles[i];
        }
    }

    const std::vector<Triangle>& faces() const { return faces_; }
    bool lives(int face) const { return faces_[face] != kNone; }

    /// Undoes step i; fails the test where the faces are not what the step says it left.
    void undo(int i) {
        const int begin = hierarchy_.star_begin[i];
        const int degree = hierarchy_.star_begin[i + 1] - begin;
        const auto ring = [&](int j) { return hierarchy_.ring_vertices[begin + j % degree]; };
        ASSERT_GE(degree, 3);
        ASSERT_EQ(ring(0), hierarchy_.target[i]);
        for (int j = 0; j < degree; ++j) {
            const int f = hierarchy_.star_faces[begin + j];
            if (f >= static_cast<int>(faces_.size())) {
                continue; // of a cap
            }
            const bool vanished = j == 0 || j == degree - 1;
            const Triangle expected =
                vanished ? kNone : Triangle{hierarchy_.target[i], ring(j), ring(j + 1)};
            ASSERT_EQ(rotated(faces_[f]), rotated(expected)) << "step " << i << ", face " << f;
            faces_[f] = {hierarchy_.vertex[i], ring(j), ring(j + 1)};
        }
    }

    /// The living faces, closed up: empty ones left out.
    TriangleMesh living_mesh(int vertex_count) const {
        TriangleMesh mesh;
        mesh.positions.resize(vertex_count);
        for (const Triangle& t : faces_) {
            if (t != kNone) {
                mesh.faces.push_back(t);
            }
        }
        return mesh;
    }

    static Triangle rotated(const Triangle& t) {
        const int first = static_cast<int>(std::min_element(t.begin(), t.end()) - t.begin());
        return {t[first], t[(first + 1) % 3], t[(first + 2) % 3]};
    }

private:
    static constexpr Triangle kNone = {-1, -1, -1};

    const CollapseHierarchy& hierarchy_;
    std::vector<Triangle> faces_;
};

} // namespace spheroseg::test
