// SPDX-License-Identifier: GPL-3.0-or-later
#include "planned_chains.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <optional>

namespace spheroseg {
namespace {

using namespace test;

struct ChainsOf {
    explicit ChainsOf(Patchwork& from)
        : boundaries(from), chains(from, boundaries, even_loads(from)) {}

    void follow(bool outward) {
        chains.follow(outward, random, [](std::int64_t) { return true; });
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
            const int first = misplaced(patchwork);
            chains.follow(outward_first);
            EXPECT_LE(misplaced(patchwork), first - first / 8) << k;
            for (bool outward : {true, false, true, false}) {
                const int before = misplaced(patchwork);
                chains.follow(outward);
                EXPECT_LE(misplaced(patchwork), before) << k;
                EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k;
            }
        }
    }
}

/// A strip of triangles in pairs, but for three at one end and one at the other: the only chain
/// leads through all of them.
struct Strip {
    explicit Strip(int submeshes) : submesh_count(submeshes) {
        TriangleMesh mesh;
        for (int i = 0; i < 2 * submesh_count; ++i) {
            mesh.faces.push_back(i % 2 == 0 ? Triangle{i, i + 1, i + 2}
                                            : Triangle{i + 1, i, i + 2});
            labels.push_back(i == 0 ? 0 : (i - 1) / 2);
        }
        for (int i = 0; i < 2 * submesh_count + 2; ++i) {
            mesh.positions.push_back({0.5 * i, static_cast<double>(i % 2), 0.0});
        }
        levels.emplace(mesh);
    }

    Patchwork patchwork() const {
        Patchwork patchwork = levels->multilevel.coarsen(2 * submesh_count, submesh_count);
        levels->multilevel.set_labels(patchwork, labels);
        return patchwork;
    }

    int submesh_count;
    std::vector<int> labels;
    std::optional<Levels> levels;
};

TEST(PlannedChains, AChainMayBeAsLongAsThereAreSubmeshes) {
    const Strip strip(1000);
    for (bool outward : {true, false}) {
        Patchwork patchwork = strip.patchwork();
        ASSERT_EQ(misplaced(patchwork), 2);
        ChainsOf chains(patchwork);
        chains.follow(outward);
        EXPECT_EQ(misplaced(patchwork), 0);
        EXPECT_TRUE(is_sound(measures_of(*strip.levels, patchwork)));
    }
}

TEST(PlannedChains, ASearchEndsWhenItsReportSaysSo) {
    const Strip strip(20);
    for (bool outward : {true, false}) {
        Patchwork patchwork = strip.patchwork();
        ChainsOf chains(patchwork);
        int reports = 0;
        chains.chains.follow(outward, chains.random, [&](std::int64_t) { return ++reports < 3; });
        EXPECT_EQ(reports, 3);
        EXPECT_EQ(misplaced(patchwork), 2);
        chains.follow(outward);
        EXPECT_EQ(misplaced(patchwork), 0);
    }
}

// Whatever a search marked, the next one, in either direction, finds every way.
TEST(PlannedChains, ASearchLeavesNoMarks) {
    const Strip strip(20);
    Patchwork patchwork = strip.patchwork();
    const std::vector<int> before = cell_labels(patchwork);
    ChainsOf chains(patchwork);
    for (bool outward : {true, true, false, false, true}) {
        ASSERT_EQ(misplaced(patchwork), 2);
        chains.follow(outward);
        EXPECT_EQ(misplaced(patchwork), 0);
        for (int f = 0; f < patchwork.face_count(); ++f) {
            if (patchwork.label(f) != before[f]) {
                chains.boundaries.pass(f, patchwork.label(f), before[f]);
            }
        }
    }
}

} // namespace
} // namespace spheroseg
