// SPDX-License-Identifier: GPL-3.0-or-later
#include "refining_mesh.h"

#include "test_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

/// The faces that are there, with the adjacency that the mesh keeps, both by place in `index`.
struct Snapshot {
    TriangleMesh mesh;
    std::vector<std::array<int, 3>> neighbors;
};

Snapshot snapshot_of(const RefiningMesh& refining, int vertex_count) {
    Snapshot snapshot;
    snapshot.mesh.positions.resize(vertex_count);
    std::vector<int> place(refining.faces().size(), -1);
    for (std::size_t f = 0; f < place.size(); ++f) {
        if (refining.faces()[f].vertices[0] >= 0) {
            place[f] = snapshot.mesh.face_count();
            snapshot.mesh.faces.push_back(refining.faces()[f].vertices);
        }
    }
    for (const RefiningMesh::Face& face : refining.faces()) {
        if (face.vertices[0] >= 0) {
            const auto& n = face.neighbors;
            snapshot.neighbors.push_back({place[n[0]], place[n[1]], place[n[2]]});
        }
    }
    return snapshot;
}

void expect_stars_are_whole(const RefiningMesh& refining, const TriangleMesh& level) {
    std::vector<int> face_counts(level.vertex_count(), 0);
    for (const Triangle& t : level.faces) {
        for (int v : t) {
            ++face_counts[v];
        }
    }
    for (int v = 0; v < level.vertex_count(); ++v) {
        EXPECT_EQ(refining.degree(v), face_counts[v]);
        if (face_counts[v] > 0) {
            int visited = 0;
            refining.for_each_in_star(v, [&](int, int) { ++visited; });
            EXPECT_EQ(visited, face_counts[v]);
        }
    }
}

TEST(RefiningMesh, KeepsTheDualGraphAtEveryLevelAndEndsAtTheInput) {
    for (const auto& [name, mesh] : test::genus_zero_meshes()) {
        SCOPED_TRACE(name);
        const DualGraph dual_graph = build_dual_graph(mesh, 1);
        const CollapseHierarchy hierarchy = build_hierarchy(mesh, dual_graph, 1);
        RefiningMesh refining(hierarchy, mesh.face_count(), mesh.vertex_count());
        while (true) {
            const Snapshot level = snapshot_of(refining, mesh.vertex_count());
            EXPECT_EQ(level.mesh.face_count(), refining.live_face_count());
            EXPECT_EQ(level.neighbors, build_dual_graph(level.mesh, 1).neighbors);
            expect_stars_are_whole(refining, level.mesh);
            if (refining.round() == 0) {
                break;
            }
            refining.undo_round(2);
        }
        EXPECT_EQ(refining.live_face_count(), mesh.face_count());
        for (int f = 0; f < mesh.face_count(); ++f) {
            Triangle t = refining.faces()[f].vertices;
            std::rotate(t.begin(), std::find(t.begin(), t.end(), mesh.faces[f][0]), t.end());
            EXPECT_EQ(t, mesh.faces[f]);
        }
    }
}

} // namespace
} // namespace spheroseg
