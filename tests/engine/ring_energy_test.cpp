// SPDX-License-Identifier: GPL-3.0-or-later
#include "ring_energy.h"

#include "orientation.h"
#include "random.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

Vec3 on_sphere(double x, double y) {
    const Vec3 p = {x, y, 1.0};
    return p * (1.0 / length(p));
}

VertexRing ring_of(const std::vector<Vec3>& corners) {
    VertexRing ring;
    for (const Vec3& corner : corners) {
        ring.add(corner);
    }
    return ring;
}

std::vector<Vec3> regular_corners(int degree, double radius) {
    std::vector<Vec3> corners;
    for (int j = 0; j < degree; ++j) {
        const double angle = 2.0 * 3.14159265358979323846 * j / degree;
        corners.push_back(on_sphere(radius * std::cos(angle), radius * std::sin(angle)));
    }
    return corners;
}

/// A star-shaped ring seen from corner 0 only: the fan around it is counter-clockwise, yet neither
/// the mean nor the vector area lies in its kernel.
std::vector<Vec3> hooked_corners() {
    return {on_sphere(0.0, 0.0),
            on_sphere(0.1, -0.001),
            on_sphere(0.1, 0.1),
            on_sphere(0.01, 0.012),
            on_sphere(-0.1, 0.1),
            on_sphere(-0.1, -0.001)};
}

void expect_encloses(const std::vector<Vec3>& corners, const Vec3& v) {
    for (std::size_t j = 0; j < corners.size(); ++j) {
        EXPECT_EQ(orientation(v, corners[j], corners[(j + 1) % corners.size()]), 1);
    }
}

TEST(VertexRing, EnclosesItsCentreAndNothingOutside) {
    VertexRing ring = ring_of(regular_corners(6, 0.1));
    EXPECT_TRUE(ring.encloses(on_sphere(0.0, 0.0)));
    EXPECT_TRUE(ring.encloses(on_sphere(0.05, 0.05)));
    EXPECT_FALSE(ring.encloses(on_sphere(0.2, 0.0)));
    EXPECT_FALSE(ring.encloses(on_sphere(0.1, 0.0))) << "a corner";
    EXPECT_FALSE(ring.encloses(Vec3{0.0, 0.0, -1.0}));
}

TEST(VertexRing, FindsAStartInTheKernelOfAHookedRing) {
    const std::vector<Vec3> corners = hooked_corners();
    VertexRing ring = ring_of(corners);
    Vec3 v;
    ASSERT_TRUE(ring.find_start(v));
    expect_encloses(corners, v);
}

TEST(VertexRing, FindsNoStartInARingWithoutArea) {
    const Vec3 p = on_sphere(0.1, 0.0);
    Vec3 v;
    EXPECT_FALSE(ring_of({p, on_sphere(0.2, 0.0), on_sphere(0.3, 0.0)}).find_start(v));
    EXPECT_FALSE(ring_of({p, p, p}).find_start(v));
}

TEST(VertexRing, MovesTheVertexOfARegularRingToItsCentre) {
    VertexRing ring = ring_of(regular_corners(6, 0.1));
    Vec3 v = on_sphere(0.06, -0.03);
    ring.minimize(v, {0.01, 1e-8}, 30);
    EXPECT_NEAR(length(v - on_sphere(0.0, 0.0)), 0.0, 1e-9);
}

/// From the definition of DistortionWeights.
double
distortion_at(const std::vector<Vec3>& corners, const Vec3& v, const DistortionWeights& weights) {
    double sum = 0.0;
    for (std::size_t j = 0; j < corners.size(); ++j) {
        const Vec3& p = corners[j];
        const Vec3& q = corners[(j + 1) % corners.size()];
        const double area = 0.5 * dot(v, cross(p, q));
        const double squares = dot(p - v, p - v) + dot(q - v, q - v) + dot(q - p, q - p);
        const double shrinking = weights.target_area / area;
        sum +=
            squares / (4.0 * std::sqrt(3.0) * area) + weights.area_weight * shrinking * shrinking;
    }
    return sum;
}

/// Star-shaped, with the pole in its kernel.
std::vector<Vec3> irregular_corners(int degree, double radius, Random& random) {
    std::vector<Vec3> corners;
    for (int j = 0; j < degree; ++j) {
        const double angle = 2.0 * 3.14159265358979323846 * (j + 0.6 * random.uniform()) / degree;
        const double r = radius * (0.4 + 0.6 * random.uniform());
        corners.push_back(on_sphere(r * std::cos(angle), r * std::sin(angle)));
    }
    return corners;
}

TEST(VertexRing, ComesToTheLeastDistortion) {
    Random random(5);
    int starts = 0;
    for (int i = 0; i < 300; ++i) {
        const double radius = i % 2 ? 0.8 : 0.02;
        const std::vector<Vec3> corners = irregular_corners(4 + i % 5, radius, random);
        VertexRing ring = ring_of(corners);
        const double area = radius * radius / static_cast<double>(corners.size());
        const DistortionWeights weights = {area, i % 3 == 0 ? 1.0 : i % 3 == 1 ? 1e-3 : 0.0};
        const Vec3 start = on_sphere(0.1 * radius, -0.05 * radius);
        if (!ring.encloses(start)) {
            continue;
        }
        ++starts;
        // Newton steps double the digits: a wrong derivative would take more of them.
        Vec3 v = start;
        ring.minimize(v, weights, 7);
        const double least = distortion_at(corners, v, weights);
        EXPECT_LE(least, distortion_at(corners, start, weights));
        for (int direction = 0; direction < 8; ++direction) {
            const double angle = 0.78539816339744831 * direction;
            const Vec3 aside = {std::cos(angle), std::sin(angle), 0.0};
            const Vec3 near = v + aside * (1e-4 * radius);
            EXPECT_GT(distortion_at(corners, near * (1.0 / length(near)), weights), least) << i;
        }
    }
    EXPECT_GT(starts, 200);
}

TEST(VertexRing, EachStepLowersTheDistortion) {
    Random random(6);
    int starts = 0;
    for (int i = 0; i < 300; ++i) {
        const std::vector<Vec3> corners = irregular_corners(3 + i % 6, 0.3, random);
        VertexRing ring = ring_of(corners);
        Vec3 v = on_sphere(0.2 * random.uniform() - 0.1, 0.2 * random.uniform() - 0.1);
        if (!ring.encloses(v)) {
            continue;
        }
        ++starts;
        const DistortionWeights weights = {0.01, 1e-2};
        double before = distortion_at(corners, v, weights);
        for (int step = 0; step < 6; ++step) {
            ring.minimize(v, weights, 1, step % 2 ? 1.0 : 1.7);
            const double after = distortion_at(corners, v, weights);
            EXPECT_LE(after, before * (1.0 + 1e-12)) << i;
            before = after;
        }
    }
    EXPECT_GT(starts, 100);
}

TEST(VertexRing, StaysInsideFromAnyStart) {
    Random random(3);
    for (const auto& corners :
         {hooked_corners(), regular_corners(3, 0.5), regular_corners(40, 1e-5)}) {
        VertexRing ring = ring_of(corners);
        int starts = 0;
        for (int i = 0; i < 2000; ++i) {
            const double size = length(corners[1] - corners[0]);
            Vec3 v = corners[0] +
                Vec3{random.uniform() - 0.5, random.uniform() - 0.5, 0.0} * (2.0 * size);
            v = v * (1.0 / length(v));
            if (ring.encloses(v)) {
                ++starts;
                ring.minimize(v, {0.01, 1e-8}, 5, 1.7);
                expect_encloses(corners, v);
                EXPECT_NEAR(length(v), 1.0, 1e-15);
            }
        }
        EXPECT_GT(starts, 5);
    }
}

} // namespace
} // namespace spheroseg
