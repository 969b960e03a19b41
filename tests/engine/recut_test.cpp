// SPDX-License-Identifier: GPL-3.0-or-later
#include "recut.h"

#include "balance.h"
#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace spheroseg {
namespace {

using namespace test;

constexpr std::int64_t kManyCuts = 1 << 30;

TEST(Recut, BalancesSmallSubmeshesOfStackedTriangulations) {
    int balanced_count = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const Levels levels(stacked(600, seed));
        for (int faces_each : {2, 3, 5, 8, 15}) {
            const int k = 600 / faces_each;
            Patchwork patchwork = levels.multilevel.coarsen(600, k);
            bisect(patchwork, k, seed, 1);
            repair(patchwork);
            std::int64_t cuts_left = kManyCuts;
            const bool balanced = recut_to_balance(patchwork, cuts_left);
            const Measures measures = measures_of(levels, patchwork);
            EXPECT_TRUE(is_sound(measures)) << faces_each << ", seed " << seed;
            EXPECT_EQ(measures.is_valid(), balanced) << faces_each << ", seed " << seed;
            EXPECT_EQ(patchwork.load, measures.submesh_triangles);
            balanced_count += balanced;
        }
    }
    EXPECT_GE(balanced_count, 45); // of 50, in one go from rough starts
}

TEST(Recut, CarriesAFaceAcrossTheMesh) {
    const Levels levels(displaced_sphere(4));
    const int face_count = levels.mesh.face_count();
    for (int k : {face_count / 4, face_count / 16}) {
        Patchwork patchwork = ragged_patchwork(levels, k, 1);
        ASSERT_TRUE(balance_exactly(patchwork));
        // One face passes to the sub-mesh beside it; then it is to pass on, all over the mesh, to
        // where a sub-mesh far away gave one.
        std::vector<Move> moves;
        for (int f : {0, face_count / 2}) {
            for (bool moved = false; !moved; ++f) {
                f %= face_count;
                for (int c = 0; c < 3 && !moved; ++c) {
                    Move move;
                    moved = describe_single(patchwork, f, c, move) &&
                        single_is_allowed(patchwork, f, c, move);
                    if (moved) {
                        apply(patchwork, move);
                        moves.push_back(move);
                    }
                }
            }
        }
        ASSERT_EQ(moves.size(), 2U);
        EXPECT_GT(imbalance(patchwork), 0) << k;
        std::int64_t cuts_left = kManyCuts;
        EXPECT_TRUE(recut_to_balance(patchwork, cuts_left)) << k;
        EXPECT_LT(cuts_left, kManyCuts);
        EXPECT_TRUE(measures_of(levels, patchwork).is_valid()) << k;
    }
}

TEST(Recut, IsNeverFartherOffThanItWas) {
    int balanced_count = 0;
    int stuck_count = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        // Few of these can be balanced.
        const Levels levels(seed % 2 == 0 ? sieve(displaced_sphere(3), 0.1, seed)
                                          : random_tree(300, seed));
        const int face_count = levels.mesh.face_count();
        for (int faces_each : {2, 3, 5, 12, 150}) {
            Patchwork patchwork = levels.multilevel.coarsen(face_count, face_count / faces_each);
            bisect(patchwork, patchwork.submesh_count(), seed, 1);
            repair(patchwork);
            const int before = imbalance(patchwork);
            std::int64_t cuts_left = kManyCuts;
            const bool balanced = recut_to_balance(patchwork, cuts_left);
            EXPECT_LE(imbalance(patchwork), before) << faces_each << ", seed " << seed;
            EXPECT_EQ(imbalance(patchwork) == 0, balanced) << faces_each << ", seed " << seed;
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << faces_each << ", " << seed;
            (balanced ? balanced_count : stuck_count) += 1;
        }
    }
    EXPECT_GT(balanced_count, 10);
    EXPECT_GT(stuck_count, 10);
}

TEST(Recut, StopsWhenTimeOrCutsAreUpOrTheUserSaysSo) {
    const Levels levels(stacked(600, 1));
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 150);
    bisect(patchwork, 150, 1, 1);
    repair(patchwork);
    ASSERT_GT(imbalance(patchwork), 0);
    const std::vector<int> before = cell_labels(patchwork);
    const Deadline overdue(1e-9);
    std::this_thread::sleep_for(std::chrono::milliseconds(1100));
    ASSERT_TRUE(overdue.is_overdue());
    std::int64_t cuts_left = kManyCuts;
    EXPECT_FALSE(recut_to_balance(patchwork, cuts_left, &overdue));
    EXPECT_THROW(
        recut_to_balance(patchwork, cuts_left, nullptr, [](double, const char*) { return false; }),
        Cancelled);
    EXPECT_EQ(cuts_left, kManyCuts);
    EXPECT_EQ(cell_labels(patchwork), before);

    // A round, in which each of 150 sub-meshes takes 16 at most, is finished.
    cuts_left = 10;
    EXPECT_FALSE(recut_to_balance(patchwork, cuts_left));
    EXPECT_LE(cuts_left, 0);
    EXPECT_GE(cuts_left, 10 - 16 * 150);
}

} // namespace
} // namespace spheroseg
