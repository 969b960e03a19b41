// SPDX-License-Identifier: GPL-3.0-or-later
#include "bridge_bound.h"

#include "patchwork_meshes.h"
#include "segment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace spheroseg {
namespace {

using namespace test;

/// All faces in the first of `submesh_count` sub-meshes, whose number gives the even loads.
Patchwork uncut(const Levels& levels, int submesh_count) {
    return levels.multilevel.coarsen(levels.mesh.face_count(), submesh_count, 1);
}

/// At its even loads.
std::int64_t bound_of(const Patchwork& patchwork) {
    return least_misplaced(patchwork, even_loads(patchwork));
}

/// The even loads, and wider ranges.
std::array<LoadRange, 3> ranges_of(const Patchwork& patchwork) {
    const LoadRange even = even_loads(patchwork);
    return {even, {std::max(1, even.floor - 1), even.ceiling}, {even.floor, even.ceiling + 1}};
}

/// Over all ways to keep or cut each edge between two faces.
std::int64_t
least_misplaced_of_all(const Patchwork& patchwork, const LoadRange& asked, std::size_t most_edges) {
    std::vector<std::pair<int, int>> edges;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int neighbor : patchwork.neighbors(f)) {
            if (neighbor > f) {
                edges.emplace_back(f, neighbor);
            }
        }
    }
    if (edges.size() > most_edges) {
        return -1;
    }
    std::int64_t least = patchwork.face_count();
    for (std::uint32_t kept = 0; kept < 1U << edges.size(); ++kept) {
        std::vector<int> root(patchwork.face_count());
        std::iota(root.begin(), root.end(), 0);
        const auto root_of = [&root](int f) {
            while (root[f] != f) {
                f = root[f];
            }
            return f;
        };
        for (std::size_t e = 0; e < edges.size(); ++e) {
            if ((kept >> e & 1) != 0) {
                root[root_of(edges[e].first)] = root_of(edges[e].second);
            }
        }
        std::vector<int> load(root.size(), 0);
        for (int f = 0; f < patchwork.face_count(); ++f) {
            ++load[root_of(f)];
        }
        std::int64_t sum = 0;
        for (int faces : load) {
            sum += faces > 0 ? asked.deviation(faces) : 0;
        }
        least = std::min(least, sum);
    }
    return least;
}

TEST(BridgeBound, OfStripsAtAFace) {
    const auto bound = [](const std::array<int, 3>& lengths, int submesh_count) {
        return bound_of(uncut(Levels(star(lengths)), submesh_count));
    };
    EXPECT_EQ(bound({4, 4, 4}, 2), 4);             // 4 and 9 of 13, instead of 6 and 7
    EXPECT_EQ(bound({6, 4, 2}, 2), 0);             // 6 and 7
    EXPECT_EQ(bound({3, 3, 3}, 2), 4);             // 3 and 7 of 10
    EXPECT_EQ(bound({4, 4, 4}, 3), 0);             // 4, 4 and 5
    EXPECT_EQ(bound({6, 6, 7}, 4), 0);             // 5 of each strip, and what they leave
    EXPECT_EQ(bound({600, 600, 600}, 2), 600);     // 600 and 1,201
    EXPECT_EQ(bound({3000, 3000, 3000}, 2), 1001); // as far as it looks
}

TEST(BridgeBound, IsExactOnTreesOfFaces) {
    int positive_count[3] = {};
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
        const Levels levels(random_tree(8 + static_cast<int>(seed % 5), seed));
        for (int k = 1; k <= levels.mesh.face_count(); ++k) {
            const Patchwork patchwork = uncut(levels, k);
            int range = 0;
            for (const LoadRange& asked : ranges_of(patchwork)) {
                const std::int64_t bound = least_misplaced(patchwork, asked);
                EXPECT_EQ(bound, least_misplaced_of_all(patchwork, asked, 12))
                    << seed << ", k " << k << ", " << asked.floor << " to " << asked.ceiling;
                positive_count[range++] += bound > 0;
            }
        }
    }
    EXPECT_GE(positive_count[0], 40);
    EXPECT_GE(positive_count[1], 20);
    EXPECT_GE(positive_count[2], 20);
}

TEST(BridgeBound, IsNoMoreThanTheLeastElsewhereAndNotMuchLess) {
    int checked_count[3] = {};
    int positive_count[3] = {};
    std::int64_t bound_sum = 0;
    std::int64_t least_sum = 0;
    for (std::uint64_t seed = 0; seed < 300; ++seed) {
        const Levels levels(sieve(open_grid(4), 0.3, seed));
        for (int k = 2; k < levels.mesh.face_count(); ++k) {
            const Patchwork patchwork = uncut(levels, k);
            int range = 0;
            for (const LoadRange& asked : ranges_of(patchwork)) {
                const std::int64_t least = least_misplaced_of_all(patchwork, asked, 12);
                if (least >= 0) {
                    const std::int64_t bound = least_misplaced(patchwork, asked);
                    EXPECT_LE(bound, least)
                        << seed << ", k " << k << ", " << asked.floor << " to " << asked.ceiling;
                    bound_sum += bound;
                    least_sum += least;
                    ++checked_count[range];
                    positive_count[range] += bound > 0;
                }
                ++range;
            }
        }
    }
    EXPECT_GE(*std::min_element(checked_count, checked_count + 3), 200);
    EXPECT_GE(positive_count[0], 30);
    EXPECT_GE(positive_count[1], 10);
    EXPECT_GE(positive_count[2], 10);
    EXPECT_GE(bound_sum, 0.88 * least_sum);
}

TEST(BridgeBound, IsZeroWithoutBridges) {
    for (const TriangleMesh& mesh : {icosphere(2), torus(12, 8), bipyramid(20)}) {
        const Levels levels(mesh);
        for (int k : {2, 7, 40}) {
            EXPECT_EQ(bound_of(uncut(levels, k)), 0);
        }
    }
}

TEST(BridgeBound, OfLongStripsTakesNoDeepRecursionOrMuchWork) {
    EXPECT_EQ(bound_of(uncut(Levels(star({100000, 50000, 3})), 150)), 0);
}

TEST(BridgeBound, EndsTheSearchWhereItIsReached) {
    const TriangleMesh mesh = star({600, 600, 600});
    SegmentOptions options;
    options.submesh_count = 2;
    options.thread_count = 1;
    PreparedMesh prepared(mesh, 1);
    const Segmentation result = segment(prepared, options);
    EXPECT_EQ(result.measures.submesh_triangles[0] + result.measures.submesh_triangles[1], 1801);
    EXPECT_EQ(result.measures.max_triangle_count_difference, 601); // 600 and 1,201
    EXPECT_FALSE(result.is_valid());
    EXPECT_FALSE(result.may_be_balanced);
    options.submesh_count = 3;
    const Segmentation other = segment(prepared, options);
    EXPECT_TRUE(other.is_valid());
    EXPECT_TRUE(other.may_be_balanced);
}

} // namespace
} // namespace spheroseg
