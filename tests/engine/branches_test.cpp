// SPDX-License-Identifier: GPL-3.0-or-later
#include "branches.h"

#include "patchwork_meshes.h"
#include "segment.h"

#include <gtest/gtest.h>

#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

Patchwork labelled(const Levels& levels, const std::vector<int>& labels, int submesh_count) {
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), submesh_count);
    levels.multilevel.set_labels(patchwork, labels);
    return patchwork;
}

int cell_of(const Levels& levels, const Patchwork& patchwork, int face) {
    Patchwork named = patchwork;
    named.load.resize(levels.mesh.faces.size());
    std::vector<int> names(levels.mesh.faces.size());
    std::iota(names.begin(), names.end(), 0);
    levels.multilevel.set_labels(named, names);
    const auto at = std::find_if(named.cells.begin(), named.cells.end(), [&](const Cell& cell) {
        return cell.label == face;
    });
    return static_cast<int>(at - named.cells.begin());
}

/// A flat row of eight faces or more, and one hanging on the third.
TriangleMesh row_with_a_tail(int face_count = 8) {
    TriangleMesh mesh;
    for (int v = 0; v < face_count + 2; ++v) {
        mesh.positions.push_back({1.0 * v, 1.0 * (v % 2), 0.0});
    }
    for (int f = 0; f < face_count; ++f) {
        mesh.faces.push_back(f % 2 == 0 ? Triangle{f, f + 1, f + 2} : Triangle{f + 1, f, f + 2});
    }
    mesh.positions.push_back({3.0, -1.0, 0.0});
    mesh.faces.push_back({2, 4, face_count + 2});
    return mesh;
}

TEST(Branches, WhatHangsOnAFaceGoesWithIt) {
    const Levels levels(row_with_a_tail());
    // Faces 0 and 1 are sub-mesh 0. Face 2 is the way from 8, the tail, to the others.
    const Patchwork patchwork = labelled(levels, {0, 0, 1, 1, 1, 1, 1, 1, 1}, 2);
    Patchwork work = patchwork;
    const auto cell = [&](int face) { return cell_of(levels, patchwork, face); };
    Branches branches(work);
    std::vector<int> branch = branches.find(cell(2), 0, 5);
    std::vector<int> expected = {cell(2), cell(8)};
    std::sort(branch.begin(), branch.end());
    std::sort(expected.begin(), expected.end());
    EXPECT_EQ(branch, expected);
    EXPECT_TRUE(branches.find(cell(2), 0, 1).empty());
    EXPECT_EQ(cell_labels(work), cell_labels(patchwork));
}

TEST(Branches, DoNotWalkThroughALargeSubmesh) {
    constexpr int kLength = 5000;
    const Levels levels(row_with_a_tail(kLength));
    std::vector<int> labels(kLength + 1, 1);
    labels[0] = labels[1] = 0;
    Patchwork patchwork = labelled(levels, labels, 2);
    Branches branches(patchwork);
    EXPECT_EQ(branches.find(cell_of(levels, patchwork, 2), 0, 8).size(), 2);
    EXPECT_LT(branches.work(), 200);
}

TEST(Branches, TheLastFaceOfASubmeshStays) {
    const Levels levels(row_with_a_tail());
    Patchwork patchwork = labelled(levels, {0, 1, 1, 1, 1, 1, 1, 1, 1}, 2);
    EXPECT_TRUE(Branches(patchwork).find(cell_of(levels, patchwork, 0), 1, 9).empty());
}

TEST(Branches, KeepBothSubmeshesSoundOnSurfacesFullOfHoles) {
    int found_count = 0;
    int larger_count = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
        const Levels levels(seed % 2 == 0 ? sieve(torus(20, 12), 0.2, seed)
                                          : sieve(open_grid(14), 0.1, seed));
        Patchwork patchwork = ragged_patchwork(levels, 6, seed);
        ASSERT_TRUE(is_sound(measures_of(levels, patchwork)));
        Branches branches(patchwork);
        for (int f = 0; f < patchwork.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                const int to = patchwork.label_across(f, c);
                if (to < 0 || to == patchwork.label(f)) {
                    continue;
                }
                Move move;
                const bool alone = is_allowed_pass(patchwork, {f, c}, move);
                const std::vector<int> branch = branches.find(f, to, 30);
                EXPECT_TRUE(!alone || branch == std::vector<int>{f});
                if (branch.empty()) {
                    continue;
                }
                ++found_count;
                larger_count += branch.size() > 1;
                Patchwork moved = patchwork;
                for (int g : branch) {
                    EXPECT_EQ(patchwork.label(g), patchwork.label(f));
                    moved.set_label(g, to);
                }
                EXPECT_TRUE(is_sound(measures_of(levels, moved)));
            }
        }
    }
    EXPECT_GT(found_count, 500);
    EXPECT_GT(larger_count, 100);
}

// At one of these k or more each was left off balance when only faces and fans passed.
TEST(Branches, AndRecutsBalanceSurfacesFullOfHoles) {
    const std::vector<TriangleMesh> meshes = {sieve(long_thin_limb(8, 60), 0.15, 11),
                                              sieve(long_thin_limb(8, 60), 0.22, 3),
                                              sieve(long_thin_limb(8, 60), 0.22, 11),
                                              sieve(torus(31, 14), 0.22, 1)};
    for (const TriangleMesh& mesh : meshes) {
        PreparedMesh prepared(mesh);
        for (int k : {2, 5, 8, 13}) {
            SegmentOptions options;
            options.submesh_count = k;
            options.effort = Effort::draft;
            EXPECT_TRUE(segment(prepared, options).is_valid()) << mesh.face_count() << " k " << k;
        }
    }
}

} // namespace
} // namespace spheroseg
