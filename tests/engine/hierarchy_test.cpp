// SPDX-License-Identifier: GPL-3.0-or-later
#include "hierarchy.h"

#include "component.h"
#include "errors.h"
#include "patchwork_meshes.h"
#include "replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
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

void expect_faces(const test::Replay& undone, const TriangleMesh& mesh) {
    for (int f = 0; f < mesh.face_count(); ++f) {
        EXPECT_EQ(test::Replay::rotated(undone.faces()[f]), test::Replay::rotated(mesh.faces[f]));
    }
}

/// The steps undone one by one, from the last one on.
void expect_undone_to(const TriangleMesh& mesh, const CollapseHierarchy& hierarchy) {
    test::Replay replay(hierarchy, mesh.face_count());
    for (int i = hierarchy.step_count() - 1; i >= 0; --i) {
        ASSERT_NO_FATAL_FAILURE(replay.undo(i));
    }
    expect_faces(replay, mesh);
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
    expect_undone_to(mesh, hierarchy_of(mesh));
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
    // A flipped edge, so that it is no subdivision.
    for (const TriangleMesh& mesh :
         {test::flipped_sphere(5, 1), test::icosahedron(), test::torus(90, 31)}) {
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        ASSERT_TRUE(hierarchy.quartered_rounds.empty());
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

/// The mesh with its vertices, its faces and their corners in another order; `face_at[i]` is the
/// face that became face i.
TriangleMesh
shuffled(const TriangleMesh& mesh, std::vector<int>& face_at, std::vector<int>& new_vertex) {
    Random random(5);
    const auto permutation = [&](int count) {
        std::vector<int> order(count);
        std::iota(order.begin(), order.end(), 0);
        for (int i = count - 1; i > 0; --i) {
            std::swap(order[i], order[random.below(i + 1)]);
        }
        return order;
    };
    new_vertex = permutation(mesh.vertex_count());
    face_at = permutation(mesh.face_count());
    TriangleMesh result{mesh.positions, {}};
    for (int f : face_at) {
        Triangle t = mesh.faces[f];
        std::rotate(t.begin(), t.begin() + random.below(3), t.end());
        result.faces.push_back({new_vertex[t[0]], new_vertex[t[1]], new_vertex[t[2]]});
    }
    return result;
}

std::set<Triangle> set_of_faces(const TriangleMesh& mesh) {
    std::set<Triangle> faces;
    for (const Triangle& t : mesh.faces) {
        faces.insert(test::Replay::rotated(t));
    }
    return faces;
}

/// Of each face, once the collapses from round `round` on are undone, the input faces that it
/// stands for: those whose place others took, one after the other.
std::map<int, std::set<int>>
clusters_at(const CollapseHierarchy& hierarchy, int face_count, int round) {
    std::vector<int> heir(face_count);
    std::iota(heir.begin(), heir.end(), 0);
    for (int i = hierarchy.round_begin[round] - 1; i >= 0; --i) {
        const int* const begin = &hierarchy.star_faces[hierarchy.star_begin[i]];
        const int* const end = &hierarchy.star_faces[0] + hierarchy.star_begin[i + 1];
        if (begin[0] < face_count) {
            heir[begin[0]] = heir[begin[1]];
        }
        if (end[-1] < face_count) {
            heir[end[-1]] = heir[end[-2]];
        }
    }
    std::map<int, std::set<int>> clusters;
    for (int f = 0; f < face_count; ++f) {
        clusters[heir[f]].insert(f);
    }
    return clusters;
}

TEST(Hierarchy, UndoesSubdivisions) {
    // None of them is a subdivision itself.
    for (const TriangleMesh& base : {test::flipped_sphere(3, 1000),
                                     test::slivers(40),
                                     test::limbed_figure(0),
                                     test::bipyramid(9),
                                     test::bipyramid(300),
                                     test::open_grid(7),
                                     test::grid_with_holes(9),
                                     test::pinholed(test::flipped_sphere(3, 500), 30),
                                     test::sieve(test::flipped_sphere(3, 500), 0.05, 1)}) {
        EXPECT_TRUE(hierarchy_of(base).quartered_rounds.empty());
        const TriangleMesh once = test::subdivide(base);
        std::vector<int> face_at;
        std::vector<int> new_vertex;
        const TriangleMesh mesh = shuffled(test::subdivide(once), face_at, new_vertex);
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        ASSERT_EQ(hierarchy.quartered_rounds.size(), 2u);

        test::Replay replay(hierarchy, mesh.face_count());
        int step = hierarchy.step_count();
        for (int undone : {1, 0}) {
            // Descendants of a face follow one another.
            const int size = undone == 1 ? 16 : 4;
            const int round = hierarchy.quartered_rounds[undone];
            while (step > hierarchy.round_begin[round]) {
                ASSERT_NO_FATAL_FAILURE(replay.undo(--step));
            }
            TriangleMesh expected = undone == 1 ? base : once;
            for (Triangle& t : expected.faces) {
                t = {new_vertex[t[0]], new_vertex[t[1]], new_vertex[t[2]]};
            }
            EXPECT_EQ(set_of_faces(replay.living_mesh(mesh.vertex_count())),
                      set_of_faces(expected));
            const auto clusters = clusters_at(hierarchy, mesh.face_count(), round);
            EXPECT_EQ(static_cast<int>(clusters.size()), expected.face_count());
            for (const auto& [face, cluster] : clusters) {
                EXPECT_EQ(static_cast<int>(cluster.size()), size);
                for (int f : cluster) {
                    EXPECT_EQ(face_at[f] / size, face_at[face] / size);
                }
            }
        }
        while (step > 0) {
            ASSERT_NO_FATAL_FAILURE(replay.undo(--step));
        }
        expect_faces(replay, mesh);
    }
}

TEST(Hierarchy, UndoesASubdivisionThatCanBeOneInSeveralWays) {
    // No vertex tells which ones are new.
    const TriangleMesh mesh = test::torus(44, 28);
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    ASSERT_EQ(hierarchy.quartered_rounds.size(), 2u);
    const auto clusters = clusters_at(hierarchy, mesh.face_count(), hierarchy.quartered_rounds[1]);
    EXPECT_EQ(clusters.size(), mesh.faces.size() / 16);
    for (const auto& [face, cluster] : clusters) {
        EXPECT_EQ(cluster.size(), 16u);
    }
}

TEST(Hierarchy, ASubdivisionIsNotWhatIsNearlyOne) {
    const TriangleMesh whole = test::subdivide(test::flipped_sphere(2, 200));
    ASSERT_EQ(hierarchy_of(whole).quartered_rounds.size(), 1u);
    // A face missing; as many faces as some subdivision has.
    for (int f = 0; f < 8; ++f) {
        TriangleMesh mesh = whole;
        mesh.faces.erase(mesh.faces.begin() + f);
        EXPECT_TRUE(hierarchy_of(mesh).quartered_rounds.empty());
        mesh.faces.push_back({mesh.faces[9][0], mesh.faces[9][1], mesh.vertex_count()});
        mesh.faces.push_back({mesh.faces[9][1], mesh.faces[9][2], mesh.vertex_count()});
        mesh.faces[9] = {mesh.faces[9][2], mesh.faces[9][0], mesh.vertex_count()};
        mesh.positions.push_back({0, 0, 0});
        mesh.faces.erase(mesh.faces.begin() + 100);
        EXPECT_EQ(mesh.face_count() % 4, 0);
        EXPECT_TRUE(hierarchy_of(mesh).quartered_rounds.empty());
    }
    const TriangleMesh sphere = test::icosphere(3);
    for (std::uint64_t seed = 1; seed < 20; ++seed) {
        EXPECT_TRUE(hierarchy_of(test::flipped_sphere(3, 1, seed)).quartered_rounds.empty());
    }
    EXPECT_EQ(hierarchy_of(sphere).quartered_rounds.size(), 3u);
    TriangleMesh two = sphere;
    test::append(two, sphere);
    EXPECT_TRUE(hierarchy_of(two).quartered_rounds.empty()) << "of one component only";
}

TEST(Hierarchy, MeshesThatTouchAtVerticesOnlyAreNoSubdivision) {
    // Two squares that share a corner, each split.
    TriangleMesh mesh = test::open_grid(2);
    mesh.faces = {mesh.faces[0], mesh.faces[1], mesh.faces[6], mesh.faces[7]};
    EXPECT_TRUE(hierarchy_of(test::subdivide(mesh)).quartered_rounds.empty());
}

TEST(Hierarchy, ASubdivisionOfWhatIsNoMeshEndsAtATetrahedronToo) {
    // Vertices 0 and 1 are joined by two edges, on which 6 and 7 lie.
    TriangleMesh mesh;
    mesh.positions.resize(18);
    const auto split = [&](const Triangle& t, int ab, int bc, int ca) {
        mesh.faces.insert(mesh.faces.end(),
                          {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    };
    split({0, 1, 2}, 6, 9, 8);
    split({0, 2, 3}, 8, 12, 10);
    split({2, 1, 3}, 9, 11, 12);
    split({0, 3, 1}, 10, 11, 7);
    split({1, 0, 4}, 6, 13, 14);
    split({4, 0, 5}, 13, 15, 17);
    split({1, 4, 5}, 14, 17, 16);
    split({0, 1, 5}, 7, 16, 15);
    expect_closed_surface(mesh);
    const CollapseHierarchy hierarchy = hierarchy_of(mesh);
    EXPECT_TRUE(hierarchy.quartered_rounds.empty());
    EXPECT_EQ(hierarchy.base_faces.size(), 4u);
    expect_undone_to(mesh, hierarchy);
}

TEST(Hierarchy, FixedVerticesEndASubdivision) {
    // Along the seam of the strip faces are turned, so that its vertices stay.
    for (const TriangleMesh& mesh :
         {test::subdivide(test::moebius_strip(9, 3)), test::moebius_strip(12, 4)}) {
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        EXPECT_TRUE(hierarchy.quartered_rounds.empty());
        expect_undone_to(mesh, hierarchy);
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

/// Euler characteristic and border edges, however faces are oriented. Fails the test where an edge
/// has more than two faces, or a vertex one border edge or more than two.
std::pair<int, int> unoriented_topology_of(const TriangleMesh& mesh) {
    std::map<std::pair<int, int>, int> edges;
    std::map<int, int> border_degrees;
    for (const Triangle& t : mesh.faces) {
        for (int c = 0; c < 3; ++c) {
            border_degrees[t[c]] = 0;
            ++edges[std::minmax(t[c], t[(c + 1) % 3])];
        }
    }
    int border_edges = 0;
    for (const auto& [edge, faces] : edges) {
        EXPECT_LE(faces, 2);
        if (faces == 1) {
            ++border_edges;
            ++border_degrees[edge.first];
            ++border_degrees[edge.second];
        }
    }
    for (const auto& [vertex, degree] : border_degrees) {
        EXPECT_TRUE(degree == 0 || degree == 2) << vertex;
    }
    const auto vertices = static_cast<int>(border_degrees.size());
    return {vertices - static_cast<int>(edges.size()) + mesh.face_count(), border_edges};
}

TEST(Hierarchy, ShortensBordersAlongWhichFacesAreTurned) {
    struct Case {
        TriangleMesh mesh;
        int euler;
        int most_left;
    };
    // The vertices of the seam stay; and those of the faces that are turned, three for each.
    for (const auto& [mesh, euler, most_left] :
         {Case{test::moebius_strip(60, 5), 0, 40},
          Case{test::moebius_strip(300, 1), 0, 12},
          Case{test::subdivide(test::moebius_strip(100, 1)), 0, 20},
          Case{test::with_turned_faces(test::open_grid(20), 79), 1, 150}}) {
        const CollapseHierarchy hierarchy = hierarchy_of(mesh);
        test::Replay replay(hierarchy, mesh.face_count());
        EXPECT_LE(replay.living_mesh(mesh.vertex_count()).face_count(), most_left);
        int border = 3;
        for (int r = hierarchy.round_count(); r >= 0; --r) {
            const TriangleMesh left = replay.living_mesh(mesh.vertex_count());
            const auto [left_euler, left_border] = unoriented_topology_of(left);
            EXPECT_EQ(left_euler, euler);
            EXPECT_GE(left_border, border);
            border = left_border;
            for (int i = hierarchy.round_begin[r] - 1; r > 0 && i >= hierarchy.round_begin[r - 1];
                 --i) {
                ASSERT_NO_FATAL_FAILURE(replay.undo(i));
            }
        }
        expect_faces(replay, mesh);
        const CollapseHierarchy again = hierarchy_of(mesh, 1);
        EXPECT_EQ(again.vertex, hierarchy.vertex);
        EXPECT_EQ(again.star_faces, hierarchy.star_faces);
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
