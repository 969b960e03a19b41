// SPDX-License-Identifier: GPL-3.0-or-later
// Every parallel region of the engine on a mesh that is large enough for it: in a build with the
// thread sanitizer (preset "thread") this finds races, in any build differences.
#include "bisection.h"
#include "multilevel.h"
#include "relaxation.h"
#include "segment.h"

#include "../engine/test_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

constexpr int kThreads = 4;

/// 20,480 faces: all_pairs has enough pairs for two threads, and coarse levels for parallel rounds.
const TriangleMesh& large_mesh() {
    static const TriangleMesh mesh = limbed_figure(5, 2.0);
    return mesh;
}

void expect_same_labels(SegmentOptions options, const TriangleMesh& mesh = large_mesh()) {
    options.thread_count = 1;
    PreparedMesh alone(mesh, 1);
    const std::vector<int> expected = segment(alone, options).labels;
    options.thread_count = kThreads;
    PreparedMesh together(mesh, kThreads);
    EXPECT_EQ(segment(together, options).labels, expected);
}

SegmentOptions short_options(int submesh_count) {
    SegmentOptions options;
    options.submesh_count = submesh_count;
    options.max_cohesion_iterations = 1;
    return options;
}

TEST(AllThreads, FastFromACoarseStart) {
    SegmentOptions options = short_options(60);
    options.effort = Effort::draft;
    expect_same_labels(options);
}

TEST(AllThreads, FastFromTrials) {
    SegmentOptions options;
    options.submesh_count = 20;
    options.effort = Effort::draft;
    expect_same_labels(options);
}

TEST(AllThreads, FastAmongHoles) {
    SegmentOptions options = short_options(60);
    options.effort = Effort::draft;
    expect_same_labels(options, pinholed(large_mesh(), 20));
}

// Two vertices that all groups of sub-meshes share.
TEST(AllThreads, FastAroundHubs) {
    SegmentOptions options = short_options(2000);
    options.effort = Effort::draft;
    expect_same_labels(options, bipyramid(4000));
}

TEST(AllThreads, FastOfManySubmeshes) {
    SegmentOptions options = short_options(1000);
    options.max_refinement_iterations = 20;
    expect_same_labels(options);
}

TEST(AllThreads, FastFromTheSphere) {
    SegmentOptions options = short_options(100);
    options.effort = Effort::high;
    options.max_refinement_iterations = 1;
    expect_same_labels(options);
}

TEST(AllThreads, RelaxationOfManyFaces) {
    const TriangleMesh mesh = limbed_figure(6, 2.0); // 81,920 faces, enough for two threads
    const DualGraph dual_graph = build_dual_graph(mesh, kThreads);
    const Multilevel finest(mesh, dual_graph, kThreads);
    Patchwork alone = finest.coarsen(mesh.face_count(), 300, kThreads);
    bisect(alone, 300, 1, kThreads);
    Patchwork together = alone;
    relax(alone, 2, 1, {});
    relax(together, 2, kThreads, {});
    EXPECT_EQ(cell_labels(together), cell_labels(alone));
}

TEST(AllThreads, AllPairs) {
    SegmentOptions options = short_options(100);
    options.method = Method::all_pairs;
    options.max_refinement_iterations = 1;
    expect_same_labels(options);
}

} // namespace
} // namespace spheroseg
