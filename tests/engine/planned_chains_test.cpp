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

    void follow(bool outward) {
        chains.follow(outward, random, [](std::int64_t) {});
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
            chains.follow(outward_first);
            EXPECT_LE(imbalance(patchwork), first - first / 8) << k;
            for (bool outward : {true, false, true, false}) {
                const int before = imbalance(patchwork);
                chains.follow(outward);
                EXPECT_LE(imbalance(patchwork), before) << k;
                EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k;
            }
        }
    }
}

// In a strip of triangles, pairs but for three at one end and one at the other, the only chain
// leads through all of them.
TEST(PlannedChains, AChainMayBeAsLongAsThereAreSubmeshes) {
    constexpr int kSubmeshes = 1000;
    TriangleMesh strip;
    std::vector<int> labels;
    for (int i = 0; i < 2 * kSubmeshes; ++i) {
        strip.faces.push_back(i % 2 == 0 ? Triangle{i, i + 1, i + 2} : Triangle{i + 1, i, i + 2});
        labels.push_back(i == 0 ? 0 : (i - 1) / 2);
    }
    for (std::size_t i = 0; i < strip.faces.size() + 2; ++i) {
        strip.positions.push_back({0.5 * static_cast<double>(i), static_cast<double>(i % 2), 0.0});
    }
    const Levels levels(strip);
    for (bool outward : {true, false}) {
        Patchwork patchwork = levels.multilevel.coarsen(2 * kSubmeshes, kSubmeshes);
        levels.multilevel.set_labels(patchwork, labels);
        ASSERT_EQ(imbalance(patchwork), 2);
        ChainsOf chains(patchwork);
        chains.follow(outward);
        EXPECT_EQ(imbalance(patchwork), 0);
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    }
}

} // namespace
} // namespace spheroseg
