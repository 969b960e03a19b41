// SPDX-License-Identifier: GPL-3.0-or-later
#include "bisection.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

TEST(Bisection, CutInTwoAgainAndAgainGivesEachPartItsShare) {
    const Levels levels(limbed_figure(4));
    for (int k : {2, 3, 7, 12, 33}) {
        Patchwork patchwork = levels.multilevel.coarsen(60 * k, 1);
        std::vector<int> parts{k};
        for (int cuts = 0; static_cast<int>(parts.size()) < k; ++cuts) {
            ASSERT_LT(cuts, 6) << "log2 of 33, rounded up";
            const Patchwork before = patchwork;
            cut_in_two(patchwork, parts, 1);
            ASSERT_EQ(patchwork.submesh_count(), static_cast<int>(parts.size()));
            EXPECT_EQ(std::accumulate(parts.begin(), parts.end(), 0), k);
            const std::vector<int> load = patchwork.load;
            sum_loads(patchwork);
            EXPECT_EQ(load, patchwork.load);
            for (int f = 0; f < patchwork.face_count(); ++f) {
                const bool stays = patchwork.label(f) == before.label(f);
                ASSERT_TRUE(stays || patchwork.label(f) >= before.submesh_count());
            }
            const double share = mean_load(patchwork) * patchwork.submesh_count() / k;
            for (std::size_t l = 0; l < parts.size(); ++l) {
                // A cell of a coarse level weighs several faces.
                EXPECT_NEAR(load[l], parts[l] * share, 0.1 * parts[l] * share) << k;
            }
        }
    }
}

TEST(Bisection, CutInTwoOfFewerCellsThanPartsLeavesEmptySubmeshes) {
    const Levels levels(tetrahedron());
    Patchwork patchwork = levels.multilevel.coarsen(4, 1);
    std::vector<int> parts{3};
    cut_in_two(patchwork, parts, 0);
    patchwork.set_label(0, 0);
    patchwork.set_label(1, 0);
    patchwork.set_label(2, 0);
    patchwork.set_label(3, 1);
    sum_loads(patchwork);
    parts = {1, 3};
    cut_in_two(patchwork, parts, 0);
    EXPECT_EQ(parts, (std::vector<int>{1, 1, 2}));
    EXPECT_EQ(patchwork.load, (std::vector<int>{3, 1, 0}));
    cut_in_two(patchwork, parts, 0);
    EXPECT_EQ(patchwork.load, (std::vector<int>{3, 1, 0, 0}));
}

TEST(Bisection, EverySubmeshGetsItsShareForAnyNumberOfThreads) {
    for (const TriangleMesh& mesh : {icosphere(5), open_grid(20), moebius_strip(60, 5)}) {
        const Levels levels(mesh);
        const int face_count = mesh.face_count();
        for (int k : {1, 2, 3, 7, 20, 333, face_count - 1, face_count}) {
            std::vector<int> labels;
            for (int threads : {1, 2, 3}) {
                Patchwork patchwork = levels.multilevel.coarsen(face_count, 1);
                bisect(patchwork, k, 1, threads);
                ASSERT_EQ(patchwork.submesh_count(), k);
                for (int load : patchwork.load) {
                    ASSERT_NEAR(load, static_cast<double>(face_count) / k, 1.0);
                }
                const std::vector<int> load = patchwork.load;
                sum_loads(patchwork);
                EXPECT_EQ(load, patchwork.load);
                EXPECT_EQ(*std::min_element(load.begin(), load.end()), face_count / k);
                EXPECT_TRUE(labels.empty() || labels == cell_labels(patchwork));
                labels = cell_labels(patchwork);
            }
        }
    }
}

TEST(Bisection, ReportsProgressAndChangesNothingWhereItIsCancelled) {
    const Levels levels(icosphere(5));
    for (int threads : {1, 2}) {
        Patchwork patchwork = levels.multilevel.coarsen(20480, 1);
        std::vector<double> values;
        bisect(patchwork, 20, 0, threads, [&](double value, const char*) {
            values.push_back(value);
            return true;
        });
        EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
        EXPECT_GE(values.front(), 0.0);
        EXPECT_LE(values.back(), 1.0);
        ASSERT_GE(values.size(), 2U);
        for (std::size_t last = 1; last <= values.size(); ++last) {
            Patchwork other = levels.multilevel.coarsen(20480, 1);
            std::size_t calls = 0;
            const Progress cancel = [&](double, const char*) { return ++calls < last; };
            EXPECT_THROW(bisect(other, 20, 0, threads, cancel), Cancelled);
            EXPECT_EQ(cell_labels(other), std::vector<int>(20480, 0));
        }
    }
}

} // namespace
} // namespace spheroseg
