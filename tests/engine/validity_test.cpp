// SPDX-License-Identifier: GPL-3.0-or-later
#include "validity.h"

#include "errors.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace spheroseg {
namespace {

using namespace test;

MeshReport report_of(const TriangleMesh& mesh) {
    return inspect(mesh, build_dual_graph(mesh));
}

/// The message has these parts, and the mesh is refused.
void expect_defect(const MeshReport& report, const std::string& found, const std::string& cure) {
    EXPECT_FALSE(report.is_closed_genus_zero());
    const std::string message = closed_genus_zero_error(report);
    EXPECT_NE(message.find("found " + found), std::string::npos) << message;
    EXPECT_NE(message.find(cure), std::string::npos) << message;
}

TEST(Validity, ClosedGenusZeroMeshesPass) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        SCOPED_TRACE(name);
        const MeshReport r = report_of(mesh);
        EXPECT_TRUE(r.is_closed_genus_zero()) << closed_genus_zero_error(r);
        EXPECT_EQ(closed_genus_zero_error(r), "");
        EXPECT_EQ(r.euler_characteristic, 2);
        EXPECT_EQ(2 * r.edge_count, 3 * r.face_count);
        EXPECT_EQ(r.referenced_vertex_count, mesh.vertex_count());
    }
}

TEST(Validity, UnreferencedVerticesAreNoDefectEvenWhenNotFinite) {
    TriangleMesh mesh = tetrahedron();
    mesh.positions.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
    const MeshReport r = report_of(mesh);
    EXPECT_EQ(r.referenced_vertex_count, 4);
    EXPECT_TRUE(r.is_closed_genus_zero());
}

TEST(Validity, ZeroAreaFacesAreAllowed) {
    TriangleMesh mesh = octahedron();
    mesh.positions[4] = {1, 0, 0}; // where vertex 0 lies: faces 0 and 3 lose their area
    const MeshReport r = report_of(mesh);
    EXPECT_EQ(r.degenerate_face_count, 0);
    EXPECT_TRUE(r.is_closed_genus_zero());
}

TEST(Validity, NoFaces) {
    const MeshReport r = report_of({});
    EXPECT_EQ(r.component_count, 0);
    EXPECT_EQ(r.genus, -1);
    expect_defect(r, "no faces", "Load a triangle mesh");
}

TEST(Validity, OneFaceHasThreeOpenEdges) {
    const MeshReport r = report_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}});
    EXPECT_EQ(r.boundary_edge_count, 3);
    EXPECT_EQ(r.component_count, 1);
    EXPECT_EQ(r.euler_characteristic, 1);
    EXPECT_EQ(r.genus, -1);
    expect_defect(r, "3 open border edges (first: face 0)", "\"Close Holes\"");
}

TEST(Validity, OpenGridHasItsBorder) {
    const MeshReport r = report_of(open_grid(5));
    EXPECT_EQ(r.boundary_edge_count, 20);
    EXPECT_EQ(r.first_boundary_face, 0);
    EXPECT_EQ(r.edge_count, (3 * 50 + 20) / 2);
    EXPECT_EQ(r.non_manifold_vertex_count, 0);
}

TEST(Validity, TorusHasGenusOne) {
    const MeshReport r = report_of(torus(7, 5));
    EXPECT_EQ(r.genus, 1);
    EXPECT_EQ(r.euler_characteristic, 0);
    expect_defect(r, "genus 1", "\"Close Holes\"");
    expect_defect(r, "genus 1", "method \"fast\" takes this mesh");
    EXPECT_EQ(surface_error(r), "");
}

TEST(Validity, ComponentsAreCountedAndTheirGeneraAdded) {
    TriangleMesh mesh = tetrahedron();
    append(mesh, torus(4, 4));
    append(mesh, torus(4, 3));
    const MeshReport r = report_of(mesh);
    EXPECT_EQ(r.component_count, 3);
    EXPECT_EQ(r.genus, 2);
    expect_defect(r, "3 components", "\"Remove Isolated pieces (wrt Face Num.)\"");
}

TEST(Validity, AFinOnATetrahedronIsANonManifoldEdge) {
    const MeshReport r = report_of(tetrahedron_with_fin());
    EXPECT_EQ(r.non_manifold_edge_count, 1);
    EXPECT_EQ(r.first_non_manifold_face, 0);
    EXPECT_EQ(r.boundary_edge_count, 2);
    EXPECT_EQ(r.component_count, 1);
    EXPECT_EQ(r.edge_count, 8);
    EXPECT_EQ(r.non_manifold_vertex_count, 0);
    expect_defect(r, "1 edge with more than two faces", "\"Repair non Manifold Edges\"");
}

TEST(Validity, AReversedFaceHasThreeInconsistentEdgesAndNothingElse) {
    TriangleMesh mesh = octahedron();
    std::swap(mesh.faces[5][0], mesh.faces[5][1]);
    const MeshReport r = report_of(mesh);
    EXPECT_EQ(r.inconsistent_edge_count, 3);
    EXPECT_EQ(r.boundary_edge_count, 0);
    EXPECT_EQ(r.non_manifold_vertex_count, 0);
    EXPECT_EQ(r.component_count, 1);
    EXPECT_EQ(r.euler_characteristic, 2);
    expect_defect(r, "3 edges between faces of opposite", "\"Re-Orient all faces coherently\"");
}

TEST(Validity, TwoTetrahedraThatShareAVertexAreNotManifoldThere) {
    TriangleMesh mesh = tetrahedron();
    append(mesh, tetrahedron());
    for (Triangle& face : mesh.faces) {
        std::replace(face.begin(), face.end(), 5, 2);
    }
    const MeshReport r = report_of(mesh);
    EXPECT_EQ(r.non_manifold_vertex_count, 1);
    EXPECT_EQ(r.first_non_manifold_vertex, 2);
    EXPECT_EQ(r.referenced_vertex_count, 7);
    EXPECT_EQ(r.component_count, 2);
    expect_defect(
        r, "1 vertex where separate fans", "\"Repair non Manifold Vertices by splitting\"");
}

/// The lowest vertex with several fans, and how many there are: faces around a vertex are of one
/// fan when they share an edge there, however many others do.
std::pair<int, int> vertices_of_several_fans(const TriangleMesh& mesh) {
    std::vector<std::vector<int>> faces(mesh.positions.size());
    for (int f = 0; f < mesh.face_count(); ++f) {
        for (int v : mesh.faces[f]) {
            faces[v].push_back(f);
        }
    }
    std::pair<int, int> found = {-1, 0};
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        std::vector<int> left = faces[v];
        std::vector<int> fan;
        const auto meets_fan = [&](int f) {
            return std::any_of(fan.begin(), fan.end(), [&](int g) {
                const Triangle& other = mesh.faces[g];
                return std::count_if(mesh.faces[f].begin(), mesh.faces[f].end(), [&](int w) {
                           return std::find(other.begin(), other.end(), w) != other.end();
                       }) > 1;
            });
        };
        if (!left.empty()) {
            fan.push_back(left.back());
            left.pop_back();
        }
        for (auto next = left.begin();
             (next = std::find_if(left.begin(), left.end(), meets_fan)) != left.end();) {
            fan.push_back(*next);
            left.erase(next);
        }
        if (!left.empty()) {
            found.first = found.second++ == 0 ? v : found.first;
        }
    }
    return found;
}

TEST(Validity, FansAreThoseOfAPlainSearch) {
    int pinched = 0;
    for (int seed = 0; seed < 40; ++seed) {
        Random random(seed);
        TriangleMesh mesh = seed % 2 ? displaced_sphere(2) : open_grid(12);
        const double missing = 0.02 * (seed / 4);
        mesh.faces.erase(
            std::remove_if(mesh.faces.begin(),
                           mesh.faces.end(),
                           [&](const Triangle&) { return random.uniform() < missing; }),
            mesh.faces.end());
        for (int i = 0; i < seed % 4; ++i) {
            Triangle& face = mesh.faces[random.below(mesh.face_count())];
            std::swap(face[0], face[1]);
            if (seed % 3 == 0) {
                mesh.faces.push_back(mesh.faces[random.below(mesh.face_count())]);
            }
        }
        const auto [first, count] = vertices_of_several_fans(mesh);
        for (int threads : {1, 3}) {
            const MeshReport r = inspect(mesh, build_dual_graph(mesh), threads);
            EXPECT_EQ(r.non_manifold_vertex_count, count) << seed;
            EXPECT_EQ(r.first_non_manifold_vertex, first) << seed;
        }
        pinched += count > 0;
    }
    EXPECT_GT(pinched, 10);
    EXPECT_LT(pinched, 38);
}

TEST(Validity, DegenerateFacesAreNamedFirstAndCountAsNothingElse) {
    for (const Triangle& face : {Triangle{0, 1, 1}, {1, 1, 0}, {1, 0, 1}, {1, 1, 1}}) {
        TriangleMesh mesh = tetrahedron();
        mesh.faces.push_back(face);
        const MeshReport r = report_of(mesh);
        EXPECT_EQ(r.degenerate_face_count, 1);
        EXPECT_EQ(r.first_degenerate_face, 4);
        EXPECT_EQ(r.component_count, 1);
        EXPECT_EQ(r.edge_count, 6);
        EXPECT_EQ(r.boundary_edge_count, 0);
        EXPECT_EQ(r.non_manifold_edge_count, 0);
        EXPECT_EQ(r.non_manifold_vertex_count, 0);
        expect_defect(
            r, "1 face that names a vertex twice (first: face 4)", "\"Remove Zero Area Faces\"");
    }
}

TEST(Validity, DuplicateFacesAreFoundInEitherOrientation) {
    TriangleMesh copy = tetrahedron();
    copy.faces.push_back({2, 1, 0});
    const MeshReport r = report_of(copy);
    EXPECT_EQ(r.duplicate_face_count, 1);
    EXPECT_EQ(r.first_duplicate_face, 4);
    expect_defect(r, "1 face with the same vertices", "\"Remove Duplicate Faces\"");

    TriangleMesh reversed = tetrahedron();
    reversed.faces.push_back({0, 1, 2});
    EXPECT_EQ(report_of(reversed).duplicate_face_count, 1);

    const MeshReport pillow =
        report_of({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 1}}});
    EXPECT_EQ(pillow.duplicate_face_count, 1);
    EXPECT_EQ(pillow.boundary_edge_count, 0);
    expect_defect(pillow, "1 face with the same vertices", "\"Remove Duplicate Faces\"");
    EXPECT_EQ(surface_error(pillow), "");
}

TEST(Validity, DuplicatesAreThoseOfAComparisonOfAllPairs) {
    int several = 0;
    for (int seed = 0; seed < 200; ++seed) {
        Random random(seed);
        TriangleMesh mesh;
        mesh.positions.resize(5);
        for (int f = 0; f < 6; ++f) {
            const auto corner = [&] { return static_cast<int>(random.below(5)); };
            mesh.faces.push_back({corner(), corner(), corner()});
        }
        std::vector<Triangle> sorted = mesh.faces;
        for (Triangle& face : sorted) {
            std::sort(face.begin(), face.end());
        }
        int count = 0;
        for (auto face = sorted.begin(); face != sorted.end(); ++face) {
            count += std::find(sorted.begin(), face, *face) != face;
        }
        EXPECT_EQ(report_of(mesh).duplicate_face_count, count) << seed;
        several += count > 1;
    }
    EXPECT_GT(several, 10);
}

TEST(Validity, NonFiniteCoordinatesAreNamed) {
    TriangleMesh mesh = octahedron();
    mesh.positions[3].y = std::numeric_limits<double>::quiet_NaN();
    mesh.positions[4].x = std::numeric_limits<double>::infinity();
    const MeshReport r = report_of(mesh);
    EXPECT_EQ(r.non_finite_vertex_count, 2);
    EXPECT_EQ(r.first_non_finite_vertex, 3);
    expect_defect(r, "2 vertices with a NaN or infinite coordinate (first: vertex 3)", "Delete");
}

TEST(Validity, TheFirstFaceIsTheLowestWhateverItsVertices) {
    TriangleMesh mesh;
    mesh.positions.resize(6);
    mesh.faces = {{3, 4, 5}, {0, 1, 2}};
    EXPECT_EQ(report_of(mesh).first_boundary_face, 0);
    mesh.faces = {{3, 4, 5}, {0, 1, 2}, {3, 4, 5}, {0, 1, 2}};
    EXPECT_EQ(report_of(mesh).first_duplicate_face, 2);
}

TEST(Validity, MeshesWithMoreFacesOrVerticesThanIndicesAreAnError) {
    EXPECT_NO_THROW(check_size(1 << 28, 1 << 27));
    EXPECT_NO_THROW(check_size(0, std::size_t{1} << 30));
    EXPECT_THROW(check_size((1 << 28) + 1, 3), InvalidInput);
    EXPECT_THROW(check_size(1, (std::size_t{1} << 30) + 1), InvalidInput);
    EXPECT_THROW(check_size(std::size_t{1} << 32, 3), InvalidInput);
}

TEST(Validity, IndicesOutOfRangeAreAnError) {
    TriangleMesh mesh = tetrahedron();
    mesh.faces[2][1] = 9;
    EXPECT_THROW(build_dual_graph(mesh), InvalidInput);
}

} // namespace
} // namespace spheroseg
