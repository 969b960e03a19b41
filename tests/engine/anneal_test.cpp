// SPDX-License-Identifier: GPL-3.0-or-later
#include "anneal.h"

#include "balance.h"
#include "boundary.h"
#include "free_annealing.h"
#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheroseg {
namespace {

using namespace test;

TEST(Anneal, LowersTheBoundaryKeepsSoundnessAndDoesNotDependOnThreads) {
    const Levels levels(limbed_figure(4));
    constexpr int kSubmeshes = 120;
    std::vector<int> reference;
    for (int threads : {1, 2, 3, 1}) {
        Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), kSubmeshes);
        bisect(patchwork, kSubmeshes, 0, threads);
        repair(patchwork);
        const int before = measures_of(levels, patchwork).boundary_edge_count;
        History history;
        const std::vector<double>& edges = history.boundary_edges;
        AnnealControl control;
        control.history = &history;
        anneal(patchwork, schedule_of(60, threads), control);
        const Measures annealed = measures_of(levels, patchwork);
        EXPECT_TRUE(is_sound(annealed));
        EXPECT_LT(annealed.boundary_edge_count, before);
        ASSERT_EQ(edges.size(), 8u);
        EXPECT_EQ(edges.back(), annealed.boundary_edge_count);

        ASSERT_TRUE(balance_exactly(patchwork));
        const int balanced = measures_of(levels, patchwork).boundary_edge_count;
        AnnealSchedule exchanges = schedule_of(200, threads);
        exchanges.temperature_begin = 0.25;
        exchanges.temperature_end = 0.08;
        anneal_balanced(patchwork, exchanges, control);
        const Measures exchanged = measures_of(levels, patchwork);
        EXPECT_TRUE(exchanged.is_valid());
        EXPECT_LT(exchanged.boundary_edge_count, balanced);
        EXPECT_EQ(edges.back(), exchanged.boundary_edge_count);
        for (int l = 0; l < kSubmeshes; ++l) {
            EXPECT_EQ(patchwork.load[l], exchanged.submesh_triangles[l]);
        }

        const std::vector<int> labels = levels.multilevel.labels(patchwork);
        if (reference.empty()) {
            reference = labels;
        }
        EXPECT_EQ(labels, reference) << threads << " threads";
    }
}

TEST(Anneal, RoundsKeepTheBalanceAndNeverLengthenTheBoundary) {
    const Levels levels(limbed_figure(4));
    constexpr int kSubmeshes = 120;
    std::vector<int> reference;
    for (int threads : {1, 2, 3}) {
        Patchwork patchwork = ragged_patchwork(levels, kSubmeshes, 1);
        anneal(patchwork, schedule_of(60, threads), {});
        ASSERT_TRUE(balance_exactly(patchwork));
        const std::int64_t before = count_boundary_edges(patchwork, 1);
        History history;
        AnnealControl control;
        control.history = &history;
        AnnealSchedule rounds = schedule_of(40, threads);
        rounds.temperature_begin = 0.6; // so hot that groups get worse, too
        rounds.temperature_end = 0.2;
        rounds.round_count = 12;
        anneal_balanced(patchwork, rounds, control);
        const std::vector<double>& edges = history.boundary_edges;
        ASSERT_EQ(edges.size(), 12u);
        EXPECT_LE(edges.front(), before);
        EXPECT_TRUE(std::is_sorted(edges.rbegin(), edges.rend()));
        EXPECT_LT(edges.back(), before);
        const Measures measures = measures_of(levels, patchwork);
        EXPECT_TRUE(measures.is_valid());
        EXPECT_EQ(measures.boundary_edge_count, edges.back());
        EXPECT_EQ(patchwork.load, measures.submesh_triangles);
        const std::vector<int> labels = levels.multilevel.labels(patchwork);
        if (reference.empty()) {
            reference = labels;
        }
        EXPECT_EQ(labels, reference) << threads << " threads";
    }
}

TEST(Anneal, ARoundInWhichAllGetsWorseChangesNothing) {
    const Levels levels(displaced_sphere(3));
    constexpr int kSubmeshes = 60;
    Patchwork patchwork = ragged_patchwork(levels, kSubmeshes, 1);
    anneal(patchwork, schedule_of(60, 1), {});
    ASSERT_TRUE(balance_exactly(patchwork));
    const std::vector<int> labels = cell_labels(patchwork);
    const std::vector<int> load = patchwork.load;
    AnnealSchedule rounds = schedule_of(20, 1);
    rounds.temperature_begin = 20.0;
    rounds.temperature_end = 20.0;
    Patchwork melted = patchwork;
    anneal_balanced(melted, rounds, {});
    ASSERT_NE(cell_labels(melted), labels);
    rounds.round_count = 3;
    anneal_balanced(patchwork, rounds, {});
    EXPECT_EQ(cell_labels(patchwork), labels);
    EXPECT_EQ(patchwork.load, load);
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            EXPECT_EQ(patchwork.label_across(f, c), patchwork.label(patchwork.neighbor(f, c)));
        }
    }
}

TEST(Anneal, ClosesRingsAroundALimbOnlyWhereItMay) {
    const Levels levels(long_thin_limb(4, 100));
    constexpr int kSubmeshes = 20;
    for (bool may_close_rings : {true, false}) {
        Patchwork patchwork = ragged_patchwork(levels, kSubmeshes, 1);
        ASSERT_EQ(measures_of(levels, patchwork).disk_count, kSubmeshes);
        patchwork.may_close_rings = may_close_rings;
        AnnealSchedule schedule;
        schedule.proposals_per_face = 200.0;
        anneal(patchwork, schedule, {});
        const Measures annealed = measures_of(levels, patchwork);
        EXPECT_TRUE(is_sound(annealed));
        if (may_close_rings) {
            EXPECT_LT(annealed.disk_count, kSubmeshes);
        } else {
            EXPECT_EQ(annealed.disk_count, kSubmeshes);
        }
    }
}

TEST(Anneal, HearsACancelWithinAPhase) {
    const Levels levels(icosphere(4));
    AnnealSchedule schedule = schedule_of(6e3, 1); // a second
    schedule.phase_count = 1;
    for (int threads : {1, 2}) {
        schedule.thread_count = threads;
        Patchwork patchwork = rough_patchwork(levels, 200, 1);
        int calls = 0;
        AnnealControl control;
        control.progress = [&calls](double, const char*) { return ++calls < 3; };
        EXPECT_THROW(anneal(patchwork, schedule, control), Cancelled);
        EXPECT_EQ(calls, 3);
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    }
}

TEST(FreeAnnealing, FindsTheWayThroughAHole) {
    // A strip of 24 x 8 squares with a hole of 4 x 4 in its middle, which leaves bridges of two: 4
    // edges part the halves there. The start is a straight cut of 8 edges beside the hole; moves
    // that keep both sides connected can only push it along one side of the hole.
    TriangleMesh mesh = open_grid(24);
    std::vector<Triangle> kept;
    std::vector<int> labels;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int x = f / 2 % 24;
        const int y = f / 2 / 24;
        if (y < 8 && (x < 10 || x >= 14 || y < 2 || y >= 6)) {
            kept.push_back(mesh.faces[f]);
            labels.push_back(x >= 8);
        }
    }
    mesh.faces = kept;
    const Levels levels(mesh);
    Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), 2);
    levels.multilevel.set_labels(patchwork, labels);
    Patchwork bound = patchwork;
    AnnealSchedule schedule = schedule_of(2000, 1);
    schedule.balance_weight_begin = 0.5 / mean_load(patchwork);
    schedule.balance_weight_end = 1.5 / mean_load(patchwork);
    anneal_freely(patchwork, schedule, Deadline());
    anneal(bound, schedule, {});
    EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
    EXPECT_EQ(repair(patchwork), 0);
    EXPECT_LE(measures_of(levels, patchwork).boundary_edge_count, 5);
    EXPECT_GE(measures_of(levels, bound).boundary_edge_count, 7);
}

TEST(FreeAnnealing, LeavesNoSubmeshEmptyAndRepeats) {
    const Levels levels(torus(20, 10));
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 60);
    bisect(patchwork, 60, 1, 1);
    Patchwork again = patchwork;
    AnnealSchedule schedule = schedule_of(300, 1);
    schedule.temperature_begin = 3.0;
    anneal_freely(patchwork, schedule, Deadline());
    EXPECT_GE(*std::min_element(patchwork.load.begin(), patchwork.load.end()), 1);
    EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
    anneal_freely(again, schedule, Deadline());
    EXPECT_EQ(levels.multilevel.labels(again), levels.multilevel.labels(patchwork));
}

} // namespace
} // namespace spheroseg
