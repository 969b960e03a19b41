// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

TEST(Relaxation, EvensLoadsAndShortensTheBoundary) {
    const Levels levels(displaced_sphere(4));
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 40);
    bisect(patchwork, 40, 0, 1);
    const int before = measures_of(levels, patchwork).boundary_edge_count;
    relax(patchwork, 30, 1, {});
    const Measures relaxed = measures_of(levels, patchwork);
    EXPECT_LT(relaxed.boundary_edge_count, 0.85 * before);
    EXPECT_GE(relaxed.min_submesh_triangles, 1);
    EXPECT_LT(relaxed.max_submesh_triangles, 2 * levels.mesh.face_count() / 40);
}

TEST(Relaxation, DoesNotDependOnThreadsAndKeepsPiecesConnected) {
    // Large enough for several threads.
    const Levels levels(displaced_sphere(6));
    Patchwork start = levels.multilevel.coarsen(levels.mesh.face_count(), 300);
    bisect(start, 300, 1, 1);
    std::vector<int> reference;
    for (int threads : {1, 2, 5}) {
        Patchwork patchwork = start;
        relax(patchwork, 12, threads, {});
        const Measures relaxed = measures_of(levels, patchwork);
        EXPECT_EQ(relaxed.disconnected_submesh_count, 0);
        EXPECT_EQ(patchwork.load, relaxed.submesh_triangles);
        const std::vector<int> labels = levels.multilevel.labels(patchwork);
        if (reference.empty()) {
            reference = labels;
        }
        EXPECT_EQ(labels, reference) << threads << " threads";
    }
}

} // namespace
} // namespace spheroseg
