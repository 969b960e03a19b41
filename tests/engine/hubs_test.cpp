// SPDX-License-Identifier: GPL-3.0-or-later
#include "hubs.h"

#include "balance.h"
#include "branches.h"
#include "exact_cut.h"
#include "patchwork_meshes.h"
#include "relaxation.h"
#include "segment.h"
#include "warm_start.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

constexpr int kSubmeshes = 9;

/// A bipyramid after a flip of an edge that makes the apexes neighbours.
TriangleMesh joined_bipyramid(int valence) {
    TriangleMesh mesh = bipyramid(valence);
    mesh.faces[0] = {0, valence + 1, valence};
    mesh.faces[1] = {valence + 1, 1, valence};
    return mesh;
}

/// Hubs inside, on a border, some of them neighbours, and where the faces have no common
/// orientation.
std::vector<TriangleMesh> meshes_with_hubs() {
    return {bipyramid(140),
            capped_cylinder(135),
            capped_cylinder(135, false),
            open_fan(150),
            joined_bipyramid(140),
            with_turned_faces(capped_cylinder(132), 3)};
}

/// What is counted at hubs, and the tests that use it, are what walks around the vertices find.
void expect_counted(const Patchwork& patchwork) {
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            std::vector<HubShare> shares(patchwork.submesh_count());
            int faces_around = 0;
            for_each_around(patchwork, f, c, [&](int face, int corner) {
                ++faces_around;
                if (const int label = patchwork.label(face); label >= 0) {
                    ++shares[label].faces;
                    shares[label].ends += fan_ends(patchwork, face, corner);
                }
            });
            for (int l = 0; l < patchwork.submesh_count(); ++l) {
                ASSERT_EQ(is_counted(patchwork, f, c, l), faces_around > Hubs::kMostWalked);
                if (faces_around > Hubs::kMostWalked) {
                    ASSERT_EQ(share_at(patchwork, f, c, l).faces, shares[l].faces);
                    ASSERT_EQ(share_at(patchwork, f, c, l).ends, shares[l].ends);
                }
                ASSERT_EQ(no_label_around(patchwork, f, c, l),
                          no_label_around<Patchwork>(patchwork, f, c, l));
                ASSERT_EQ(all_label_around(patchwork, f, c, l),
                          all_label_around<Patchwork>(patchwork, f, c, l));
            }
            ASSERT_EQ(no_label_around(patchwork, f, c, -1),
                      no_label_around<Patchwork>(patchwork, f, c, -1));
        }
    }
}

TEST(Hubs, AreTheVerticesWithMoreFacesThanAWalkIsWorth) {
    EXPECT_EQ(Levels(bipyramid(Hubs::kMostWalked)).multilevel.coarsen(1000, 1).hubs, nullptr);
    EXPECT_EQ(Levels(icosphere(3)).multilevel.coarsen(2000, 1).hubs, nullptr);
    const Patchwork closed = Levels(bipyramid(Hubs::kMostWalked + 1)).multilevel.coarsen(1000, 1);
    ASSERT_NE(closed.hubs, nullptr);
    ASSERT_EQ(closed.hubs->hubs.size(), 2U);
    for (const Hubs::Hub& hub : closed.hubs->hubs) {
        EXPECT_EQ(hub.face_count, Hubs::kMostWalked + 1);
        EXPECT_TRUE(hub.is_closed);
    }
    const Patchwork open = Levels(open_fan(140)).multilevel.coarsen(1000, 1);
    ASSERT_NE(open.hubs, nullptr);
    ASSERT_EQ(open.hubs->hubs.size(), 1U);
    EXPECT_EQ(open.hubs->hubs.front().face_count, 140);
    EXPECT_FALSE(open.hubs->hubs.front().is_closed);
}

TEST(Hubs, FansThatTouchByAVertexOnlyAreCountedApart) {
    // The fans hang together by a row of faces, from the last vertex of one to the first of the
    // other.
    TriangleMesh mesh = open_fan(100);
    const TriangleMesh other = open_fan(140);
    const int shift = mesh.vertex_count() - 1;
    for (const Triangle& t : other.faces) {
        mesh.faces.push_back({0, t[1] + shift, t[2] + shift});
    }
    for (std::size_t v = 1; v < other.positions.size(); ++v) {
        mesh.positions.push_back(other.positions[v] * -1.0);
    }
    mesh.positions.push_back({2, 2, 0});
    const int last = mesh.vertex_count() - 1;
    mesh.faces.push_back({101, 100, last});
    mesh.faces.push_back({101, last, 102});
    mesh.faces.push_back({103, 102, last});
    const Levels levels(mesh);
    const Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), kSubmeshes);
    ASSERT_NE(patchwork.hubs, nullptr);
    ASSERT_EQ(patchwork.hubs->hubs.size(), 1U);
    EXPECT_EQ(patchwork.hubs->hubs.front().face_count, 140);
    expect_counted(patchwork);
}

TEST(Hubs, AreCountedRightWhateverChangesTheLabels) {
    for (const TriangleMesh& mesh : meshes_with_hubs()) {
        const Levels levels(mesh);
        Random random(3);
        for (int least : {40, 100, mesh.face_count()}) {
            Patchwork patchwork = levels.multilevel.coarsen(least, kSubmeshes);
            expect_counted(patchwork);
            for (int f = 0; f < patchwork.face_count(); ++f) {
                // Some in no sub-mesh.
                patchwork.set_label(f, static_cast<int>(random.below(kSubmeshes + 1)) - 1);
            }
            expect_counted(patchwork);
            for (bool is_finest = false; !is_finest;) {
                repair(patchwork);
                expect_counted(patchwork);
                anneal(patchwork, schedule_of(20, 2), {});
                expect_counted(patchwork);
                const int face_count = patchwork.face_count();
                levels.multilevel.uncoarsen(patchwork);
                expect_counted(patchwork);
                is_finest = patchwork.face_count() == face_count;
            }
            ASSERT_NE(patchwork.hubs, nullptr);
            bisect(patchwork, kSubmeshes, 1, 1);
            expect_counted(patchwork);
            relax(patchwork, 3, 1, {});
            expect_counted(patchwork);
            cut_exactly(patchwork, 1, patchwork.face_count(), 1000);
            expect_counted(patchwork);
            std::vector<int> labels(mesh.face_count());
            for (int& label : labels) {
                label = static_cast<int>(random.below(kSubmeshes + 1)) - 1;
            }
            levels.multilevel.set_labels(patchwork, labels);
            expect_counted(patchwork);
        }
    }
}

TEST(Hubs, GrowWithTheNumberOfSubmeshes) {
    const Levels levels(bipyramid(200));
    Patchwork patchwork = levels.multilevel.coarsen(400, 1);
    bisect(patchwork, 20, 1, 1);
    ASSERT_EQ(patchwork.submesh_count(), 20);
    expect_counted(patchwork);
}

TEST(Hubs, RandomMovesAreJudgedAsByAWalk) {
    for (const TriangleMesh& mesh : meshes_with_hubs()) {
        const Levels levels(mesh);
        Patchwork patchwork = ragged_patchwork(levels, mesh.face_count() / 4, 1);
        ASSERT_NE(patchwork.hubs, nullptr);
        // Without hubs.
        Patchwork walked = patchwork;
        walked.hubs = nullptr;
        Random random(2);
        int allowed_count = 0;
        for (int i = 0; i < 20000; ++i) {
            const auto face = static_cast<int>(random.below(mesh.face_count()));
            const auto corner = static_cast<int>(random.below(3));
            Fan fan;
            const bool as_fan = random.below(2) == 0;
            if (as_fan ? !describe_shorter_fan(patchwork, face, corner, i % 4 < 2, fan)
                       : !describe_single(patchwork, face, corner, fan.move)) {
                continue;
            }
            const bool allowed = as_fan ? fan_is_allowed(patchwork, fan)
                                        : single_is_allowed(patchwork, face, corner, fan.move);
            ASSERT_EQ(allowed,
                      as_fan ? fan_is_allowed(walked, fan)
                             : single_is_allowed(walked, face, corner, fan.move));
            if (allowed) {
                apply(patchwork, fan.move);
                apply(walked, fan.move);
                ++allowed_count;
            }
        }
        EXPECT_GT(allowed_count, 100);
        expect_counted(patchwork);
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    }
}

TEST(Hubs, WhatBranchesLookAtDoesNotGrowWithTheFacesOfAHub) {
    std::int64_t first_work = 0;
    for (int size : {200, 800, 3200}) {
        const Levels levels(open_fan(size));
        Patchwork patchwork = levels.multilevel.coarsen(size, 2);
        std::vector<int> labels(size, 1);
        std::fill(labels.begin(), labels.begin() + 20, 0);
        levels.multilevel.set_labels(patchwork, labels);
        int face = 0;
        while (patchwork.label(face) != 0 || !is_at_rim(patchwork, face) ||
               (patchwork.label_across(face, 0) != 1 && patchwork.label_across(face, 1) != 1 &&
                patchwork.label_across(face, 2) != 1)) {
            ++face;
        }
        Branches branches(patchwork);
        EXPECT_EQ(branches.find(face, 1, 10).size(), 1U);
        first_work = size == 200 ? branches.work() : first_work;
        EXPECT_EQ(branches.work(), first_work);
    }
}

TEST(Hubs, BranchesAreThoseFoundByWalks) {
    int found = 0;
    for (const TriangleMesh& mesh : meshes_with_hubs()) {
        const Levels levels(mesh);
        Patchwork patchwork = ragged_patchwork(levels, 6, 4);
        Patchwork walked = patchwork;
        walked.hubs = nullptr;
        Branches branches(patchwork);
        Branches found_by_walks(walked);
        for (int f = 0; f < patchwork.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                const int to = patchwork.label_across(f, c);
                if (to >= 0 && to != patchwork.label(f)) {
                    const std::vector<int>& branch = branches.find(f, to, 20);
                    ASSERT_EQ(branch, found_by_walks.find(f, to, 20));
                    found += !branch.empty();
                }
            }
        }
        expect_counted(patchwork);
    }
    EXPECT_GT(found, 100);
}

TEST(Hubs, LabelsDoNotDependOnThreads) {
    for (const TriangleMesh& mesh : {bipyramid(1500), capped_cylinder(800, false)}) {
        for (int k : {300, mesh.face_count() / 3}) {
            std::vector<int> labels;
            for (int threads : {1, 2, 3}) {
                PreparedMesh prepared(TriangleMesh(mesh), threads);
                SegmentOptions options;
                options.submesh_count = k;
                options.thread_count = threads;
                options.effort = Effort::draft;
                const Segmentation result = segment(prepared, options);
                EXPECT_TRUE(result.is_valid());
                labels = threads == 1 ? result.labels : labels;
                EXPECT_EQ(result.labels, labels);
            }
        }
    }
}

} // namespace
} // namespace spheroseg
