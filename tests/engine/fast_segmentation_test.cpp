// SPDX-License-Identifier: GPL-3.0-or-later
#include "segment.h"

#include "patchwork_meshes.h"
#include "small_steps.h"
#include "thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace spheroseg {
namespace {

using namespace test;

SegmentOptions fast_options(int submesh_count, Effort effort = Effort::standard) {
    SegmentOptions options;
    options.submesh_count = submesh_count;
    options.effort = effort;
    return options;
}

TEST(Fast, IsTheDefaultMethod) {
    EXPECT_EQ(SegmentOptions().method, Method::fast);
}

TEST(Fast, FindsTheRingsOfATorus) {
    // Level sets and Lloyd's relaxation lead to disks, with 21 to 34 per cent more edges.
    const int across = 24;
    PreparedMesh prepared(torus(64, across), 1);
    for (int seed : {0, 1, 2, 3}) {
        SegmentOptions options = fast_options(5);
        options.seed = seed;
        const int edges = segment(prepared, options).measures.boundary_edge_count;
        EXPECT_GE(edges, 5 * across);
        EXPECT_LE(edges, 1.1 * 5 * across) << seed;
    }
}

TEST(Fast, FindsShortBoundariesAmongManyHoles) {
    // With holes that stay open on coarse levels they are two to three times as long.
    const TriangleMesh whole = flipped_sphere(6, 40000);
    PreparedMesh without(whole, 2);
    for (int k : {2, 5}) {
        const int edges = segment(without, fast_options(k)).measures.boundary_edge_count;
        for (const TriangleMesh& mesh : {pinholed(whole, 60), sieve(whole, 0.02, 1)}) {
            PreparedMesh with(mesh, 2);
            const Segmentation result = segment(with, fast_options(k));
            EXPECT_TRUE(result.is_valid());
            EXPECT_LE(result.measures.boundary_edge_count, 1.1 * edges) << k;
        }
    }
}

TEST(Fast, ProgressRisesInSmallSteps) {
    const TriangleMesh mesh = icosphere(4);
    int run = 0;
    for (Effort effort : {Effort::draft, Effort::standard, Effort::high}) {
        for (int k : {2, 20, 60, 200}) {
            if (run++ % kThinning != 0) {
                continue;
            }
            PreparedMesh prepared(mesh, 1);
            SegmentOptions options = fast_options(k, effort);
            options.thread_count = 1;
            expect_small_steps(prepared, options);
        }
    }
}

TEST(Fast, EveryKOnSmallMeshesIsValid) {
    const TriangleMesh meshes[] = {
        tetrahedron(), octahedron(), icosahedron(), bipyramid(30), slivers(40), icosphere(1)};
    for (const TriangleMesh& mesh : meshes) {
        PreparedMesh prepared(mesh, 1);
        for (int k = 1; k <= mesh.face_count(); ++k) {
            const Measures measures = segment(prepared, fast_options(k, Effort::draft)).measures;
            EXPECT_TRUE(measures.is_valid())
                << mesh.face_count() << " faces, k " << k << ": MTCD "
                << measures.max_triangle_count_difference << ", disconnected "
                << measures.disconnected_submesh_count << ", bowties " << measures.bowtie_count;
        }
    }
}

TEST(Fast, EveryKOnNarrowTubesIsValid) {
    // Three faces around: a sub-mesh that closes to a ring of six can not give a face away.
    for (int split_count : {7, 11, 16, 23, 40}) {
        const TriangleMesh mesh = slivers(split_count, true);
        PreparedMesh prepared(mesh, 1);
        for (int k = 1; k <= mesh.face_count() / 2; ++k) {
            EXPECT_TRUE(segment(prepared, fast_options(k, Effort::draft)).measures.is_valid())
                << mesh.face_count() << " faces, k " << k;
        }
    }
}

TEST(Fast, NoEffortIsSpentOnPairsOfTriangles) {
    for (const TriangleMesh& mesh : {displaced_sphere(2), slivers(60), grid_with_holes(20)}) {
        PreparedMesh prepared(mesh, 1);
        const int face_count = mesh.face_count();
        const int edge_count =
            segment(prepared, fast_options(face_count, Effort::draft)).measures.boundary_edge_count;
        for (int k : {face_count / 2, face_count / 2 + 1, face_count - 3}) {
            const Segmentation draft = segment(prepared, fast_options(k, Effort::draft));
            const Segmentation high = segment(prepared, fast_options(k, Effort::high));
            // Each pair hides one of the edges inside the surface.
            EXPECT_EQ(draft.measures.boundary_edge_count, edge_count - (face_count - k));
            EXPECT_EQ(high.labels, draft.labels);
            EXPECT_EQ(high.refinement_iterations, draft.refinement_iterations);
        }
    }
}

/// How often the step comes after another one.
int times_begun(PreparedMesh& prepared, const SegmentOptions& options, const std::string& wanted) {
    int times = 0;
    std::string last;
    segment(prepared, options, [&](double, const char* step) {
        times += step == wanted && last != wanted;
        last = step;
        return true;
    });
    return times;
}

TEST(Fast, HighKeepsNoReserveOfWhatIsADraftAnyway) {
    const TriangleMesh mesh = displaced_sphere(2);
    PreparedMesh prepared(mesh, 1);
    for (const auto& [faces_each, reserves] : {std::pair{4, 1}, std::pair{2, 0}}) {
        SegmentOptions options = fast_options(mesh.face_count() / faces_each, Effort::high);
        const int without_limit = times_begun(prepared, options, "Exchanges");
        EXPECT_GE(without_limit, 1);
        options.time_limit_seconds = 1000.0;
        EXPECT_EQ(times_begun(prepared, options, "Exchanges"), without_limit + reserves);
    }
}

/// An open tube of `rings` rings of three squares, two triangles each.
TriangleMesh tube_of_squares(int rings) {
    TriangleMesh mesh;
    for (int i = 0; i < 3 * (rings + 1); ++i) {
        mesh.positions.push_back({std::cos(i % 3 * 2.1), std::sin(i % 3 * 2.1), 1.0 * (i / 3)});
    }
    for (int r = 0; r < rings; ++r) {
        for (int i = 0; i < 3; ++i) {
            const int a = 3 * r + i;
            const int b = 3 * r + (i + 1) % 3;
            mesh.faces.push_back({a, b, b + 3});
            mesh.faces.push_back({a, b + 3, a + 3});
        }
    }
    return mesh;
}

/// The shortest boundary of k rings of equal loads, up to one, on that tube: a cut between two
/// rings of squares has three edges, and each face beyond that adds or saves edges.
int shortest_rings(int face_count, int k) {
    constexpr int kEdges[6] = {3, 4, 5, 4, 5, 4};
    const int larger_count = face_count % k;
    std::vector<int> least(larger_count + 1, 1 << 30);
    least[0] = 0;
    for (int i = 1; i <= k; ++i) {
        for (int larger = std::min(i, larger_count); larger >= 0; --larger) {
            const int before = std::min(least[larger], larger > 0 ? least[larger - 1] : 1 << 30);
            const int end = face_count / k * i + larger;
            const bool too_few = i - larger > k - larger_count;
            least[larger] = too_few ? 1 << 30 : before + (i < k ? kEdges[end % 6] : 0);
        }
    }
    return least[larger_count];
}

TEST(Fast, TubesAreCutAlmostAsShortAsTheBalanceAllows) {
    EXPECT_EQ(shortest_rings(12, 2), 3);
    EXPECT_EQ(shortest_rings(14, 2), 4);
    EXPECT_EQ(shortest_rings(12, 3), 10);
    for (int rings : {200, 400, 701}) {
        const TriangleMesh mesh = tube_of_squares(rings);
        PreparedMesh prepared(mesh, 1);
        for (int k : {2, 3, 4, 5, 7, 10, 15, 20}) {
            const Measures measures = segment(prepared, fast_options(k)).measures;
            EXPECT_TRUE(measures.is_valid());
            EXPECT_LE(measures.boundary_edge_count, 1.1 * shortest_rings(mesh.face_count(), k))
                << rings << " rings, k " << k;
        }
    }
}

TEST(Fast, SweepsOfKOnLargerMeshesAreValid) {
    for (const TriangleMesh& mesh :
         {limbed_figure(3), flipped_sphere(3, 800), displaced_sphere(4)}) {
        PreparedMesh prepared(mesh, 2);
        const int f = mesh.face_count();
        for (int k :
             {1, 2, 3, 11, 50, f / 64, f / 20, f / 7, 10 * f / 31, f / 3, f / 2, f - 1, f}) {
            for (Effort effort : {Effort::draft, Effort::standard}) {
                const Segmentation result = segment(prepared, fast_options(k, effort));
                EXPECT_TRUE(result.measures.is_valid()) << f << " faces, k " << k;
                EXPECT_EQ(result.measures.submesh_count, k);
            }
        }
    }
}

TEST(Fast, StackedTriangulationsAreBalanced) {
    // Thousands of small sub-meshes around vertices of any valence: single faces can hardly pass.
    PreparedMesh prepared(stacked(5000, 1), 1);
    const int f = prepared.mesh().face_count();
    for (int k : {f / 3, f / 4, f / 6, f / 9}) {
        const Segmentation result = segment(prepared, fast_options(k, Effort::draft));
        EXPECT_TRUE(result.measures.is_valid()) << k;
        EXPECT_EQ(result.measures.submesh_count, k);
    }
}

TEST(Fast, SameSeedSameLabelsForAnyThreadCountAndOnAReusedMesh) {
    const TriangleMesh mesh = limbed_figure(4);
    for (Effort effort : {Effort::draft, Effort::standard, Effort::high}) {
        SegmentOptions options = fast_options(effort == Effort::high ? 60 : 130, effort);
        std::vector<int> reference;
        for (int threads : {1, 2, 3}) {
            options.thread_count = threads;
            PreparedMesh prepared(mesh, threads);
            const std::vector<int> labels = segment(prepared, options).labels;
            segment(prepared, fast_options(17, Effort::draft));
            EXPECT_EQ(segment(prepared, options).labels, labels);
            if (reference.empty()) {
                reference = labels;
            }
            EXPECT_EQ(labels, reference) << threads << " threads";
        }
        options.seed = 1;
        PreparedMesh prepared(mesh, 1);
        EXPECT_NE(segment(prepared, options).labels, reference);
    }
}

TEST(Fast, DependsOnConnectivityOnly) {
    TriangleMesh mesh = displaced_sphere(3);
    PreparedMesh prepared(mesh, 1);
    for (Vec3& p : mesh.positions) {
        p = {p.x * 1e-3 + 5.0, p.z, -p.y * 100.0};
    }
    PreparedMesh moved(mesh, 1);
    for (Effort effort : {Effort::standard, Effort::high}) {
        const SegmentOptions options = fast_options(64, effort);
        EXPECT_EQ(segment(prepared, options).labels, segment(moved, options).labels);
    }
}

TEST(Fast, WhatAMapLeftBehindGivesTheSameLabels) {
    const TriangleMesh mesh = displaced_sphere(3);
    PreparedMesh fresh(mesh, 1);
    PreparedMesh mapped(mesh, 1);
    mapped.parametrization(1);
    const SegmentOptions options = fast_options(8, Effort::draft);
    EXPECT_EQ(segment(mapped, options).labels, segment(fresh, options).labels);
}

TEST(Fast, MoreEffortGivesShorterBoundaries) {
    PreparedMesh prepared(displaced_sphere(4), 2);
    int draft = 0;
    int standard = 0;
    int high = 0;
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
        const auto edges = [&](Effort effort) {
            SegmentOptions options = fast_options(80, effort);
            options.seed = seed;
            return segment(prepared, options).measures.boundary_edge_count;
        };
        draft += edges(Effort::draft);
        standard += edges(Effort::standard);
        high += edges(Effort::high);
    }
    EXPECT_LT(standard, draft);
    EXPECT_LT(high, standard);
}

TEST(Fast, ATimeLimitLeavesAValidResultAndIsReported) {
    PreparedMesh prepared(displaced_sphere(4), 2);
    for (double limit : {1e-9, 1e-3, 5e-3, 2e-2}) {
        SegmentOptions options = fast_options(150, Effort::high);
        options.time_limit_seconds = limit;
        const Segmentation result = segment(prepared, options);
        EXPECT_TRUE(result.measures.is_valid()) << limit;
        EXPECT_TRUE(result.time_limit_hit) << limit;
    }
    EXPECT_FALSE(segment(prepared, fast_options(150, Effort::draft)).time_limit_hit);
}

TEST(Fast, CancelAtAnyCallLeavesThePreparedMeshUsable) {
    const TriangleMesh mesh = displaced_sphere(3);
    PreparedMesh prepared(mesh, 2);
    SegmentOptions options = fast_options(40, Effort::draft);
    options.thread_count = 1; // with more, the number of calls depends on which one does what
    const std::vector<int> labels = segment(prepared, options).labels;
    int calls = 0;
    double last = 0.0;
    segment(prepared, options, [&](double fraction, const char*) {
        EXPECT_GE(fraction, last);
        EXPECT_LE(fraction, 1.0);
        last = fraction;
        ++calls;
        return true;
    });
    EXPECT_EQ(last, 1.0);
    ASSERT_GT(calls, 10);
    for (int stop = 1; stop <= calls; stop += 3) {
        PreparedMesh fresh(mesh, 2);
        int left = stop;
        EXPECT_THROW(segment(fresh, options, [&](double, const char*) { return --left > 0; }),
                     Cancelled);
        EXPECT_EQ(segment(fresh, options).labels, labels);
    }
}

TEST(Fast, IterationLimitsHoldAndTheHistoryMatchesTheCounts) {
    PreparedMesh prepared(displaced_sphere(3), 1);
    const auto expect_history = [](const Segmentation& result) {
        const auto count =
            static_cast<std::size_t>(result.cohesion_iterations + result.refinement_iterations);
        ASSERT_EQ(result.seconds_by_iteration.size(), count);
        ASSERT_EQ(result.boundary_edges_by_iteration.size(), count);
        EXPECT_EQ(result.energy_by_iteration, result.boundary_edges_by_iteration);
        EXPECT_EQ(result.boundary_edges_by_iteration.back(), result.measures.boundary_edge_count);
    };
    PreparedMesh larger(mesh_for_a_sphere_start(), 1);
    for (Effort effort : {Effort::standard, Effort::high}) {
        // `high` makes a second start there, on the sphere.
        PreparedMesh& mesh = effort == Effort::high ? larger : prepared;
        for (int seed = 0; seed < (effort == Effort::high ? 2 : 4); seed += kThinning) {
            SegmentOptions options = fast_options(50, effort);
            options.seed = seed;
            options.max_refinement_iterations = effort == Effort::high ? 30 : 0;
            expect_history(segment(mesh, options));
            options.max_cohesion_iterations = 3;
            options.max_refinement_iterations = 5;
            const Segmentation cut = segment(mesh, options);
            expect_history(cut);
            EXPECT_EQ(cut.cohesion_iterations, 3);
            EXPECT_EQ(cut.refinement_iterations, 5);
            EXPECT_TRUE(cut.measures.is_valid());
        }
    }
    // Limits that are never reached change nothing, also where there are several trials.
    for (int k : {3, 10}) {
        SegmentOptions options = fast_options(k, Effort::standard);
        const std::vector<int> labels = segment(prepared, options).labels;
        options.max_cohesion_iterations = 10000;
        options.max_refinement_iterations = 10000;
        EXPECT_EQ(segment(prepared, options).labels, labels) << k;
    }
    SegmentOptions by_weight = fast_options(150, Effort::draft);
    by_weight.balance = Balance::weight;
    for (int limit : {1, 13, 30, 60}) {
        by_weight.max_refinement_iterations = limit;
        const Segmentation cut = segment(prepared, by_weight);
        expect_history(cut);
        EXPECT_LE(cut.refinement_iterations, limit);
    }
    // Labels are kept as soon as `draft` can not better them.
    for (Balance balance : {Balance::triangle_count, Balance::weight}) {
        SegmentOptions options = fast_options(150, Effort::high);
        options.balance = balance;
        std::vector<int> labels = segment(prepared, options).labels;
        options.effort = Effort::draft;
        options.submesh_count = 0;
        for (int call = 0; call < 10 && options.initial_labels != labels; ++call) {
            options.initial_labels = labels;
            const Segmentation result = segment(prepared, options);
            expect_history(result);
            labels = result.labels;
        }
        EXPECT_EQ(options.initial_labels, labels);
    }
}

TEST(Fast, OfResultsThatAreNotValidTheBestBalancedOneIsKept) {
    // Trees have as many boundary edges whatever the labels, and can mostly not be balanced. The
    // start from random labels ends far from it, fresh ones do not.
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        constexpr int kFaces = 2000;
        PreparedMesh prepared(random_tree(kFaces, seed), 1);
        SegmentOptions options = fast_options(0, Effort::draft);
        Random random(seed);
        for (int f = 0; f < kFaces; ++f) {
            options.initial_labels.push_back(f < 20 ? f : static_cast<int>(random.below(20)));
        }
        const Segmentation result = segment(prepared, options);
        EXPECT_TRUE(is_sound(result.measures));
        EXPECT_EQ(result.measures.boundary_edge_count, 19);
        EXPECT_LT(result.measures.max_triangle_count_difference, 150);
    }
}

} // namespace
} // namespace spheroseg
