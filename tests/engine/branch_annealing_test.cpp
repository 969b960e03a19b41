// SPDX-License-Identifier: GPL-3.0-or-later
#include "branch_annealing.h"

#include "boundary.h"
#include "errors.h"
#include "patchwork_meshes.h"
#include "schedules.h"

#include <gtest/gtest.h>

#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

Schedules standard() {
    return {budget_of(Effort::standard), false, 1};
}

/// Annealed with a pull towards balance, as before exact balance.
Patchwork annealed(const Levels& levels, int submesh_count, std::uint64_t seed) {
    Patchwork patchwork = rough_patchwork(levels, submesh_count, seed);
    AnnealSchedule schedule = standard().next(standard().first(seed), patchwork);
    set_balance(schedule, patchwork, 0.5, 10.0);
    anneal(patchwork, schedule, {});
    return patchwork;
}

void pass_branches(Patchwork& patchwork, const Deadline* deadline, const Progress& progress) {
    anneal_branches(patchwork, standard().branches(patchwork, 1), deadline, progress);
}

TEST(BranchAnnealing, BalancesSurfacesWithNarrowLimbsAndKeepsSubmeshesSound) {
    int stuck_count = 0;
    for (const TriangleMesh& mesh : {comb(40, 12), comb(25, 40), stacked(4000, 2)}) {
        const Levels levels(mesh);
        for (int k : {2, 5, 12}) {
            Patchwork patchwork = annealed(levels, k, 1);
            ASSERT_TRUE(is_sound(measures_of(levels, patchwork)));
            if (!is_stuck(patchwork)) {
                continue;
            }
            ++stuck_count;
            const int before = misplaced(patchwork);
            pass_branches(patchwork, nullptr, {});
            EXPECT_LT(misplaced(patchwork), before / 4) << mesh.face_count() << " k " << k;
            const Measures measures = measures_of(levels, patchwork);
            EXPECT_TRUE(is_sound(measures)) << mesh.face_count() << " k " << k;
            EXPECT_EQ(patchwork.load, measures.submesh_triangles);
            // Across each edge lies what is told.
            Patchwork told = patchwork;
            told.tell_neighbors();
            for (int f = 0; f < patchwork.face_count(); ++f) {
                for (int c = 0; c < 3; ++c) {
                    ASSERT_EQ(patchwork.label_across(f, c), told.label_across(f, c));
                }
            }
        }
    }
    EXPECT_GE(stuck_count, 4);
}

TEST(BranchAnnealing, KeepsCoarseLevelsSoundToo) {
    const Levels levels(comb(60, 20));
    Patchwork patchwork = levels.multilevel.coarsen(1000, 6);
    ASSERT_LT(patchwork.face_count(), levels.mesh.face_count());
    bisect(patchwork, 6, 3, 1);
    repair(patchwork);
    pass_branches(patchwork, nullptr, {});
    EXPECT_TRUE(is_sound(measures_of_level(patchwork)));
    std::vector<int> loads = patchwork.load;
    EXPECT_EQ(std::accumulate(loads.begin(), loads.end(), 0), levels.mesh.face_count());
    sum_loads(patchwork);
    EXPECT_EQ(patchwork.load, loads);
}

TEST(BranchAnnealing, ShortensBoundaries) {
    const Levels levels(displaced_sphere(4));
    Patchwork patchwork = ragged_patchwork(levels, 8, 1);
    const std::int64_t before = count_boundary_edges(patchwork, 1);
    pass_branches(patchwork, nullptr, {});
    EXPECT_LT(count_boundary_edges(patchwork, 1), before / 2);
    EXPECT_EQ(count_boundary_edges(patchwork, 1),
              measures_of(levels, patchwork).boundary_edge_count);
}

TEST(BranchAnnealing, StopsWhenTheTimeIsUpOrItIsCancelled) {
    const Levels levels(comb(60, 20));
    Patchwork patchwork = rough_patchwork(levels, 6, 3);
    EXPECT_THROW(pass_branches(patchwork, nullptr, [](double, const char*) { return false; }),
                 Cancelled);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    int reports = 0;
    const Deadline over(1e-9);
    pass_branches(patchwork, &over, [&](double, const char*) { return ++reports > 0; });
    EXPECT_EQ(reports, 1);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
}

TEST(BranchAnnealing, StuckIsWhatIsFarOffByShareAndByFaces) {
    const Levels levels(open_grid(20)); // 800 faces
    Patchwork patchwork = levels.multilevel.coarsen(800, 2);
    const auto stuck_with = [&](std::vector<int> loads) {
        patchwork.load = std::move(loads);
        return is_stuck(patchwork);
    };
    EXPECT_FALSE(stuck_with({400, 400}));
    // At least a hundredth of all faces ...
    EXPECT_FALSE(stuck_with({404, 396}));
    EXPECT_TRUE(stuck_with({405, 395}));
    // ... and two for each sub-mesh.
    std::vector<int> loads(80, 10);
    for (int l = 0; l < 80; l += 2) {
        loads[l] -= 2;
        loads[l + 1] += 2;
    }
    EXPECT_FALSE(stuck_with(loads));
    loads[0] -= 1;
    loads[1] += 1;
    EXPECT_TRUE(stuck_with(loads));
}

} // namespace
} // namespace spheroseg
