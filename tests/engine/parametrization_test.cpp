// SPDX-License-Identifier: GPL-3.0-or-later
#include "parametrization.h"

#include "errors.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

namespace spheroseg {
namespace {

Parametrization map_of(const TriangleMesh& mesh, int thread_count = 2, Progress progress = {}) {
    const DualGraph dual_graph = build_dual_graph(mesh, 1);
    return parametrize(mesh, build_hierarchy(mesh, dual_graph, 1), thread_count, progress);
}

bool same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Vec3& p, const Vec3& q) {
        return p.x == q.x && p.y == q.y && p.z == q.z;
    });
}

/// Of the triangles around the origin that contain it: how often the map covers that direction.
int cover_count(const TriangleMesh& mesh, const std::vector<Vec3>& positions, const Vec3& way) {
    int count = 0;
    for (const Triangle& t : mesh.faces) {
        const Vec3& a = positions[t[0]];
        const Vec3& b = positions[t[1]];
        const Vec3& c = positions[t[2]];
        count += dot(way, cross(a, b)) > 0.0 && dot(way, cross(b, c)) > 0.0 &&
            dot(way, cross(c, a)) > 0.0;
    }
    return count;
}

class MapOfEachMesh : public testing::TestWithParam<test::MeshRecipe> {};

TEST_P(MapOfEachMesh, HasNoFlippedTriangleAndUnitVectors) {
    const TriangleMesh mesh = GetParam().make();
    const Parametrization map = map_of(mesh);
    ASSERT_EQ(map.positions.size(), mesh.positions.size());
    for (const Vec3& p : map.positions) {
        EXPECT_NEAR(length(p), 1.0, 1e-12);
    }
    const ParametrizationQuality quality = measure_parametrization(mesh, map.positions);
    EXPECT_EQ(quality.flipped_triangle_count, 0);
    EXPECT_GT(quality.min_triangle_area, 0.0);
    EXPECT_TRUE(is_valid_parametrization(mesh, map.positions));
}

TEST_P(MapOfEachMesh, CoversTheSphereOnce) {
    const TriangleMesh mesh = GetParam().make();
    const Parametrization map = map_of(mesh);
    Random random(7);
    for (int i = 0; i < 50; ++i) {
        const Vec3 way = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
        EXPECT_EQ(cover_count(mesh, map.positions, way), 1);
    }
}

TEST_P(MapOfEachMesh, IsTheSameForOneAndThreeThreads) {
    const TriangleMesh mesh = GetParam().make();
    EXPECT_TRUE(same_bits(map_of(mesh, 1).positions, map_of(mesh, 3).positions));
}

INSTANTIATE_TEST_SUITE_P(GenusZero,
                         MapOfEachMesh,
                         testing::ValuesIn(test::genus_zero_recipes()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Parametrization, KeepsAnglesWhereTrianglesAreEven) {
    for (const TriangleMesh& mesh : {test::icosphere(4), test::limbed_figure(4)}) {
        const ParametrizationQuality quality =
            measure_parametrization(mesh, map_of(mesh).positions);
        EXPECT_LT(quality.anisotropy_mean, 1.1);
    }
}

TEST(Parametrization, SurvivesLongTubesAndDeepNesting) {
    for (const TriangleMesh& mesh : {test::long_thin_limb(3, 4000),
                                     test::long_thin_limb(8, 2000),
                                     test::slivers(5000, true),
                                     test::slivers(20000),
                                     test::bipyramid(3000)}) {
        EXPECT_TRUE(is_valid_parametrization(mesh, map_of(mesh).positions));
    }
}

TEST(Parametrization, PutsUnreferencedVerticesAtTheNorthPole) {
    TriangleMesh mesh = test::octahedron();
    mesh.positions.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
    const Parametrization map = map_of(mesh);
    const Vec3& p = map.positions.back();
    EXPECT_TRUE(p.x == 0.0 && p.y == 0.0 && p.z == 1.0);
    EXPECT_TRUE(is_valid_parametrization(mesh, map.positions));
}

TEST(Parametrization, RejectsSurfacesThatAreNotOneClosedSphere) {
    EXPECT_THROW(map_of(test::torus(12, 8)), InvalidInput);
    EXPECT_THROW(map_of(test::open_grid(4)), InvalidInput);
    EXPECT_THROW(map_of({}), InvalidInput);
    TriangleMesh open_box = test::octahedron();
    open_box.faces.resize(4);
    EXPECT_THROW(map_of(open_box), InvalidInput);
    TriangleMesh two = test::octahedron();
    for (const Triangle& t : test::octahedron().faces) {
        two.faces.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
    }
    two.positions.resize(12);
    EXPECT_THROW(map_of(two), InvalidInput);
    EXPECT_THROW(map_of(test::pinholed(test::icosphere(3), 30)), InvalidInput);
}

TEST(Parametrization, ReportsRisingProgressAndCanBeCancelled) {
    const TriangleMesh mesh = test::icosphere(3);
    double last = 0.0;
    map_of(mesh, 2, [&](double fraction, const char*) {
        EXPECT_GE(fraction, last);
        EXPECT_LE(fraction, 1.0);
        last = fraction;
        return true;
    });
    EXPECT_GT(last, 0.5);
    EXPECT_THROW(map_of(mesh, 2, [](double, const char*) { return false; }), Cancelled);
}

TEST(ParametrizationQuality, OfARegularTetrahedronIsIdeal) {
    TriangleMesh mesh = test::tetrahedron();
    std::vector<Vec3> sphere = mesh.positions;
    for (Vec3& p : sphere) {
        p = p * std::sqrt(1.0 / 3.0);
    }
    const ParametrizationQuality quality = measure_parametrization(mesh, sphere);
    EXPECT_EQ(quality.flipped_triangle_count, 0);
    // Edge sqrt(8 / 3): area sqrt(3) / 4 * 8 / 3.
    EXPECT_NEAR(quality.min_triangle_area, 2.0 / std::sqrt(3.0), 1e-12);
    EXPECT_NEAR(quality.area_distortion_mean, 1.0, 1e-12);
    EXPECT_NEAR(quality.area_distortion_max, 1.0, 1e-12);
    EXPECT_NEAR(quality.anisotropy_mean, 1.0, 1e-12);
}

TEST(ParametrizationQuality, CountsEveryFlippedAndFlatTriangle) {
    const TriangleMesh mesh = test::octahedron();
    std::vector<Vec3> mirrored = mesh.positions;
    for (Vec3& p : mirrored) {
        p.x = -p.x;
    }
    EXPECT_EQ(measure_parametrization(mesh, mirrored).flipped_triangle_count, 8);
    // Vertex 4, the north pole, onto vertex 0: two of its four triangles become flat, the two on
    // the far side lie in the plane of the equator, flat as well.
    std::vector<Vec3> flat = mesh.positions;
    flat[4] = flat[0];
    EXPECT_EQ(measure_parametrization(mesh, flat).flipped_triangle_count, 4);
    EXPECT_EQ(measure_parametrization(mesh, flat).min_triangle_area, 0.0);
    EXPECT_THROW(measure_parametrization(mesh, {}), InvalidInput);
}

TEST(ParametrizationQuality, AreaDistortionComparesSharesOfTheArea) {
    // A tetrahedron with one vertex far away: face 0 (of vertices 0, 2, 1) keeps its area.
    TriangleMesh mesh = test::tetrahedron();
    std::vector<Vec3> sphere = mesh.positions;
    for (Vec3& p : sphere) {
        p = p * std::sqrt(1.0 / 3.0);
    }
    mesh.positions[3] = mesh.positions[3] * 3.0;
    const auto area = [&](int f) {
        const Vec3& a = mesh.positions[mesh.faces[f][0]];
        return 0.5 *
            length(cross(mesh.positions[mesh.faces[f][1]] - a,
                         mesh.positions[mesh.faces[f][2]] - a));
    };
    const double small_share = area(0) / (area(0) + 3.0 * area(1));
    const double large_share = (1.0 - small_share) / 3.0;
    const ParametrizationQuality quality = measure_parametrization(mesh, sphere);
    EXPECT_NEAR(quality.area_distortion_max, 0.25 / small_share, 1e-12);
    EXPECT_NEAR(quality.area_distortion_mean,
                small_share * 0.25 / small_share + 3.0 * large_share * large_share / 0.25,
                1e-12);
}

TEST(ParametrizationQuality, AreaDistortionDoesNotDependOnTheUnit) {
    TriangleMesh mesh = test::tetrahedron();
    const std::vector<Vec3> sphere = mesh.positions;
    const auto distortion = [&](double scale) {
        for (std::size_t v = 0; v < sphere.size(); ++v) {
            mesh.positions[v] = sphere[v] * scale;
        }
        return measure_parametrization(mesh, sphere).area_distortion_mean;
    };
    EXPECT_NEAR(distortion(1e200) / distortion(1.0), 1.0, 1e-12);
    EXPECT_NEAR(distortion(1e-200) / distortion(1.0), 1.0, 1e-12);
    EXPECT_EQ(distortion(0.0), 0.0);
}

TEST(IsValidParametrization, RejectsWrongSizesNaNOtherRadiiFlipsAndDoubleCovers) {
    const TriangleMesh mesh = test::octahedron();
    EXPECT_TRUE(is_valid_parametrization(mesh, mesh.positions));
    EXPECT_FALSE(is_valid_parametrization(mesh, {}));
    std::vector<Vec3> sphere = mesh.positions;
    sphere[3].y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(is_valid_parametrization(mesh, sphere));
    sphere = mesh.positions;
    sphere[0].x = 1.00005;
    EXPECT_TRUE(is_valid_parametrization(mesh, sphere));
    sphere[0].x = 1.0002;
    EXPECT_FALSE(is_valid_parametrization(mesh, sphere));
    sphere = mesh.positions;
    std::swap(sphere[0], sphere[1]);
    EXPECT_FALSE(is_valid_parametrization(mesh, sphere));
    // A bipyramid of eight sides whose equator runs around twice: no triangle is flipped.
    const TriangleMesh bipyramid = test::bipyramid(8);
    std::vector<Vec3> twice = bipyramid.positions;
    EXPECT_TRUE(is_valid_parametrization(bipyramid, twice));
    for (int i = 0; i < 8; ++i) {
        twice[i] = {std::cos(test::kPi * i / 2), std::sin(test::kPi * i / 2), 0.0};
    }
    EXPECT_EQ(measure_parametrization(bipyramid, twice).flipped_triangle_count, 0);
    EXPECT_FALSE(is_valid_parametrization(bipyramid, twice));
}

} // namespace
} // namespace spheroseg
