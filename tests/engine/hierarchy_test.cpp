// SPDX-License-Identifier: GPL-3.0-or-later
#include "hierarchy.h"

#include "component.h"
#include "errors.h"
#include "patchwork_meshes.h"
#include "replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace spheroseg {
namespace {

CollapseHierarchy hierarchy_of(const TriangleMesh& mesh, int thread_count = 2) {
    return build_hierarchy(mesh, build_dual_graph(mesh, 1), thread_count);
}

/// What collapses must not change, counted: Euler characteristic and border loops. Fails the test
/// where a vertex has more than one gap or two edges join the same vertices.
struct Topology {
    int euler = 0;
    int loops = 0;
};

Topology topology_of(const TriangleMesh& mesh) {
    std::set<std::pair<int, int>> sides;
    std::set<int> vertices;
    for (const Triangle& t : mesh.faces) {
        for (int c = 0; c < 3; ++c) {
            vertices.insert(t[c]);
            EXPECT_TRUE(sides.insert({t[c], t[(c + 1) % 3]}).second);
        }
    }
    std::map<int, int> next;
    for (const auto& [a, b] : sides) {
        if (sides.count({b, a}) == 0) {
            EXPECT_TRUE(next.insert({a, b}).second) << "vertex " << a << " has two gaps";
        }
    }
    const auto edges = (sides.size() + next.size()) / 2;
    Topology topology;
    topology.euler =
        static_cast<int>(vertices.size()) - static_cast<int>(edges) + mesh.face_count();
    while (!next.empty()) {
        ++topology.loops;
        for (auto at = next.begin(); at != next.end();) {
            const int to = at->second;
            next.erase(at);
            at = next.find(to);
        }
    }
    return topology;
}

/// Every side of every face has one opposite side, no two edges join the same two vertices, and
/// V - E + F = 2: a triangulated sphere when connected.
void expect_closed_surface(const TriangleMesh& mesh) {
    const Topology topology = topology_of(mesh);
    EXPECT_EQ(topology.loops, 0);
    EXPECT_EQ(topology.euler, 2);
    for (const auto& neighbors : build_dual_graph(mesh, 1).neighbors) {
        EXPECT_TRUE(neighbors[0] >= 0 && neighbors[1] >= 0 && neighbors[2] >= 0);
    }
}

class HierarchyOfEachMesh : public testing::TestWithParam<test::MeshRecipe> {};

TEST_P(HierarchyOfEachMesh, EndsAtATetrahedron) {
    const TriangleMesh mesh = GetParam().make();
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    EXPECT_EQ(hierarchy.base_faces.size(), 4u);
    EXPECT_EQ(hierarchy.step_count(), (mesh.face_count() - 4) / 2);
    std::set<int> left;
    for (const Triangle& t : hierarchy.base_triangles) {
        left.insert(t.begin(), t.end());
    }
    EXPECT_EQ(left.size(), 4u);
    for (int v : hierarchy.vertex) {
        EXPECT_TRUE(left.insert(v).second) << "vertex " << v << " is removed twice or never";
    }
    EXPECT_EQ(static_cast<int>(left.size()), mesh.vertex_count());
}

TEST_P(HierarchyOfEachMesh, UndoneBackwardsGivesTheInputFaces) {
    const TriangleMesh mesh = GetParam().make();
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    test::Replay replay(hierarchy, mesh.face_count());
    for (int i = hierarchy.step_count() - 1; i >= 0; --i) {
        replay.undo(i);
        ASSERT_FALSE(HasFatalFailure());
    }
    for (int f = 0; f < mesh.face_count(); ++f) {
        EXPECT_EQ(test::Replay::rotated(replay.faces()[f]), test::Replay::rotated(mesh.faces[f]));
    }
}

TEST_P(HierarchyOfEachMesh, IsASphereAfterEveryRound) {
    const TriangleMesh mesh = GetParam().make();
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    test::Replay replay(hierarchy, mesh.face_count());
    for (int r = hierarchy.round_count() - 1; r >= 0; --r) {
        expect_closed_surface(replay.living_mesh(mesh.vertex_count()));
        for (int i = hierarchy.round_begin[r + 1] - 1; i >= hierarchy.round_begin[r]; --i) {
            replay.undo(i);
        }
    }
}

TEST_P(HierarchyOfEachMesh, RoundsAreIndependent) {
    const TriangleMesh mesh = GetParam().make();
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    EXPECT_EQ(hierarchy.round_begin.back(), hierarchy.step_count());
    for (int r = 0; r < hierarchy.round_count(); ++r) {
        const int begin = hierarchy.round_begin[r];
        const int end = hierarchy.round_begin[r + 1];
        ASSERT_LT(begin, end);
        const std::set<int> removed(&hierarchy.vertex[begin],
                                    &hierarchy.vertex[begin] + end - begin);
        std::set<int> star_faces;
        for (int j = hierarchy.star_begin[begin]; j < hierarchy.star_begin[end]; ++j) {
            EXPECT_TRUE(star_faces.insert(hierarchy.star_faces[j]).second);
            EXPECT_EQ(removed.count(hierarchy.ring_vertices[j]), 0u);
        }
    }
}

TEST_P(HierarchyOfEachMesh, IsTheSameForOneAndThreeThreads) {
    const TriangleMesh mesh = GetParam().make();
    const CollapseHierarchy one = hierarchy_of(mesh, 1);
    const CollapseHierarchy three = hierarchy_of(mesh, 3);
    EXPECT_EQ(one.vertex, three.vertex);
    EXPECT_EQ(one.target, three.target);
    EXPECT_EQ(one.star_begin, three.star_begin);
    EXPECT_EQ(one.ring_vertices, three.ring_vertices);
    EXPECT_EQ(one.star_faces, three.star_faces);
    EXPECT_EQ(one.round_begin, three.round_begin);
    EXPECT_EQ(one.base_faces, three.base_faces);
    EXPECT_EQ(one.base_triangles, three.base_triangles);
}

INSTANTIATE_TEST_SUITE_P(GenusZero,
                         HierarchyOfEachMesh,
                         testing::ValuesIn(test::genus_zero_recipes()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Hierarchy, RoundsRemoveATenthOfTheVerticesAndDegreesStaySmall) {
    for (const TriangleMesh& mesh : {test::icosphere(5), test::limbed_figure(5)}) {
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        int left = mesh.vertex_count();
        for (int r = 0; r < hierarchy.round_count() && left > 100; ++r) {
            const int removed = hierarchy.round_begin[r + 1] - hierarchy.round_begin[r];
            EXPECT_GE(removed, left / 10);
            left -= removed;
        }
        for (int i = 0; i < hierarchy.step_count(); ++i) {
            EXPECT_LE(hierarchy.star_begin[i + 1] - hierarchy.star_begin[i], 8);
        }
    }
}

void expect_faces(const test::Replay& undone, const TriangleMesh& mesh) {
    for (int f = 0; f < mesh.face_count(); ++f) {
        EXPECT_EQ(test::Replay::rotated(undone.faces()[f]), test::Replay::rotated(mesh.faces[f]));
    }
}

std::set<int> border_vertices(const TriangleMesh& mesh) {
    const DualGraph graph = build_dual_graph(mesh, 1);
    std::set<int> on_border;
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (graph.neighbors[f][c] < 0) {
                on_border.insert({mesh.faces[f][c], mesh.faces[f][(c + 1) % 3]});
            }
        }
    }
    return on_border;
}

TEST(Hierarchy, ShortensBordersThenClosesHoles) {
    for (const TriangleMesh& mesh : {test::open_grid(20),
                                     test::grid_with_holes(24),
                                     test::grid_with_holes(27),
                                     test::pinholed(test::icosphere(4), 30)}) {
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        const Topology expected = topology_of(mesh);
        EXPECT_EQ(expected.euler, 2 - expected.loops);
        test::Replay replay(hierarchy, mesh.face_count());
        EXPECT_LE(replay.living_mesh(mesh.vertex_count()).face_count(), 4);
        int loops = 0;
        for (int r = hierarchy.round_count() - 1; r >= 0; --r) {
            const TriangleMesh left = replay.living_mesh(mesh.vertex_count());
            const Topology coarse = topology_of(left);
            EXPECT_EQ(coarse.euler, 2 - coarse.loops);
            EXPECT_GE(coarse.loops, loops);
            loops = coarse.loops;
            EXPECT_EQ(faces_of_components(build_dual_graph(left, 1)).size(), 1u);
            for (int i = hierarchy.round_begin[r + 1] - 1; i >= hierarchy.round_begin[r]; --i) {
                ASSERT_NO_FATAL_FAILURE(replay.undo(i));
            }
            const std::set<int> on_border =
                border_vertices(replay.living_mesh(mesh.vertex_count()));
            for (int i = hierarchy.round_begin[r]; i < hierarchy.round_begin[r + 1]; ++i) {
                EXPECT_TRUE(on_border.count(hierarchy.vertex[i]) == 0 ||
                            on_border.count(hierarchy.target[i]) == 1);
            }
        }
        EXPECT_LE(loops, expected.loops);
        expect_faces(replay, mesh);
    }
}

TEST(Hierarchy, OfMeshesWhoseFacesMoveTogetherIsUndoneToTheInput) {
    // From 8,192 faces on, live faces get other numbers inside; twice here, also beside caps.
    for (const TriangleMesh& mesh : {test::displaced_sphere(5),
                                     test::flipped_sphere(5, 100000),
                                     test::grid_with_holes(110),
                                     test::pinholed(test::icosphere(5), 30)}) {
        ASSERT_GE(mesh.face_count(), 2 * 8192);
        const DualGraph dual_graph = build_dual_graph(mesh, 1);
        const CollapseHierarchy hierarchy = build_hierarchy(mesh, dual_graph, 1);
        test::Replay replay(hierarchy, mesh.face_count());
        EXPECT_LE(replay.living_mesh(mesh.vertex_count()).face_count(), 4);
        for (int i = hierarchy.step_count() - 1; i >= 0; --i) {
            ASSERT_NO_FATAL_FAILURE(replay.undo(i));
        }
        expect_faces(replay, mesh);
        const CollapseHierarchy again = build_hierarchy(mesh, dual_graph, 3);
        EXPECT_EQ(again.vertex, hierarchy.vertex);
        EXPECT_EQ(again.target, hierarchy.target);
        EXPECT_EQ(again.ring_vertices, hierarchy.ring_vertices);
        EXPECT_EQ(again.star_faces, hierarchy.star_faces);
        EXPECT_EQ(again.base_triangles, hierarchy.base_triangles);
    }
}

TEST(Hierarchy, ClosesHolesLate) {
    // While they are few they hinder nothing.
    const TriangleMesh mesh = test::pinholed(test::icosphere(5), 1000);
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    const int holes = topology_of(mesh).loops;
    EXPECT_EQ(holes, 20);
    test::Replay replay(hierarchy, mesh.face_count());
    for (int r = hierarchy.round_count() - 1; r >= 0; --r) {
        const TriangleMesh left = replay.living_mesh(mesh.vertex_count());
        if (left.face_count() > 100 * holes) {
            EXPECT_EQ(topology_of(left).loops, holes);
        }
        for (int i = hierarchy.round_begin[r + 1] - 1; i >= hierarchy.round_begin[r]; --i) {
            replay.undo(i);
        }
    }
}

TEST(Hierarchy, ClosesHolesThatTouchAtTheirCorners) {
    const TriangleMesh whole = test::flipped_sphere(4, 3000);
    for (double share : {0.05, 0.15, 0.3}) {
        const TriangleMesh mesh = test::sieve(whole, share, 3);
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        test::Replay replay(hierarchy, mesh.face_count());
        EXPECT_LE(replay.living_mesh(mesh.vertex_count()).face_count(), 4);
        for (int i = hierarchy.step_count() - 1; i >= 0; --i) {
            ASSERT_NO_FATAL_FAILURE(replay.undo(i));
        }
        expect_faces(replay, mesh);
    }
}

TEST(Hierarchy, KeepsAVertexWhereComponentsTouch) {
    // Two squares that share a corner.
    TriangleMesh mesh = test::open_grid(2);
    mesh.faces = {mesh.faces[0], mesh.faces[1], mesh.faces[6], mesh.faces[7]};
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    test::Replay replay(hierarchy, mesh.face_count());
    for (int i = hierarchy.step_count() - 1; i >= 0; --i) {
        EXPECT_NE(hierarchy.vertex[i], 4);
        ASSERT_NO_FATAL_FAILURE(replay.undo(i));
    }
    expect_faces(replay, mesh);
}

TEST(Hierarchy, KeepsVerticesOfEdgesWithMoreThanTwoFaces) {
    TriangleMesh mesh;
    mesh.positions.resize(4);
    mesh.faces = {{0, 2, 3}, {0, 1, 3}, {2, 1, 0}, {2, 3, 0}, {2, 3, 1}};
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    for (int v : hierarchy.vertex) {
        EXPECT_TRUE(v == 1 || v >= mesh.vertex_count()) << v;
    }
}

TEST(Hierarchy, StopsOnATorusUnderTheLinkCondition) {
    const TriangleMesh mesh = test::torus(24, 16);
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    test::Replay replay(hierarchy, mesh.face_count());
    const TriangleMesh base = replay.living_mesh(mesh.vertex_count());
    EXPECT_LT(base.face_count(), 40);
    EXPECT_GE(base.face_count(), 14) << "no torus has fewer faces";
    std::set<int> vertices;
    for (const Triangle& t : base.faces) {
        vertices.insert(t.begin(), t.end());
    }
    EXPECT_EQ(static_cast<int>(vertices.size()) - base.face_count() / 2, 0);
}

TEST(Hierarchy, LeavesATetrahedronOfEachComponent) {
    TriangleMesh mesh;
    for (const auto& [name, part] : test::genus_zero_meshes()) {
        test::append(mesh, part);
    }
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    EXPECT_EQ(hierarchy.base_faces.size(), 4 * test::genus_zero_meshes().size());
}

TEST(Hierarchy, IgnoresUnreferencedVerticesAndAcceptsNoFaces) {
    TriangleMesh mesh = test::icosphere(2);
    mesh.positions.insert(mesh.positions.begin(), 5, Vec3{9, 9, 9});
    for (Triangle& t : mesh.faces) {
        t = {t[0] + 5, t[1] + 5, t[2] + 5};
    }
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    EXPECT_EQ(hierarchy.base_faces.size(), 4u);
    EXPECT_TRUE(std::all_of(
        hierarchy.vertex.begin(), hierarchy.vertex.end(), [](int v) { return v >= 5; }));
    EXPECT_EQ(hierarchy_of({}).round_count(), 0);
}

TEST(Hierarchy, ReportsRisingProgressAndCanBeCancelled) {
    for (const TriangleMesh& mesh : {test::icosphere(3), test::open_grid(20)}) {
        const DualGraph dual_graph = build_dual_graph(mesh, 1);
        double last = 0.0;
        build_hierarchy(mesh, dual_graph, 1, [&](double fraction, const char*) {
            EXPECT_GE(fraction, last);
            EXPECT_LE(fraction, 1.0);
            last = fraction;
            return true;
        });
        EXPECT_GT(last, 0.9);
        EXPECT_THROW(
            build_hierarchy(mesh, dual_graph, 1, [](double, const char*) { return false; }),
            Cancelled);
    }
}

} // namespace
} // namespace spheroseg
