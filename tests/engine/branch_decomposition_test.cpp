// SPDX-License-Identifier: GPL-3.0-or-later
#include "branch_decomposition.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

namespace spheroseg {
namespace {

using namespace test;

using Edges = std::multiset<std::pair<int, int>>;

Edges outer_edges(const FaceBlock& block) {
    Edges edges;
    for (const auto& [inside, outside] : block.outer) {
        edges.emplace(inside, outside);
    }
    return edges;
}

/// Of faces of a region, by their numbers, to others of it.
Edges edges_out_of(const Patchwork& patchwork,
                   const std::vector<int>& region,
                   const std::set<int>& inside) {
    Edges edges;
    for (int number : inside) {
        for (int neighbor : patchwork.neighbors(region[number])) {
            const auto other = std::find(region.begin(), region.end(), neighbor);
            const auto other_number = static_cast<int>(other - region.begin());
            if (other != region.end() && inside.count(other_number) == 0) {
                edges.emplace(number, other_number);
            }
        }
    }
    return edges;
}

void expect_decomposition(const Patchwork& patchwork,
                          const std::vector<int>& region,
                          const std::vector<FaceBlock>& blocks,
                          std::size_t most_edges) {
    ASSERT_EQ(blocks.size(), 2 * region.size() - 1);
    std::vector<std::set<int>> faces_of(blocks.size());
    std::vector<int> uses(blocks.size(), 0);
    for (int b = 0; b < static_cast<int>(blocks.size()); ++b) {
        const FaceBlock& block = blocks[b];
        ASSERT_EQ(block.is_face(), b < static_cast<int>(region.size()));
        if (block.is_face()) {
            faces_of[b] = {b};
        } else {
            for (const int side : {0, 1}) {
                ASSERT_LT(block.of[side], b);
                ++uses[block.of[side]];
                faces_of[b].insert(faces_of[block.of[side]].begin(),
                                   faces_of[block.of[side]].end());
            }
            ASSERT_EQ(block.origin.size(), block.outer.size());
            for (std::size_t e = 0; e < block.outer.size(); ++e) {
                const FaceBlock& part = blocks[block.of[block.origin[e].side]];
                EXPECT_EQ(part.outer[block.origin[e].edge].inside, block.outer[e].inside);
                EXPECT_EQ(part.outer[block.origin[e].edge].outside, block.outer[e].outside);
            }
            EXPECT_FALSE(block.inner.empty()); // or the faces would not be connected
            for (const auto& [first, second] : block.inner) {
                EXPECT_EQ(blocks[block.of[0]].outer[first].inside,
                          blocks[block.of[1]].outer[second].outside);
                EXPECT_EQ(blocks[block.of[0]].outer[first].outside,
                          blocks[block.of[1]].outer[second].inside);
            }
            EXPECT_EQ(blocks[block.of[0]].outer.size() + blocks[block.of[1]].outer.size(),
                      block.outer.size() + 2 * block.inner.size());
        }
        EXPECT_EQ(block.face_count, static_cast<int>(faces_of[b].size()));
        EXPECT_EQ(outer_edges(block), edges_out_of(patchwork, region, faces_of[b]));
        EXPECT_LE(block.outer.size(), most_edges);
    }
    EXPECT_EQ(faces_of.back().size(), region.size());
    EXPECT_EQ(std::count(uses.begin(), uses.end(), 1), static_cast<int>(blocks.size()) - 1);
}

std::vector<int> all_faces(const Patchwork& patchwork) {
    std::vector<int> faces(patchwork.face_count());
    std::iota(faces.begin(), faces.end(), 0);
    return faces;
}

TEST(BranchDecomposition, JoinsAllFacesAlongTheirEdges) {
    for (const auto& [levels, most_edges] : {std::pair{Levels(evenly_stacked(600)), 12},
                                             std::pair{Levels(random_tree(200, 3)), 3},
                                             std::pair{Levels(open_grid(8)), 24}}) {
        const Patchwork patchwork = rough_patchwork(levels, 4, 1);
        for (std::uint64_t seed = 0; seed < 3; ++seed) {
            Random random(seed);
            std::vector<int> region = all_faces(patchwork);
            std::reverse(region.begin(), region.end());
            expect_decomposition(patchwork,
                                 region,
                                 branch_decomposition(patchwork, region, most_edges, random),
                                 most_edges);
        }
    }
}

TEST(BranchDecomposition, IsOfTheGivenFacesOnly) {
    const Levels levels(evenly_stacked(600));
    const Patchwork patchwork = rough_patchwork(levels, 10, 1);
    std::vector<int> region;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (patchwork.label(f) == 4) {
            region.push_back(f);
        }
    }
    Random random(1);
    expect_decomposition(
        patchwork, region, branch_decomposition(patchwork, region, 12, random), 12);
}

TEST(BranchDecomposition, IsEmptyWhereBlocksAreTooWideOrFacesApart) {
    const Levels levels(icosphere(4));
    const Patchwork patchwork = rough_patchwork(levels, 4, 1);
    Random random(1);
    EXPECT_TRUE(branch_decomposition(patchwork, all_faces(patchwork), 12, random).empty());
    int far = 1;
    while (patchwork.neighbor(0, 0) == far || patchwork.neighbor(0, 1) == far ||
           patchwork.neighbor(0, 2) == far) {
        ++far;
    }
    EXPECT_TRUE(branch_decomposition(patchwork, {0, far}, 12, random).empty());
    EXPECT_TRUE(branch_decomposition(patchwork, {}, 12, random).empty());
    EXPECT_EQ(branch_decomposition(patchwork, {5}, 12, random).size(), 1U);
}

} // namespace
} // namespace spheroseg
