// SPDX-License-Identifier: GPL-3.0-or-later
#include "schedules.h"

#include <gtest/gtest.h>

#include <cmath>

namespace spheroseg {
namespace {

TEST(Schedules, LargeSubmeshesGetMoreProposalsPerBoundaryFace) {
    constexpr int kSubmeshes = 3;
    for (Effort effort : {Effort::draft, Effort::standard, Effort::high}) {
        const Budget budget = budget_of(effort);
        const Schedules schedules{budget, false, 1, 0.5};
        const auto growth = [&](int cells_per_submesh) {
            Patchwork patchwork;
            patchwork.cells.resize(static_cast<std::size_t>(kSubmeshes) * cells_per_submesh);
            patchwork.load.resize(kSubmeshes);
            return schedules.next(schedules.first(0), patchwork).proposals_per_face /
                (0.5 * budget.level_proposals);
        };
        EXPECT_DOUBLE_EQ(growth(10), 1.0);
        EXPECT_DOUBLE_EQ(growth(budget.large_submesh), 1.0);
        EXPECT_DOUBLE_EQ(growth(4 * budget.large_submesh), 2.0);
        EXPECT_DOUBLE_EQ(growth(9 * budget.large_submesh), 3.0);
        EXPECT_DOUBLE_EQ(growth(40 * budget.large_submesh), 4.0);
    }
}

TEST(Schedules, FurtherProposalsAreThoseOfTheLevelsInBetween) {
    Budget budget = {};
    budget.level_proposals = 10.0;
    budget.large_submesh = 100;
    const Schedules schedules{budget, false, 1, 0.5};
    // Levels of 1000, 400 and 160 cells, 500, 200 and 80 per sub-mesh; edges of
    // hexagons: sqrt(1.5 * cells * 2).
    const double expected =
        5.0 * (std::sqrt(5.0) * std::sqrt(3000.0) + std::sqrt(2.0 * 1200.0) + std::sqrt(480.0));
    EXPECT_NEAR(schedules.further_proposals(100, 1000, 2), expected, 1e-9);
    EXPECT_EQ(schedules.further_proposals(1000, 1000, 2), 0.0);
}

} // namespace
} // namespace spheroseg
