// SPDX-License-Identifier: GPL-3.0-or-later
#include "moves.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheroseg {
namespace {

using namespace test;

/// Soundness and boundary edges after a move, by relabelling a copy and measuring it anew.
Measures after(const Levels& levels, Patchwork patchwork, const Move& move) {
    apply(patchwork, move);
    return measures_of(levels, patchwork);
}

TEST(Moves, SingleMovesAreAllowedExactlyWhenBothSubmeshesStaySound) {
    int allowed_count = 0;
    int refused_count = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const Levels levels(flipped_sphere(2, 60, seed));
        const Patchwork patchwork = ragged_patchwork(levels, 12, seed);
        const Measures before = measures_of(levels, patchwork);
        ASSERT_TRUE(is_sound(before));
        for (int f = 0; f < patchwork.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                Move move;
                if (!describe_single(patchwork, f, c, move)) {
                    continue;
                }
                const bool allowed = single_is_allowed(patchwork, f, c, move);
                const Measures moved = after(levels, patchwork, move);
                EXPECT_EQ(moved.boundary_edge_count - before.boundary_edge_count,
                          move.boundary_change);
                if (allowed) {
                    EXPECT_TRUE(is_sound(moved)) << "face " << f << " corner " << c;
                } else {
                    EXPECT_FALSE(is_sound(moved)) << "face " << f << " corner " << c;
                }
                (allowed ? allowed_count : refused_count)++;
            }
        }
    }
    EXPECT_GT(allowed_count, 100);
    EXPECT_GT(refused_count, 100);
}

TEST(Moves, FanMovesThatAreAllowedKeepBothSubmeshesSound) {
    int allowed_count = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const Levels levels(flipped_sphere(2, 60, seed));
        const Patchwork patchwork = ragged_patchwork(levels, 12, seed + 10);
        const Measures before = measures_of(levels, patchwork);
        ASSERT_TRUE(is_sound(before));
        for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
            Fan fan;
            if (!describe_fan(patchwork, i / 6, i % 3, (i / 3) % 2 != 0, fan)) {
                continue;
            }
            const Measures moved = after(levels, patchwork, fan.move);
            EXPECT_EQ(moved.boundary_edge_count - before.boundary_edge_count,
                      fan.move.boundary_change);
            if (fan_is_allowed(patchwork, fan)) {
                EXPECT_TRUE(is_sound(moved)) << "face " << i / 6 << " way " << i % 6;
                ++allowed_count;
            }
        }
    }
    EXPECT_GT(allowed_count, 200);
}

TEST(Moves, TheShorterOfTwoFansIsTheShorterOneOfThoseThatBothFacesDescribe) {
    int turned_away = 0;
    int compared = 0;
    for (const TriangleMesh& mesh :
         {flipped_sphere(2, 60), grid_with_holes(12), moebius_strip(30, 5)}) {
        const Levels levels(mesh);
        const Patchwork patchwork = ragged_patchwork(levels, 12, 4);
        const Measures before = measures_of(levels, patchwork);
        for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
            const int face = i / 6;
            const int corner = i % 3;
            const bool forward = (i / 3) % 2 != 0;
            Fan own;
            Fan shorter;
            const bool has_own = describe_fan(patchwork, face, corner, forward, own);
            const bool has_shorter =
                describe_shorter_fan(patchwork, face, corner, forward, shorter);
            if (patchwork.label_across(face, corner) < 0 ||
                patchwork.label_across(face, corner) == patchwork.label(face)) {
                EXPECT_FALSE(has_shorter);
                continue;
            }
            // The same vertex and edge, seen from the face across.
            const int at = forward ? next_corner(corner) : corner;
            const Step across = patchwork.step_from({face, at, corner});
            const int side = corner_of(patchwork.cells[face].side[corner]);
            Fan other;
            const bool has_other =
                describe_fan(patchwork, across.face, side, across.at != side, other);
            ASSERT_EQ(has_shorter, has_own || has_other);
            if (!has_shorter) {
                continue;
            }
            const bool is_other =
                !has_own || (has_other && other.move.face_count < own.move.face_count);
            const Move& expected = is_other ? other.move : own.move;
            EXPECT_EQ(shorter.move.from, expected.from);
            EXPECT_EQ(shorter.move.to, expected.to);
            EXPECT_EQ(shorter.move.weight, expected.weight);
            EXPECT_EQ(shorter.move.boundary_change, expected.boundary_change);
            EXPECT_TRUE(std::equal(shorter.move.faces,
                                   shorter.move.faces + shorter.move.face_count,
                                   expected.faces,
                                   expected.faces + expected.face_count));
            EXPECT_EQ(fan_is_allowed(patchwork, shorter),
                      fan_is_allowed(patchwork, is_other ? other : own));
            EXPECT_EQ(after(levels, patchwork, shorter.move).boundary_edge_count -
                          before.boundary_edge_count,
                      shorter.move.boundary_change);
            turned_away += is_other;
            ++compared;
        }
    }
    EXPECT_GT(compared, 1000);
    EXPECT_GT(turned_away, 100);
}

} // namespace
} // namespace spheroseg
