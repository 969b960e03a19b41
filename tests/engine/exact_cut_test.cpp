// SPDX-License-Identifier: GPL-3.0-or-later
#include "exact_cut.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdlib>

namespace spheroseg {
namespace {

using namespace test;

/// A surface grown by gluing triangles to open edges: its dual graph is a tree. It is made of runs
/// of 2 or 3 faces each that hang together.
struct Tree {
    TriangleMesh mesh;
    int run_count = 0;
};

Tree planted_tree(int face_count, std::uint64_t seed) {
    Random random(seed);
    Tree tree;
    TriangleMesh& mesh = tree.mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}};
    std::vector<std::pair<int, int>> open = {{1, 0}, {2, 1}, {0, 2}};
    std::size_t run_begin = 0; // open edges of the current run are the last ones
    int left = 1;
    tree.run_count = 1;
    while (mesh.face_count() < face_count || left > 0) {
        const bool new_run = left == 0;
        if (new_run) {
            left = random.below(7) < 3 ? 3 : 2;
            ++tree.run_count;
        }
        const std::size_t first = new_run ? 0 : run_begin;
        const std::size_t at =
            first + random.below(static_cast<std::uint32_t>(open.size() - first));
        const auto [a, b] = open[at];
        const int tip = mesh.vertex_count();
        mesh.positions.push_back({1.0 * tip, 0.0, 0.0});
        mesh.faces.push_back({a, b, tip});
        open.erase(open.begin() + static_cast<std::ptrdiff_t>(at));
        run_begin = new_run ? open.size() : run_begin;
        open.emplace_back(tip, b);
        open.emplace_back(a, tip);
        --left;
    }
    return tree;
}

/// Cuts a mesh into every number of sub-meshes and compares with all labellings. How many cuts
/// there are, and for how many numbers there is none.
std::array<int, 2> compare_with_all_labellings(const TriangleMesh& mesh) {
    const Levels levels(mesh);
    const int f = mesh.face_count();
    std::array<int, 2> counts = {};
    for (int k = 1; k < f; ++k) {
        const int least = f / k;
        const int most = (f + k - 1) / k;
        Patchwork patchwork = levels.multilevel.coarsen(f, k);
        const bool found = cut_exactly(patchwork, least, most, 100000);
        std::vector<int> labels(f, 0);
        EXPECT_EQ(found, cut_exists(levels, k, least, most, labels, 0)) << f << " faces, k " << k;
        ++counts[found ? 0 : 1];
        if (found) {
            const Measures measures = measures_of(levels, patchwork);
            EXPECT_TRUE(is_sound(measures));
            EXPECT_GE(measures.min_submesh_triangles, least);
            EXPECT_LE(measures.max_submesh_triangles, most);
            EXPECT_EQ(patchwork.load, measures.submesh_triangles);
        }
    }
    return counts;
}

TEST(ExactCut, FindsACutExactlyWhereOneExists) {
    int found_count = 0;
    int impossible_count = 0;
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const auto [found, impossible] =
            compare_with_all_labellings(random_tree(4 + static_cast<int>(seed % 6), seed));
        found_count += found;
        impossible_count += impossible;
    }
    EXPECT_GT(found_count, 20);
    EXPECT_GT(impossible_count, 20);
}

TEST(ExactCut, FindsACutOfClosedMeshesExactlyWhereOneExists) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        compare_with_all_labellings(stacked(4 + 2 * static_cast<int>(seed % 4), seed));
    }
    compare_with_all_labellings(bipyramid(4));
}

TEST(ExactCut, TakesAllFacesWhateverFirstMakesABowtie) {
    // As the sub-mesh closes around a vertex, faces that could not join by one edge join by
    // another.
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const int f = 4 + 2 * static_cast<int>(seed);
        const Levels levels(stacked(f, seed));
        Patchwork patchwork = levels.multilevel.coarsen(f, 1);
        EXPECT_TRUE(cut_exactly(patchwork, f, f, kMaxSearchSteps)) << f << " faces";
        EXPECT_EQ(patchwork.load[0], f);
    }
}

TEST(ExactCut, FindsCutsOfTreesThatAreKnownToExist) {
    for (std::uint64_t seed = 0; seed < 60; ++seed) {
        const Tree tree = planted_tree(200, seed);
        const Levels levels(tree.mesh);
        Patchwork patchwork = levels.multilevel.coarsen(tree.mesh.face_count(), tree.run_count);
        EXPECT_TRUE(cut_exactly(patchwork, 2, 3, kMaxSearchSteps)) << seed;
        const Measures measures = measures_of(levels, patchwork);
        EXPECT_TRUE(is_sound(measures));
        EXPECT_GE(measures.min_submesh_triangles, 2);
        EXPECT_LE(measures.max_submesh_triangles, 3);
    }
}

TEST(ExactCut, GivesUpAfterItsSteps) {
    const Levels levels(icosphere(3));
    Patchwork patchwork = levels.multilevel.coarsen(1280, 64);
    EXPECT_FALSE(cut_exactly(patchwork, 20, 20, 10));
}

TEST(ExactCut, SearchesNothingWhereThePiecesCanNotHaveTheseSizes) {
    // Five faces are neither one sub-mesh of three or four nor two. A search that does not know
    // would try all the ways to cut the grid first, which are more than could ever be tried.
    TriangleMesh mesh = open_grid(10);
    append(mesh, random_tree(5, 1));
    const DualGraph graph = build_dual_graph(mesh);
    for (int k : {52, 60, 68}) {
        Patchwork patchwork = Multilevel(mesh, graph).coarsen(mesh.face_count(), k);
        EXPECT_FALSE(cut_exactly(patchwork, 3, 4, 1 << 30));
    }
}

TEST(ExactCut, CutsARegionEvenlyExactlyWhereThatIsPossible) {
    int found_count = 0;
    int impossible_count = 0;
    Random random(1);
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const Levels levels(sieve(displaced_sphere(2), 0.3, seed));
        const int k = levels.mesh.face_count() / 4;
        Patchwork patchwork = rough_patchwork(levels, k, seed);
        const std::vector<int> before = levels.multilevel.labels(patchwork);
        for (int l = 0; l + 1 < k; ++l) {
            const auto is_inside = [l](int label) { return label == l || label == l + 1; };
            TriangleMesh part{levels.mesh.positions, {}};
            Region region;
            region.labels = {l, l + 1};
            for (int face = 0; face < levels.mesh.face_count(); ++face) {
                if (is_inside(before[face])) {
                    part.faces.push_back(levels.mesh.faces[face]);
                }
                if (is_inside(patchwork.label(face))) { // of cells, in another order
                    region.faces.push_back(face);
                }
            }
            const int size = part.face_count();
            if (size > 10) {
                continue;
            }
            const bool found = cut_evenly(patchwork, region, 100000, random);
            std::vector<int> labels(size, 0);
            EXPECT_EQ(found, cut_exists(Levels(part), 2, size / 2, (size + 1) / 2, labels, 0))
                << l << ", seed " << seed;
            (found ? found_count : impossible_count) += 1;
            if (found) {
                const Measures measures = measures_of(levels, patchwork);
                EXPECT_TRUE(is_sound(measures));
                EXPECT_EQ(patchwork.load, measures.submesh_triangles);
                EXPECT_LE(std::abs(patchwork.load[l] - patchwork.load[l + 1]), 1);
                const std::vector<int> after = levels.multilevel.labels(patchwork);
                for (int face = 0; face < levels.mesh.face_count(); ++face) {
                    EXPECT_TRUE(is_inside(before[face]) ? is_inside(after[face])
                                                        : after[face] == before[face]);
                }
            }
            levels.multilevel.set_labels(patchwork, before);
        }
    }
    EXPECT_GT(found_count, 100);
    EXPECT_GT(impossible_count, 100);
}

} // namespace
} // namespace spheroseg
