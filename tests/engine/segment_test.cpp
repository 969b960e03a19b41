// SPDX-License-Identifier: GPL-3.0-or-later
#include "segment.h"

#include "all_pairs_cohesion.h"
#include "all_pairs_refinement.h"
#include "cohesion_state.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace spheroseg {
namespace {

using namespace test;

SegmentOptions all_pairs_options(int submesh_count) {
    SegmentOptions options;
    options.method = Method::all_pairs;
    options.submesh_count = submesh_count;
    return options;
}

template <typename Error>
void expect_error(PreparedMesh& mesh, const SegmentOptions& options, const std::string& part) {
    try {
        segment(mesh, options);
        FAIL() << "no error that says: " << part;
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(RequestedSubmeshCount, DefaultsTo200OrATenthOfASmallMesh) {
    const SegmentOptions options;
    EXPECT_EQ(requested_submesh_count(options, 1000000), 200);
    EXPECT_EQ(requested_submesh_count(options, 2000), 200);
    EXPECT_EQ(requested_submesh_count(options, 1991), 200);
    EXPECT_EQ(requested_submesh_count(options, 1990), 199);
    EXPECT_EQ(requested_submesh_count(options, 20), 2);
    EXPECT_EQ(requested_submesh_count(options, 4), 1);
}

TEST(RequestedSubmeshCount, TrianglesPerSubmeshWinsAndRoundsUp) {
    SegmentOptions options;
    options.submesh_count = 7;
    EXPECT_EQ(requested_submesh_count(options, 100), 7);
    options.triangles_per_submesh = 30;
    EXPECT_EQ(requested_submesh_count(options, 100), 4);
    options.triangles_per_submesh = 25;
    EXPECT_EQ(requested_submesh_count(options, 100), 4);
    options.triangles_per_submesh = 1000;
    EXPECT_EQ(requested_submesh_count(options, 100), 1);
}

TEST(Segment, AllPairsIsBalancedOnEveryMeshForEveryK) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        PreparedMesh prepared(mesh, 2);
        for (int k : {1, 2, 7, mesh.face_count() / 3, mesh.face_count()}) {
            if (k > mesh.face_count()) {
                continue;
            }
            SCOPED_TRACE(name + ", k = " + std::to_string(k));
            SegmentOptions options = all_pairs_options(k);
            options.max_cohesion_iterations = 3;
            options.max_refinement_iterations = 2;
            const Segmentation result = segment(prepared, options);
            const Measures& m = result.measures;
            ASSERT_EQ(static_cast<int>(result.labels.size()), mesh.face_count());
            EXPECT_EQ(m.submesh_count, k);
            EXPECT_LE(m.max_triangle_count_difference, mesh.face_count() % k == 0 ? 0 : 1);
            EXPECT_GE(m.min_submesh_triangles, 1);
            EXPECT_LE(result.cohesion_iterations, 3);
            EXPECT_LE(result.refinement_iterations, 2);
            const auto iterations =
                static_cast<std::size_t>(result.cohesion_iterations + result.refinement_iterations);
            EXPECT_EQ(result.boundary_edges_by_iteration.size(), iterations);
            EXPECT_EQ(result.seconds_by_iteration.size(), iterations);
            EXPECT_EQ(result.energy_by_iteration.size(), iterations);
        }
    }
}

TEST(Segment, SameSeedSameLabelsForAnyThreadCountAndOnASecondRun) {
    PreparedMesh prepared(displaced_sphere(4));
    SegmentOptions options = all_pairs_options(40);
    options.seed = 3;
    options.thread_count = 1;
    const Segmentation first = segment(prepared, options);
    EXPECT_EQ(segment(prepared, options).labels, first.labels);
    options.thread_count = 2;
    EXPECT_EQ(segment(prepared, options).labels, first.labels);
    PreparedMesh again(displaced_sphere(4), 2);
    EXPECT_EQ(segment(again, options).labels, first.labels);
    options.seed = 4;
    EXPECT_NE(segment(prepared, options).labels, first.labels);
}

TEST(Segment, AbsurdThreadCountsGiveTheSameLabels) {
    PreparedMesh prepared(icosphere(2));
    for (Method method : {Method::fast, Method::all_pairs}) {
        SegmentOptions options = all_pairs_options(20);
        options.method = method;
        options.thread_count = 1;
        const std::vector<int> expected = segment(prepared, options).labels;
        options.thread_count = std::numeric_limits<int>::max();
        PreparedMesh other(icosphere(2), options.thread_count);
        EXPECT_EQ(segment(other, options).labels, expected);
    }
}

TEST(Segment, RefinementLowersBoundaryAndBowties) {
    PreparedMesh prepared(displaced_sphere(4));
    const Segmentation result = segment(prepared, all_pairs_options(100));
    const Measures& before = result.measures_after_cohesion;
    EXPECT_LT(result.measures.boundary_edge_count, before.boundary_edge_count);
    EXPECT_LE(result.measures.bowtie_count, before.bowtie_count);
    EXPECT_FALSE(result.time_limit_hit);
    EXPECT_FALSE(result.used_cuda);
}

TEST(Segment, TimeLimitLeavesABalancedResultAndIsReported) {
    PreparedMesh prepared(icosphere(4));
    SegmentOptions options = all_pairs_options(30);
    options.time_limit_seconds = 1e-6;
    const Segmentation result = segment(prepared, options);
    EXPECT_TRUE(result.time_limit_hit);
    EXPECT_LE(result.measures.max_triangle_count_difference, 1);
}

TEST(Segment, ProgressRisesFromZeroToOne) {
    PreparedMesh prepared(icosphere(3));
    std::vector<double> values;
    segment(prepared, all_pairs_options(20), [&](double fraction, const char* step) {
        EXPECT_NE(step, nullptr);
        values.push_back(fraction);
        return true;
    });
    EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
    EXPECT_EQ(values.front(), 0.0);
    EXPECT_EQ(values.back(), 1.0);
}

TEST(Segment, CancelAtAnyMomentLeavesThePreparedMeshUsable) {
    PreparedMesh reference(icosphere(3));
    const SegmentOptions options = all_pairs_options(20);
    const std::vector<int> expected = segment(reference, options).labels;
    for (int calls_allowed : {0, 1, 2, 4, 8}) {
        PreparedMesh prepared(icosphere(3));
        int calls = 0;
        const auto stop_late = [&](double, const char*) { return calls++ < calls_allowed; };
        EXPECT_THROW(segment(prepared, options, stop_late), Cancelled);
        EXPECT_EQ(calls, calls_allowed + 1);
        EXPECT_EQ(segment(prepared, options).labels, expected);
    }
}

TEST(Segment, AMapMadeBeforeIsUsed) {
    const TriangleMesh mesh = icosphere(3);
    PreparedMesh prepared(mesh);
    EXPECT_FALSE(prepared.set_parametrization({}));
    EXPECT_TRUE(prepared.set_parametrization(mesh.positions));
    const SegmentOptions options = all_pairs_options(20);
    const std::vector<int> labels = segment(prepared, options).labels;
    const std::vector<Vec3>& kept = prepared.parametrization().positions;
    ASSERT_EQ(kept.size(), mesh.positions.size());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        ASSERT_EQ(length(kept[v] - mesh.positions[v]), 0.0) << v;
    }
    const int face_count = mesh.face_count();
    std::vector<int> expected = random_balanced_labels(face_count, 20, options.seed);
    cohere_all_pairs(prepared.dual_graph(),
                     face_centroids_on_sphere(mesh, mesh.positions),
                     20,
                     options.seed,
                     {},
                     expected);
    refine_all_pairs(prepared.dual_graph(), {}, expected);
    EXPECT_EQ(labels, expected);
    PreparedMesh without_map(mesh);
    EXPECT_NE(segment(without_map, options).labels, expected);
}

TEST(Segment, NoMapOfWhatIsNotASphere) {
    TriangleMesh turned = icosphere(2);
    std::swap(turned.faces[3][0], turned.faces[3][1]);
    for (const TriangleMesh& mesh : {TriangleMesh{}, open_grid(4), torus(8, 6), turned}) {
        PreparedMesh prepared(mesh);
        try {
            prepared.parametrization();
            ADD_FAILURE() << mesh.face_count() << " faces";
        } catch (const InvalidInput& error) {
            EXPECT_EQ(error.what(), closed_genus_zero_error(prepared.report()));
        }
        EXPECT_FALSE(prepared.set_parametrization(mesh.positions)) << mesh.face_count() << " faces";
    }
}

TEST(Segment, BadOptionsAreErrorsAndALaterCallWorks) {
    PreparedMesh prepared(octahedron());
    SegmentOptions options = all_pairs_options(9);
    expect_error<InvalidOptions>(prepared, options, "[1, 8]");
    options.submesh_count = -1;
    expect_error<InvalidOptions>(prepared, options, "found -1");
    options = all_pairs_options(2);
    options.triangles_per_submesh = -3;
    expect_error<InvalidOptions>(prepared, options, "triangles_per_submesh");
    options = all_pairs_options(2);
    options.thread_count = -1;
    expect_error<InvalidOptions>(prepared, options, "thread_count must be 0 or more, found -1.");
    options = all_pairs_options(2);
    options.max_cohesion_iterations = -1;
    expect_error<InvalidOptions>(prepared, options, "max_cohesion_iterations");
    options = all_pairs_options(2);
    options.max_refinement_iterations = -1;
    expect_error<InvalidOptions>(prepared, options, "max_refinement_iterations");
    for (double limit : {-1.0, std::nan("")}) {
        options = all_pairs_options(2);
        options.time_limit_seconds = limit;
        expect_error<InvalidOptions>(prepared, options, "time_limit_seconds");
    }
    EXPECT_EQ(segment(prepared, all_pairs_options(2)).labels.size(), 8u);
}

TEST(Segment, MeshesThatAreNotClosedGenusZeroAreErrors) {
    TriangleMesh two = tetrahedron();
    append(two, tetrahedron());
    const std::vector<std::pair<TriangleMesh, std::string>> cases = {
        {{}, "no faces"},
        {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}, "open border"},
        {open_grid(3), "open border"},
        {torus(6, 6), "genus 1"},
        {two, "2 components"}};
    for (const auto& [mesh, part] : cases) {
        PreparedMesh prepared(mesh);
        expect_error<InvalidInput>(prepared, all_pairs_options(1), part);
    }
}

} // namespace
} // namespace spheroseg
