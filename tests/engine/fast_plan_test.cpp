// SPDX-License-Identifier: GPL-3.0-or-later
#include "fast_plan.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

constexpr bool kByWeight = true;
constexpr bool kHasSphere = true;

TEST(FastPlan, HighMakesTwoStartsOnlyWhereTheyAreOfTwoKinds) {
    const auto plan = [](int submesh_count, bool by_weight, bool has_sphere, Effort effort) {
        return FastPlan(100000, submesh_count, by_weight, has_sphere, effort, 1);
    };
    for (Effort effort : {Effort::draft, Effort::standard}) {
        EXPECT_EQ(plan(200, !kByWeight, kHasSphere, effort).start_count(), 1);
        EXPECT_EQ(plan(200, !kByWeight, kHasSphere, effort).schedules().share, 1.0);
        EXPECT_FALSE(plan(200, !kByWeight, kHasSphere, effort).starts_on_sphere());
    }
    const FastPlan both = plan(200, !kByWeight, kHasSphere, Effort::high);
    EXPECT_EQ(both.start_count(), 2);
    EXPECT_EQ(both.schedules().share, 1.0);
    EXPECT_TRUE(both.starts_on_sphere());
    // Without a map, with few sub-meshes, and with so many that there is only one level.
    for (const FastPlan& one : {plan(200, !kByWeight, !kHasSphere, Effort::high),
                                plan(49, !kByWeight, kHasSphere, Effort::high),
                                plan(1000, !kByWeight, kHasSphere, Effort::high)}) {
        EXPECT_EQ(one.start_count(), 1);
        EXPECT_EQ(one.schedules().share, 2.0);
        EXPECT_FALSE(one.starts_on_sphere());
    }
    for (int submesh_count : {49, 200, 1000}) {
        const FastPlan weighted = plan(submesh_count, kByWeight, kHasSphere, Effort::high);
        EXPECT_EQ(weighted.start_count(), 2);
        EXPECT_EQ(weighted.schedules().share, 1.0);
        EXPECT_FALSE(weighted.starts_on_sphere());
    }
}

TEST(FastPlan, TinyMeshesGetFewTrials) {
    const auto trials = [](int face_count, int submesh_count) {
        return FastPlan(face_count, submesh_count, !kByWeight, !kHasSphere, Effort::standard, 1)
            .trials();
    };
    EXPECT_EQ(trials(4, 2), 1);
    EXPECT_EQ(trials(39, 4), 1);
    EXPECT_EQ(trials(80, 4), 4);
    EXPECT_EQ(trials(240, 4), 12);
    EXPECT_EQ(trials(1200, 20), 5);
    EXPECT_EQ(trials(100000, 4), 12);
    EXPECT_EQ(trials(100000, 20), 5);
    EXPECT_EQ(trials(100000, 200), 1);
}

TEST(FastPlan, StartsOnFewerCellsWhereASubdivisionIsUndone) {
    const auto first_cells = [](const test::Levels& levels, int submesh_count, bool by_weight) {
        FastPlan plan(
            levels.mesh.face_count(), submesh_count, by_weight, kHasSphere, Effort::standard, 1);
        EXPECT_TRUE(plan.coarsens());
        plan.set_levels(levels.multilevel);
        return levels.multilevel.cell_count(plan.coarse_face_count());
    };
    const test::Levels subdivided(test::icosphere(5));
    EXPECT_EQ(first_cells(subdivided, 5, !kByWeight), 320);
    EXPECT_EQ(first_cells(subdivided, 50, !kByWeight), 1280);
    EXPECT_EQ(first_cells(subdivided, 54, !kByWeight), 5120);
    EXPECT_EQ(first_cells(subdivided, 130, !kByWeight), 5120);
    EXPECT_EQ(first_cells(subdivided, 54, kByWeight), 5120);
    EXPECT_EQ(first_cells(subdivided, 130, kByWeight), 20480);
    const test::Levels other(test::flipped_sphere(5, 1));
    EXPECT_GE(first_cells(other, 50, !kByWeight), 60 * 50);
    EXPECT_GE(first_cells(other, 130, !kByWeight), 60 * 130);
    // Not on one that has hardly more faces than the handles need.
    TriangleMesh handles = test::lattice(5);
    handles.faces = build_hierarchy(handles, build_dual_graph(handles)).base_triangles;
    ASSERT_GT(handles.face_count(), 240);
    const test::Levels around(test::subdivide(test::subdivide(handles)));
    EXPECT_EQ(around.multilevel.quartered_cell_count(1), handles.face_count());
    EXPECT_EQ(first_cells(around, 2, !kByWeight), 4 * handles.face_count());
}

} // namespace
} // namespace spheroseg
