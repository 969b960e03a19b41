// SPDX-License-Identifier: GPL-3.0-or-later
#include "narrow_cut.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

namespace spheroseg {
namespace {

using namespace test;

constexpr std::int64_t kMuchWork = 1 << 30;

/// Ways to cut a subtree of a dual graph that is a tree: the size of the part at its root, and how
/// many of the complete parts below are large (of `least` + 1 faces; the others have `least`).
using TreeCuts = std::set<std::pair<int, int>>;

TreeCuts cuts_below(const DualGraph& graph, int face, int parent, int least) {
    TreeCuts cuts = {{1, 0}};
    for (int neighbor : graph.neighbors[face]) {
        if (neighbor < 0 || neighbor == parent) {
            continue;
        }
        TreeCuts more;
        for (const auto& [child_size, child_large] : cuts_below(graph, neighbor, face, least)) {
            for (const auto& [size, large] : cuts) {
                if (size + child_size <= least + 1) {
                    more.emplace(size + child_size, large + child_large);
                }
                if (child_size >= least) {
                    more.emplace(size, large + child_large + (child_size > least));
                }
            }
        }
        cuts = std::move(more);
    }
    return cuts;
}

bool has_even_cut(const DualGraph& graph, int face_count, int submesh_count) {
    const int least = face_count / submesh_count;
    const int large = face_count % submesh_count;
    const TreeCuts cuts = cuts_below(graph, 0, -1, least);
    return cuts.count({least, large}) > 0 || (large > 0 && cuts.count({least + 1, large - 1}) > 0);
}

TEST(NarrowCut, FindsACutOfATreeWhereThereIsOne) {
    int cut_count = 0;
    int other_count = 0;
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Levels levels(random_tree(24 + static_cast<int>(seed % 7), seed));
        const int face_count = levels.mesh.face_count();
        for (int k : {4, 5, 6, 8, 12}) {
            Patchwork patchwork = rough_patchwork(levels, k, seed);
            std::int64_t work_left = kMuchWork;
            const bool is_even = misplaced(patchwork) == 0;
            const bool balanced = cut_narrow_regions(patchwork, work_left);
            EXPECT_EQ(balanced, is_even || has_even_cut(levels.graph, face_count, k))
                << "seed " << seed << ", k " << k;
            EXPECT_EQ(balanced, measures_of(levels, patchwork).is_valid());
            EXPECT_TRUE(balanced || is_sound(measures_of(levels, patchwork)));
            cut_count += balanced && !is_even;
            other_count += !balanced;
        }
    }
    EXPECT_GE(cut_count, 20);
    EXPECT_GE(other_count, 20);
}

TEST(NarrowCut, DoesNothingWithLargeSubmeshesOrWithoutWork) {
    const Levels levels(evenly_stacked(1000));
    for (const auto& [submesh_count, work] : {std::pair{3, kMuchWork}, {200, std::int64_t{0}}}) {
        Patchwork patchwork = rough_patchwork(levels, submesh_count, 1);
        ASSERT_GT(misplaced(patchwork), 0);
        const std::vector<int> before = cell_labels(patchwork);
        std::int64_t work_left = work;
        EXPECT_FALSE(cut_narrow_regions(patchwork, work_left));
        EXPECT_EQ(cell_labels(patchwork), before);
        EXPECT_EQ(work_left, work);
    }
}

TEST(NarrowCut, TakesLittleMoreWorkThanThereIsAndHearsACancel) {
    const Levels levels(evenly_stacked(4000));
    const Patchwork rough = rough_patchwork(levels, 400, 1);
    Patchwork patchwork = rough;
    std::int64_t work_left = 100000;
    cut_narrow_regions(patchwork, work_left);
    EXPECT_GT(work_left, -500000); // one list, and the blocks of all faces
    patchwork = rough;
    work_left = kMuchWork;
    int calls = 0;
    const auto stop = [&calls](double, const char*) { return ++calls < 3; };
    EXPECT_THROW(cut_narrow_regions(patchwork, work_left, nullptr, stop), Cancelled);
    EXPECT_EQ(calls, 3);
}

TEST(NarrowCut, BalancesEvenlyStackedTriangulations) {
    const Levels levels(evenly_stacked(1000));
    const int face_count = levels.mesh.face_count();
    int balanced_count = 0;
    for (std::uint64_t seed = 0; seed < 2; ++seed) {
        for (int faces_each : {2, 3, 5, 7, 10, 30}) {
            Patchwork patchwork = rough_patchwork(levels, face_count / faces_each, seed);
            std::int64_t work_left = kMuchWork;
            const bool balanced = cut_narrow_regions(patchwork, work_left);
            const Measures measures = measures_of(levels, patchwork);
            EXPECT_TRUE(is_sound(measures)) << faces_each << ", seed " << seed;
            EXPECT_EQ(measures.is_valid(), balanced) << faces_each << ", seed " << seed;
            EXPECT_EQ(patchwork.load, measures.submesh_triangles);
            balanced_count += balanced;
        }
    }
    EXPECT_GE(balanced_count, 11); // of 12, in one go from rough starts
}

} // namespace
} // namespace spheroseg
