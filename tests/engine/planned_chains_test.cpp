// SPDX-License-Identifier: GPL-3.0-or-later
#include "planned_chains.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

struct ChainsOf {
    explicit ChainsOf(Patchwork& from)
        : boundaries(from), chains(from, boundaries, even_loads(from)) {}

    void follow(bool outward, const PlannedChains::GoOn& go_on) {
        chains.follow(outward, random, go_on);
    }

    SubmeshBoundaries boundaries;
    PlannedChains chains;
    Random random{1};
};

TEST(PlannedChains, OneSearchRelievesManySubmeshesAndLeavesAllSound) {
    const Levels levels(displaced_sphere(3));
    const int face_count = levels.mesh.face_count();
    for (int k : {face_count / 4, face_count / 3, 2 * face_count / 5, face_count / 2}) {
        for (bool outward_first : {true, false}) {
            Patchwork patchwork = ragged_patchwork(levels, k, 1);
            ChainsOf chains(patchwork);
            const int first = imbalance(patchwork);
            chains.follow(outward_first, [](std::int64_t) { return true; });
            EXPECT_LE(imbalance(patchwork), first - first / 8) << k;
            for (bool outward : {true, false, true, false}) {
                const int before = imbalance(patchwork);
                chains.follow(outward, [](std::int64_t) { return true; });
                EXPECT_LE(imbalance(patchwork), before) << k;
                EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k;
            }
        }
    }
}

TEST(PlannedChains, ASearchThatIsEndedMakesWhatItFound) {
    const Levels levels(displaced_sphere(3));
    Patchwork patchwork = ragged_patchwork(levels, levels.mesh.face_count() / 3, 1);
    const std::vector<int> labels = cell_labels(patchwork);
    const int before = imbalance(patchwork);
    ChainsOf chains(patchwork);
    chains.follow(true, [](std::int64_t) { return false; });
    EXPECT_EQ(cell_labels(patchwork), labels);

    int left = 1000;
    chains.follow(true, [&left](std::int64_t) { return --left > 0; });
    const int cut_short = imbalance(patchwork);
    EXPECT_LT(cut_short, before);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));

    // It left no marks behind.
    chains.follow(true, [](std::int64_t) { return true; });
    EXPECT_LT(imbalance(patchwork), cut_short);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
}

} // namespace
} // namespace spheroseg
