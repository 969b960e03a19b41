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

TEST(Recut, BalancesSubmeshesOfStackedTriangulations) {
    constexpr int kFaces = 3000;
    int balanced_count = 0;
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
        const Levels levels(stacked(kFaces, seed));
        for (int faces_each : {2, 3, 5, 8, 15, 50, 100, 150, 300, 1000}) {
            const int k = kFaces / faces_each;
            Patchwork patchwork = rough_patchwork(levels, k, seed);
            std::int64_t cuts_left = kManyCuts;
            const bool balanced = recut_to_balance(patchwork, cuts_left);
            const Measures measures = measures_of(levels, patchwork);
            EXPECT_TRUE(is_sound(measures)) << faces_each << ", seed " << seed;
            EXPECT_EQ(measures.is_valid(), balanced) << faces_each << ", seed " << seed;
            EXPECT_EQ(patchwork.load, measures.submesh_triangles);
            balanced_count += balanced;
        }
    }
    EXPECT_GE(balanced_count, 49); // of 50, in one go from rough starts
}

/// Passes a face from sub-mesh `from` to one beside it, drawn at random. Returns that one.
int pass_any(Patchwork& patchwork, int from, Random& random) {
    Move chosen;
    std::uint32_t count = 0;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3 && patchwork.label(f) == from; ++c) {
            Move move;
            if (is_allowed_pass(patchwork, {f, c}, move) && random.below(++count) == 0) {
                chosen = move;
            }
        }
    }
    apply(patchwork, chosen);
    return chosen.to;
}

TEST(Recut, CarriesAFaceBackAcrossTheMesh) {
    const Levels levels(displaced_sphere(4));
    const int face_count = levels.mesh.face_count();
    std::int64_t cut_count = 0;
    int carried_count = 0;
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Patchwork patchwork = ragged_patchwork(levels, face_count / 16, 2);
        std::int64_t cuts_before = kManyCuts;
        ASSERT_TRUE(balance_exactly(patchwork) || recut_to_balance(patchwork, cuts_before));
        Random random(seed);
        int at = 0;
        for (int i = 0; i < 200; ++i) {
            at = pass_any(patchwork, at, random);
        }
        std::int64_t cuts_left = kManyCuts;
        EXPECT_TRUE(recut_to_balance(patchwork, cuts_left)) << seed;
        EXPECT_TRUE(measures_of(levels, patchwork).is_valid()) << seed;
        carried_count += at != 0;
        cut_count += kManyCuts - cuts_left;
    }
    EXPECT_GT(carried_count, 15);
    // By chance alone it takes seven times as many as it does.
    EXPECT_LT(cut_count, 5000);
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
            Patchwork patchwork = rough_patchwork(levels, face_count / faces_each, seed);
            const int before = misplaced(patchwork);
            std::int64_t cuts_left = kManyCuts;
            const bool balanced = recut_to_balance(patchwork, cuts_left);
            EXPECT_LE(misplaced(patchwork), before) << faces_each << ", seed " << seed;
            // 100 cuts per sub-mesh that bring nothing, and a round, for each face that is off.
            EXPECT_LE(kManyCuts - cuts_left, 116 * (before + 1) * patchwork.submesh_count())
                << faces_each << ", seed " << seed;
            EXPECT_EQ(misplaced(patchwork) == 0, balanced) << faces_each << ", seed " << seed;
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << faces_each << ", " << seed;
            (balanced ? balanced_count : stuck_count) += 1;
        }
    }
    EXPECT_GT(balanced_count, 10);
    EXPECT_GT(stuck_count, 10);
}

TEST(Recut, StopsWhenTimeOrCutsAreUpOrTheUserSaysSo) {
    const Levels levels(stacked(600, 1));
    Patchwork patchwork = rough_patchwork(levels, 150, 1);
    ASSERT_GT(misplaced(patchwork), 0);
    const std::vector<int> before = cell_labels(patchwork);
    const Deadline deadline(1e-9);
    ASSERT_TRUE(deadline.expired());
    std::int64_t cuts_left = kManyCuts;
    EXPECT_FALSE(recut_to_balance(patchwork, cuts_left, TreeTurns::random, &deadline));
    EXPECT_THROW(recut_to_balance(patchwork,
                                  cuts_left,
                                  TreeTurns::random,
                                  nullptr,
                                  [](double, const char*) { return false; }),
                 Cancelled);
    EXPECT_EQ(cuts_left, kManyCuts);
    EXPECT_EQ(cell_labels(patchwork), before);

    // A round, in which each of 150 sub-meshes takes 48 at most, is finished; a next one is none.
    cuts_left = 1;
    EXPECT_FALSE(recut_to_balance(patchwork, cuts_left));
    EXPECT_LE(cuts_left, 0);
    EXPECT_GE(cuts_left, 1 - 48 * 150);
    const std::vector<int> after = cell_labels(patchwork);
    EXPECT_FALSE(recut_to_balance(patchwork, cuts_left));
    EXPECT_EQ(cell_labels(patchwork), after);
}

// What can not be balanced keeps it busy.
TEST(Recut, StopsOnTheWayToo) {
    const Levels levels(random_tree(1000, 1));
    Patchwork patchwork = rough_patchwork(levels, 30, 1);
    std::int64_t cuts_left = kManyCuts;
    int reports = 0;
    EXPECT_THROW(recut_to_balance(patchwork,
                                  cuts_left,
                                  TreeTurns::random,
                                  nullptr,
                                  [&](double, const char*) { return ++reports < 3; }),
                 Cancelled);
    EXPECT_LT(cuts_left, kManyCuts);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);

    const Deadline deadline(1.0);
    reports = 0;
    const auto wait_in_the_third = [&](double, const char*) {
        if (++reports == 3) {
            std::this_thread::sleep_for(std::chrono::seconds(1));
        }
        return true;
    };
    EXPECT_FALSE(
        recut_to_balance(patchwork, cuts_left, TreeTurns::random, &deadline, wait_in_the_third));
    EXPECT_EQ(reports, 3);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
}

TEST(Recut, CarriesFacesAlongManyTubes) {
    // What is off in a tube can only be made up for in another one, some hundred sub-meshes away.
    const Levels levels(tubes_on_sphere(10, 300));
    const int face_count = levels.mesh.face_count();
    const int k = face_count / 3;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        Patchwork patchwork = rough_patchwork(levels, k, seed);
        std::int64_t cuts_left = kManyCuts;
        EXPECT_TRUE(recut_to_balance(patchwork, cuts_left)) << seed;
        EXPECT_TRUE(measures_of(levels, patchwork).is_valid()) << seed;
    }
}

// Each sub-mesh of 250 faces gets one tooth of 160, and a part of another along all its length.
TEST(Recut, SplitsLimbsLengthwiseAlongWalls) {
    const Levels levels(flat_comb(12, 40));
    const int face_count = levels.mesh.face_count();
    const int k = face_count / 250;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        Patchwork patchwork = rough_patchwork(levels, k, seed);
        Patchwork at_random = patchwork;
        std::int64_t cuts_left = kManyCuts;
        EXPECT_TRUE(recut_to_balance(patchwork, cuts_left, TreeTurns::often_along_walls)) << seed;
        EXPECT_TRUE(measures_of(levels, patchwork).is_valid()) << seed;
        const std::int64_t cuts = kManyCuts - cuts_left;
        std::int64_t more_cuts_left = 2 * cuts;
        EXPECT_FALSE(recut_to_balance(at_random, more_cuts_left)) << seed << ", cuts: " << cuts;
    }
}

TEST(Recut, DoesNotGoToAndFroBetweenNests) {
    const Levels levels(evenly_stacked(2000));
    const int face_count = levels.mesh.face_count();
    int balanced_count = 0;
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        for (int faces_each : {3, 4, 7, 20}) {
            Patchwork patchwork = rough_patchwork(levels, face_count / faces_each, seed);
            std::int64_t cuts_left = kManyCuts;
            balanced_count += recut_to_balance(patchwork, cuts_left);
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << faces_each << ", " << seed;
        }
    }
    EXPECT_GE(balanced_count, 15); // of 16; where walks may turn back 9
}

} // namespace
} // namespace spheroseg
