// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_adapter.h"

#include "errors.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using Allocator = vcg::tri::Allocator<CMeshO>;

/// A tetrahedron (vertices 1 to 4, faces 1 to 4) between elements that are deleted.
CMeshO make_tetrahedron_with_deleted_elements() {
    CMeshO host;
    Allocator::AddVertices(host, 6);
    const Point3m corners[6] = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {8, 8, 8}};
    for (int v = 0; v < 6; ++v) {
        host.vert[v].P() = corners[v];
    }
    Allocator::AddFace(host, 0, 1, 5);
    Allocator::AddFace(host, 1, 3, 2);
    Allocator::AddFace(host, 1, 2, 4);
    Allocator::AddFace(host, 2, 3, 4);
    Allocator::AddFace(host, 3, 1, 4);
    Allocator::DeleteFace(host, host.face[0]);
    Allocator::DeleteVertex(host, host.vert[0]);
    Allocator::DeleteVertex(host, host.vert[5]);
    host.face.EnableQuality();
    host.face.EnableColor();
    return host;
}

TEST(ReadMesh, LeavesOutDeletedElementsAndKeepsTheirOrder) {
    const HostMesh adapted = read_mesh(make_tetrahedron_with_deleted_elements());
    EXPECT_EQ(adapted.vertex_index, (std::vector<int>{1, 2, 3, 4}));
    EXPECT_EQ(adapted.face_index, (std::vector<int>{1, 2, 3, 4}));
    const std::vector<Triangle> expected = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    EXPECT_EQ(adapted.mesh.faces, expected);
    ASSERT_EQ(adapted.mesh.vertex_count(), 4);
    EXPECT_EQ(adapted.mesh.positions[3].z, 1.0);
}

TEST(ReadMesh, AFaceAtADeletedVertexGetsAnIndexThatTheEngineRejects) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    Allocator::DeleteVertex(host, host.vert[4]);
    EXPECT_EQ(read_mesh(host).mesh.faces[1], (Triangle{0, 1, -1}));
}

TEST(SameElements, AreNoLongerThereAfterCompactingOrAFlip) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    HostMesh adapted = read_mesh(host);
    const std::vector<Triangle> faces = std::move(adapted.mesh.faces);
    EXPECT_TRUE(has_same_elements(host, adapted, faces));
    host.vert[1].P() = Point3m(0, 0, -1);
    EXPECT_TRUE(has_same_elements(host, adapted, faces)) << "only a position changed";

    std::swap(host.face[1].V(0), host.face[1].V(1));
    EXPECT_FALSE(has_same_elements(host, adapted, faces)) << "a face has other corners";
    std::swap(host.face[1].V(0), host.face[1].V(1));
    Allocator::CompactEveryVector(host);
    EXPECT_FALSE(has_same_elements(host, adapted, faces)) << "all elements lie elsewhere";
}

TEST(Labels, GoToTheLivingFacesAndComeBack) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    host.face[0].Q() = -7;
    const HostMesh adapted = read_mesh(host);
    const std::vector<int> labels = {2, 0, 1, 2};
    write_labels(host, adapted, labels);
    EXPECT_EQ(host.face[0].Q(), -7);
    EXPECT_EQ(host.face[1].Q(), 2);
    EXPECT_EQ(read_labels(host, adapted), labels);
}

/// `part` must occur in the error.
void expect_labels_refused(const CMeshO& host, const HostMesh& adapted, const std::string& part) {
    try {
        read_labels(host, adapted);
        FAIL() << "no error that says: " << part;
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(Labels, ErrorsNameTheFaceOfTheHost) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    const HostMesh adapted = read_mesh(host);
    write_labels(host, adapted, {0, 0, 0, 0});
    host.face[3].Q() = Scalarm(1.5);
    expect_labels_refused(host, adapted, "face 3 has 1.5");
}

TEST(Labels, ErrorsShowValuesThatAreNearlyWhole) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    const HostMesh adapted = read_mesh(host);
    write_labels(host, adapted, {0, 0, 0, 0});
    host.face[2].Q() = Scalarm(1e-9);
    expect_labels_refused(host, adapted, "face 2 has 1e-09");
}

TEST(Labels, ThatSinglePrecisionWouldRoundAreRefused) {
    constexpr int kMost = 16777216; // labels up to 16777215; above this neighbours become the same
    EXPECT_EQ(static_cast<int>(static_cast<float>(kMost - 1)), kMost - 1);
    EXPECT_EQ(static_cast<float>(kMost), static_cast<float>(kMost + 1));
    EXPECT_NO_THROW(check_label_range(1));
    EXPECT_NO_THROW(check_label_range(kMost));
    EXPECT_THROW(check_label_range(kMost + 1), InvalidOptions);

    CMeshO host = make_tetrahedron_with_deleted_elements();
    const HostMesh adapted = read_mesh(host);
    write_labels(host, adapted, {0, kMost - 1, 0, 0});
    EXPECT_EQ(read_labels(host, adapted)[1], kMost - 1);
    host.face[2].Q() = Scalarm(kMost);
    expect_labels_refused(host, adapted, "from 0 to 16777215 in the face quality");
}

TEST(FaceColors, AreThoseOfTheLabels) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    const HostMesh adapted = read_mesh(host);
    write_face_colors(host, adapted, {1, 0, 1, 0}, {{10, 20, 30}, {40, 50, 60}});
    EXPECT_EQ(host.face[1].C(), vcg::Color4b(40, 50, 60, 255));
    EXPECT_EQ(host.face[4].C(), vcg::Color4b(10, 20, 30, 255));
}

TEST(SpherePositions, AreKeptPerLivingVertex) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    const HostMesh adapted = read_mesh(host);
    EXPECT_FALSE(read_sphere_positions(host, adapted).has_value());
    write_sphere_positions(host, adapted, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}});
    const auto positions = read_sphere_positions(host, adapted);
    ASSERT_TRUE(positions.has_value());
    EXPECT_EQ((*positions)[0].x, 1.0);
    EXPECT_EQ((*positions)[3].y, -1.0);
    auto attribute = Allocator::FindPerVertexAttribute<Point3m>(host, "sphere_position");
    EXPECT_EQ(attribute[4], Point3m(0, -1, 0));
}

TEST(SpherePositions, ReplaceAnAttributeOfAnotherType) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    Allocator::AddPerVertexAttribute<Scalarm>(host, "sphere_position");
    const HostMesh adapted = read_mesh(host);
    EXPECT_FALSE(read_sphere_positions(host, adapted).has_value());
    write_sphere_positions(host, adapted, std::vector<Vec3>(4, Vec3{0, 0, 1}));
    EXPECT_TRUE(read_sphere_positions(host, adapted).has_value());
}

TEST(MoveVertices, UpdatesTheBoundingBox) {
    CMeshO host = make_tetrahedron_with_deleted_elements();
    const HostMesh adapted = read_mesh(host);
    move_vertices(host, adapted, {{-1, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}});
    EXPECT_EQ(host.bbox.min, Point3m(-1, 0, 0));
    EXPECT_EQ(host.bbox.max, Point3m(1, 2, 3));
}

} // namespace
} // namespace spheroseg
