// SPDX-License-Identifier: GPL-3.0-or-later
#include "boundary.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheroseg {
namespace {

using namespace test;

TEST(Boundary, EveryFaceThatComesToTheBoundaryIsListed) {
    const Levels levels(flipped_sphere(3, 100));
    Patchwork patchwork = ragged_patchwork(levels, 20, 7);
    BoundaryFaces boundary(patchwork, 1);
    int moved_faces = 0;
    for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
        Fan fan;
        if (!describe_shorter_fan(patchwork, i / 6, i % 3, (i / 3) % 2 != 0, fan) ||
            !fan_is_allowed(patchwork, fan)) {
            continue;
        }
        const Move& move = fan.move;
        apply(patchwork, move);
        for (int j = 0; j < move.face_count; ++j) {
            boundary.list_around(patchwork, move.faces[j], move.from, boundary.faces());
        }
        moved_faces += move.face_count > 2 ? move.face_count : 0;
    }
    EXPECT_GT(moved_faces, 100);
    std::vector<int> listed = boundary.faces();
    std::sort(listed.begin(), listed.end());
    EXPECT_EQ(std::adjacent_find(listed.begin(), listed.end()), listed.end());
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (patchwork.label_across(f, c) != patchwork.label(f)) {
                EXPECT_TRUE(std::binary_search(listed.begin(), listed.end(), f)) << f;
            }
        }
    }
}

} // namespace
} // namespace spheroseg
