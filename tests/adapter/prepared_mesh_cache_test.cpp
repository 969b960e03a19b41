// SPDX-License-Identifier: GPL-3.0-or-later
#include "prepared_mesh_cache.h"

#include "test_solids.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace spheroseg {
namespace {

using test::octahedron; // its vertices, in order, are also a valid map to the sphere

/// The octahedron's map, turned by a quarter about z.
std::vector<Vec3> turned_octahedron() {
    return {{0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0, -1}};
}

std::vector<std::array<double, 3>> coordinates(const std::vector<Vec3>& positions) {
    std::vector<std::array<double, 3>> result;
    for (const Vec3& p : positions) {
        result.push_back({p.x, p.y, p.z});
    }
    return result;
}

std::vector<std::array<double, 3>> map_of(PreparedMesh& prepared) {
    return coordinates(prepared.parametrization(1).positions);
}

/// Of what was prepared. That of another mesh differs: it is passed in while the first one lives.
const Triangle* faces_of(PreparedMesh& prepared) {
    return prepared.mesh().faces.data();
}

TEST(PreparedMeshCache, KeepsWhatWasPreparedForTheSameMesh) {
    PreparedMeshCache cache;
    TriangleMesh mesh = octahedron();
    mesh.positions[3].x = std::numeric_limits<double>::quiet_NaN(); // equals itself here
    const Triangle* const first = faces_of(cache.prepare(mesh, {}, 1));
    EXPECT_EQ(faces_of(cache.prepare(mesh, {}, 1)), first);
    EXPECT_EQ(faces_of(cache.prepare(mesh, {}, 2)), first);
}

TEST(PreparedMeshCache, TellsMeshesApart) {
    TriangleMesh moved = octahedron();
    moved.positions[5].z = -2.0;
    TriangleMesh turned = octahedron();
    turned.faces[7] = {3, 5, 0};
    TriangleMesh more = octahedron();
    more.positions.push_back({2, 2, 2});
    for (const TriangleMesh& other : {moved, turned, more}) {
        PreparedMeshCache cache;
        const Triangle* const first = faces_of(cache.prepare(octahedron(), {}, 1));
        PreparedMesh& prepared = cache.prepare(other, {}, 1);
        EXPECT_NE(faces_of(prepared), first);
        EXPECT_EQ(prepared.mesh().faces, other.faces);
        EXPECT_EQ(prepared.mesh().vertex_count(), other.vertex_count());
    }
}

TEST(PreparedMeshCache, UsesTheMapThatIsGivenAndNeverOneOfAnEarlierCall) {
    PreparedMeshCache cache;
    const auto own = map_of(cache.prepare(octahedron(), {}, 1));
    EXPECT_NE(own, coordinates(turned_octahedron()));
    EXPECT_FALSE(cache.uses_given_positions());
    for (const std::vector<Vec3>& given : {octahedron().positions, turned_octahedron()}) {
        PreparedMesh& prepared = cache.prepare(octahedron(), given, 1);
        EXPECT_TRUE(cache.uses_given_positions());
        EXPECT_EQ(map_of(prepared), coordinates(given));
        const Triangle* const kept = faces_of(prepared);
        EXPECT_EQ(faces_of(cache.prepare(octahedron(), given, 1)), kept);
        EXPECT_TRUE(cache.uses_given_positions());
    }
    PreparedMesh& without = cache.prepare(octahedron(), {}, 1);
    EXPECT_FALSE(cache.uses_given_positions());
    EXPECT_EQ(map_of(without), own);
}

TEST(PreparedMeshCache, LeavesOutAMapThatIsNotValid) {
    PreparedMeshCache cache;
    const auto own = map_of(cache.prepare(octahedron(), {}, 1));
    const std::vector<Vec3> at_one_point(6, Vec3{0, 0, 1});
    PreparedMesh& prepared = cache.prepare(octahedron(), at_one_point, 1);
    EXPECT_FALSE(cache.uses_given_positions());
    EXPECT_EQ(map_of(prepared), own);
}

} // namespace
} // namespace spheroseg
