// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree_cut.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheroseg {
namespace {

using namespace test;

/// The faces of some sub-meshes.
Region region_of(const Patchwork& patchwork, const std::vector<int>& labels) {
    Region region{{}, labels};
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (std::find(labels.begin(), labels.end(), patchwork.label(f)) != labels.end()) {
            region.faces.push_back(f);
        }
    }
    return region;
}

/// Sub-meshes that hang together, drawn at random; `count` or fewer.
std::vector<int> neighboring_labels(const Patchwork& patchwork, int count, Random& random) {
    std::vector<int> labels = {
        static_cast<int>(random.below(static_cast<std::uint32_t>(patchwork.submesh_count())))};
    for (int tries = 0; tries < 100 && static_cast<int>(labels.size()) < count; ++tries) {
        const auto f =
            static_cast<int>(random.below(static_cast<std::uint32_t>(patchwork.face_count())));
        const int across = patchwork.label_across(f, static_cast<int>(random.below(3)));
        const auto has = [&](int label) {
            return std::find(labels.begin(), labels.end(), label) != labels.end();
        };
        if (across >= 0 && has(patchwork.label(f)) && !has(across)) {
            labels.push_back(across);
        }
    }
    return labels;
}

/// Sizes of sub-meshes, each at least one face, that sum up to `face_count`.
std::vector<int> random_sizes(int face_count, std::size_t count, Random& random) {
    std::vector<int> sizes(count, 1);
    for (int left = face_count - static_cast<int>(count); left > 0; --left) {
        ++sizes[random.below(static_cast<std::uint32_t>(count))];
    }
    return sizes;
}

TEST(TreeCut, GivesEachSubmeshTheSizeThatIsWantedAndLeavesOthersAlone) {
    const std::vector<TriangleMesh> meshes = {displaced_sphere(3),
                                              stacked(1000, 1),
                                              bipyramid(300),
                                              torus(20, 12),
                                              moebius_strip(60, 5),
                                              sieve(displaced_sphere(3), 0.15, 1)};
    for (const TriangleMesh& mesh : meshes) {
        const Levels levels(mesh);
        const int k = mesh.face_count() / 12;
        Patchwork patchwork = rough_patchwork(levels, k, 1);
        TreeCut at_random(patchwork);
        TreeCut along_walls(patchwork, TreeTurns::often_along_walls);
        Random random(1);
        int cut_count = 0;
        constexpr int kTries = 200;
        for (int i = 0; i < kTries; ++i) {
            const Patchwork before = patchwork;
            const Region region = region_of(
                patchwork,
                neighboring_labels(patchwork, 2 + static_cast<int>(random.below(4)), random));
            const std::vector<int> sizes =
                random_sizes(static_cast<int>(region.faces.size()), region.labels.size(), random);
            TreeCut& tree_cut = i % 2 == 0 ? at_random : along_walls;
            if (!tree_cut.cut(region, sizes, random)) {
                patchwork = before;
                continue;
            }
            ++cut_count;
            const Measures measures = measures_of(levels, patchwork);
            ASSERT_TRUE(is_sound(measures)) << mesh.face_count() << " faces, cut " << i;
            ASSERT_EQ(patchwork.load, measures.submesh_triangles);
            for (std::size_t l = 0; l < sizes.size(); ++l) {
                ASSERT_EQ(patchwork.load[region.labels[l]], sizes[l]);
            }
            std::vector<std::uint8_t> is_inside(patchwork.cells.size(), 0);
            for (int f : region.faces) {
                is_inside[f] = 1;
            }
            for (int f = 0; f < patchwork.face_count(); ++f) {
                ASSERT_TRUE(is_inside[f] || patchwork.label(f) == before.label(f));
            }
        }
        EXPECT_GT(cut_count, kTries / 3) << mesh.face_count() << " faces";
    }
}

TEST(TreeCut, FindsOnlyCutsThatExistAndMostOfThem) {
    int existing_count = 0;
    int found_count = 0;
    int impossible_count = 0;
    Random random(1);
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Levels levels(sieve(displaced_sphere(2), 0.3, seed));
        const int k = levels.mesh.face_count() / 4;
        Patchwork patchwork = rough_patchwork(levels, k, seed);
        const std::vector<int> before = levels.multilevel.labels(patchwork);
        for (int l = 0; l + 1 < k; ++l) {
            TriangleMesh part{levels.mesh.positions, {}};
            for (int face = 0; face < levels.mesh.face_count(); ++face) {
                if (before[face] == l || before[face] == l + 1) {
                    part.faces.push_back(levels.mesh.faces[face]);
                }
            }
            const int size = part.face_count();
            const bool hangs_together = faces_of_components(build_dual_graph(part, 1)).size() == 1;
            if (size > 10 || !hangs_together) {
                continue;
            }
            std::vector<int> labels(size, 0);
            const bool exists = cut_exists(Levels(part), 2, size / 2, (size + 1) / 2, labels, 0);
            const Region region = region_of(patchwork, {l, l + 1});
            TreeCut tree_cut(patchwork);
            bool found = false;
            for (int i = 0; i < 10 && !found; ++i) {
                found = tree_cut.cut(region, {size / 2, size - size / 2}, random);
            }
            EXPECT_TRUE(exists || !found) << l << ", seed " << seed;
            (exists ? existing_count : impossible_count) += 1;
            found_count += found;
            levels.multilevel.set_labels(patchwork, before);
        }
    }
    EXPECT_GT(existing_count, 100);
    EXPECT_GT(impossible_count, 40);
    EXPECT_GT(found_count, 0.9 * existing_count);
}

/// Two sub-meshes: the first faces of a mesh, which hang together, and the others.
Patchwork two_of(const Levels& levels, int first_count) {
    const int face_count = levels.mesh.face_count();
    Patchwork patchwork = levels.multilevel.coarsen(face_count, 2);
    std::vector<int> labels(face_count, 1);
    std::fill_n(labels.begin(), first_count, 0);
    levels.multilevel.set_labels(patchwork, labels);
    return patchwork;
}

TEST(TreeCut, InTwoComesAsNearToWhatIsWantedAsTheOnlyTreeAllows) {
    // A tree of ten faces: sizes of what hangs on each side of its nine inner edges, by hand.
    TriangleMesh star; // three arms of three faces around one
    star.positions.resize(12);
    star.faces = {{0, 1, 2},
                  {1, 0, 3},
                  {0, 3, 4},
                  {3, 4, 5},
                  {2, 1, 6},
                  {1, 6, 7},
                  {6, 7, 8},
                  {0, 2, 9},
                  {2, 9, 10},
                  {9, 10, 11}};
    const Levels levels(star);
    Random random(1);
    struct Case {
        int wanted;
        int limit;
        int expected; // 0: none
    };
    // An arm, or a part of it, can be cut off: 1, 2 or 3 faces, or 9, 8 or 7.
    for (const auto& [wanted, limit, expected] : {Case{3, 3, 3},
                                                  Case{5, 9, 7},
                                                  Case{5, 1, 3},
                                                  Case{8, 9, 8},
                                                  Case{5, 6, 0},
                                                  Case{5, 4, 0}}) {
        Patchwork patchwork = two_of(levels, 1);
        const Region region = region_of(patchwork, {0, 1});
        EXPECT_EQ(TreeCut(patchwork).cut_in_two(region, wanted, limit, random), expected > 0);
        if (expected > 0) {
            EXPECT_EQ(patchwork.load[0], expected) << wanted << " to " << limit;
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
            EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
        }
    }
}

TEST(TreeCut, InTwoGivesExactlyWhatIsWantedWhereTreesAreMany) {
    const Levels levels(displaced_sphere(2)); // 320 faces
    Random random(1);
    int exact_count = 0;
    for (int wanted = 1; wanted < 320; ++wanted) {
        Patchwork patchwork = two_of(levels, 1);
        const Region region = region_of(patchwork, {0, 1});
        if (TreeCut(patchwork).cut_in_two(region, wanted, 319, random)) {
            EXPECT_GE(patchwork.load[0], wanted);
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << wanted;
            exact_count += patchwork.load[0] == wanted;
        }
    }
    EXPECT_GT(exact_count, 280);
}

TEST(TreeCut, ThereIsNoneWhereFacesDoNotHangTogether) {
    TriangleMesh mesh = tetrahedron();
    append(mesh, tetrahedron());
    const DualGraph graph = build_dual_graph(mesh);
    const Multilevel multilevel(mesh, graph);
    Patchwork patchwork = multilevel.coarsen(8, 2);
    multilevel.set_labels(patchwork, {0, 0, 0, 0, 1, 1, 1, 1});
    const Region region = region_of(patchwork, {0, 1});
    Random random(1);
    EXPECT_FALSE(TreeCut(patchwork).cut(region, {3, 5}, random));
    EXPECT_FALSE(TreeCut(patchwork).cut_in_two(region, 3, 1, random));
}

} // namespace
} // namespace spheroseg
