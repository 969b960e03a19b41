// SPDX-License-Identifier: GPL-3.0-or-later
#include "balance.h"

#include "patchwork_meshes.h"
#include "recut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace spheroseg {
namespace {

using namespace test;

TEST(Balance, EverySubmeshHoldsFloorOrCeilingFacesOrItSaysSo) {
    const Levels levels(displaced_sphere(3));
    for (int k : {2, 7, 31, 200}) {
        // Many small sub-meshes may get stuck without annealing; they stay sound all the same.
        Patchwork patchwork = rough_patchwork(levels, k, 1);
        const bool balanced = balance_exactly(patchwork);
        EXPECT_TRUE(balanced || k == 200) << k;
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k;
        EXPECT_EQ(measures_of(levels, patchwork).is_valid(), balanced) << k;
    }
}

TEST(Balance, ExactBalanceOfTwoToFourFacesEachNeedsNoAnnealing) {
    const Levels levels(displaced_sphere(4));
    const int face_count = levels.mesh.face_count();
    // A chain of passes breaks at nearly every sub-mesh here, unless each is planned.
    for (int k : {face_count / 2, 2 * face_count / 5, 5 * face_count / 16, face_count / 4}) {
        for (std::uint64_t seed : {1, 2, 3}) {
            Patchwork patchwork = ragged_patchwork(levels, k, seed);
            const int before = misplaced(patchwork);
            std::int64_t cuts_left = std::int64_t{100} * k;
            if (!balance_exactly(patchwork)) {
                EXPECT_LT(misplaced(patchwork), before / 20) << k << ", seed " << seed;
                EXPECT_TRUE(recut_to_balance(patchwork, cuts_left)) << k << ", seed " << seed;
            }
            EXPECT_TRUE(measures_of(levels, patchwork).is_valid()) << k << ", seed " << seed;
        }
    }
}

TEST(Balance, StopsWhenTimeOrWorkIsUp) {
    const Levels levels(displaced_sphere(4));
    const int face_count = levels.mesh.face_count();
    const Patchwork ragged = ragged_patchwork(levels, face_count / 3, 1);
    const auto reports_until = [&](const Deadline* deadline, std::int64_t most_work) {
        Patchwork patchwork = ragged;
        int reports = 0;
        const auto count = [&](double, const char*) {
            ++reports;
            return true;
        };
        balance_exactly(patchwork, deadline, count, most_work);
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
        EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
        return reports;
    };
    const Deadline deadline(1e-9);
    const std::int64_t endless = std::numeric_limits<std::int64_t>::max();
    EXPECT_GT(reports_until(nullptr, endless), 3);
    EXPECT_EQ(reports_until(&deadline, endless), 1);
    EXPECT_EQ(reports_until(nullptr, 1), 1);
}

// Two large sub-meshes pass thousands of faces along one chain.
TEST(Balance, StopsBetweenThePassesOfAChainWhenTimeIsUp) {
    const Levels levels(displaced_sphere(5));
    const Patchwork eighths = rough_patchwork(levels, 8, 1);
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 2);
    for (int f = 0; f < patchwork.face_count(); ++f) {
        patchwork.set_own_label(f, eighths.label(f) == 7);
    }
    patchwork.tell_neighbors();
    repair(patchwork);
    const std::int64_t before = misplaced(patchwork);
    ASSERT_GT(before, patchwork.face_count() / 2);
    const Deadline deadline(1e-9);
    EXPECT_FALSE(balance_exactly(patchwork, &deadline));
    EXPECT_GT(misplaced(patchwork), before / 2);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    EXPECT_TRUE(balance_exactly(patchwork));
}

TEST(Balance, IsHopelessWhereMoreThanAHundredAndOneOfFiftyAreOff) {
    const Levels levels(displaced_sphere(5)); // 20,480 faces
    for (const auto& [k, most_off] : {std::pair{64, 64}, {2048, 100}, {5120, 102}, {10240, 204}}) {
        Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), k);
        const int mean = levels.mesh.face_count() / k;
        for (int off : {0, most_off, most_off + 2}) {
            patchwork.load.assign(k, mean);
            for (int l = 0; l < std::min(off, k); ++l) {
                patchwork.load[l] += l % 2 == 0 ? 1 : -1;
            }
            EXPECT_EQ(is_hopeless(patchwork), off > most_off && k > most_off) << off << " of " << k;
        }
    }
}

TEST(Balance, IsNeverFartherOffThanItWas) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        // Few of these can be balanced.
        const Levels levels(seed % 2 == 0 ? sieve(displaced_sphere(3), 0.3, seed)
                                          : random_tree(300, seed));
        const int face_count = levels.mesh.face_count();
        for (int k : {10, 25, 100}) {
            if (3 * k > face_count) {
                continue;
            }
            Patchwork patchwork = rough_patchwork(levels, k, seed);
            const int before = misplaced(patchwork);
            const bool balanced = balance_exactly(patchwork);
            EXPECT_LE(misplaced(patchwork), before) << k << ", seed " << seed;
            EXPECT_EQ(misplaced(patchwork) == 0, balanced) << k << ", seed " << seed;
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k << ", seed " << seed;
        }
    }
}

} // namespace
} // namespace spheroseg
