// SPDX-License-Identifier: GPL-3.0-or-later
#include "all_pairs_cohesion.h"

#include "cohesion_energy.h"
#include "cohesion_state.h"
#include "measures.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

using Point = std::array<float, 3>;

float chord(const Point& a, const Point& b) {
    const float dx = a[0] - b[0];
    const float dy = a[1] - b[1];
    const float dz = a[2] - b[2];
    return std::sqrt(dx * dx + dy * dy + dz * dz);
}

std::vector<Point> rounded(const std::vector<Vec3>& points) {
    std::vector<Point> result;
    for (const Vec3& p : points) {
        result.push_back(
            {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)});
    }
    return result;
}

/// Mean of each label's points, on the sphere.
std::vector<Point>
mean_points(const std::vector<Point>& points, const std::vector<int>& labels, int k) {
    std::vector<Vec3> sums(k);
    for (std::size_t i = 0; i < points.size(); ++i) {
        sums[labels[i]] = sums[labels[i]] + Vec3{points[i][0], points[i][1], points[i][2]};
    }
    for (Vec3& sum : sums) {
        sum = sum * (1.0 / length(sum));
    }
    return rounded(sums);
}

/// Algorithm 2 with its index array, one iteration. Counts the swaps, and checks that each one
/// lowers the energy.
int iterate_as_in_the_paper(const std::vector<Point>& points, std::vector<int>& labels, int k) {
    const std::vector<Point> centroids = mean_points(points, labels, k);
    const int face_count = static_cast<int>(points.size());
    const int n = face_count + face_count % 2;
    std::vector<int> u(n);
    std::iota(u.begin(), u.end(), 0);
    const auto energy = [&] {
        double sum = 0.0;
        for (int f = 0; f < face_count; ++f) {
            sum += chord(points[f], centroids[labels[f]]);
        }
        return sum;
    };
    int swap_count = 0;
    for (int round = 0; round < n - 1; ++round) {
        for (int j = 0; j < n / 2; ++j) {
            const int a = u[j];
            const int b = u[n - 1 - j];
            if (a >= face_count || b >= face_count || labels[a] == labels[b]) {
                continue;
            }
            const float d1 = chord(points[a], centroids[labels[a]]);
            const float d2 = chord(points[b], centroids[labels[b]]);
            const float d3 = chord(points[a], centroids[labels[b]]);
            const float d4 = chord(points[b], centroids[labels[a]]);
            if (d1 + d2 > d3 + d4) {
                const double before = energy();
                std::swap(labels[a], labels[b]);
                EXPECT_LT(energy(), before);
                ++swap_count;
            }
        }
        for (int j = 1; j < n; ++j) {
            u[j] = u[j] - 1 < 1 ? n - 1 : u[j] - 1;
        }
    }
    return swap_count;
}

/// A sphere's faces, the last `left_out` of them removed, with what cohesion needs.
struct Case {
    explicit Case(int level, int left_out = 0) {
        TriangleMesh mesh = icosphere(level);
        mesh.faces.resize(mesh.faces.size() - left_out);
        graph = build_dual_graph(mesh);
        centroids = face_centroids_on_sphere(mesh, mesh.positions);
    }
    int face_count() const { return graph.face_count(); }
    DualGraph graph;
    std::vector<Vec3> centroids;
};

std::vector<int> label_counts(const std::vector<int>& labels, int k) {
    std::vector<int> counts(k, 0);
    for (int label : labels) {
        ++counts[label];
    }
    return counts;
}

TEST(RandomBalancedLabels, CountsAreFloorOrCeil) {
    for (int k : {1, 3, 7, 20}) {
        for (int count : label_counts(random_balanced_labels(20, k, 5), k)) {
            EXPECT_TRUE(count == 20 / k || count == (20 + k - 1) / k);
        }
    }
}

TEST(RandomBalancedLabels, DependOnTheSeedOnly) {
    EXPECT_EQ(random_balanced_labels(100, 9, 1), random_balanced_labels(100, 9, 1));
    EXPECT_NE(random_balanced_labels(100, 9, 1), random_balanced_labels(100, 9, 2));
}

TEST(Cohesion, FollowsThePaperSwapBySwap) {
    for (int left_out : {0, 1, 2}) { // even and odd numbers of faces
        const Case sphere(2, left_out);
        for (int k : {2, 7, 40}) {
            std::vector<int> expected = random_balanced_labels(sphere.face_count(), k, 3);
            std::vector<int> labels = expected;
            const std::vector<Point> points = rounded(sphere.centroids);
            SwapLimits limits;
            limits.max_iterations = 3;
            const SwapIterations history =
                cohere_all_pairs(sphere.graph, sphere.centroids, k, 0, limits, labels);
            ASSERT_EQ(history.count(), 3);
            for (int i = 0; i < 3; ++i) {
                EXPECT_EQ(history.swaps[i], iterate_as_in_the_paper(points, expected, k));
            }
            EXPECT_EQ(labels, expected);
        }
    }
}

TEST(Cohesion, EndsWithNoImprovingPairAndLessEnergy) {
    const Case sphere(2);
    const int k = 13;
    std::vector<int> labels = random_balanced_labels(sphere.face_count(), k, 0);
    const double energy_at_start = cohesion_energy(sphere.centroids, labels, k);
    const SwapIterations history =
        cohere_all_pairs(sphere.graph, sphere.centroids, k, 0, {}, labels);
    EXPECT_EQ(history.swaps.back(), 0.0);
    EXPECT_LT(history.energy.back(), 0.5 * energy_at_start);
    EXPECT_DOUBLE_EQ(history.energy.back(), cohesion_energy(sphere.centroids, labels, k));
    EXPECT_EQ(history.boundary_edges.back(), count_boundary_edges(sphere.graph, labels));
    const std::vector<Point> points = rounded(sphere.centroids);
    const std::vector<Point> centroids = mean_points(points, labels, k);
    for (int a = 0; a < sphere.face_count(); ++a) {
        for (int b = 0; b < a; ++b) {
            EXPECT_LE(
                chord(points[a], centroids[labels[a]]) + chord(points[b], centroids[labels[b]]),
                chord(points[a], centroids[labels[b]]) + chord(points[b], centroids[labels[a]]));
        }
    }
}

TEST(Cohesion, KeepsTheCountsWhenTheyDoNotDivide) {
    const Case sphere(2);
    for (int k : {1, 3, 7, 319, 320}) {
        std::vector<int> labels = random_balanced_labels(sphere.face_count(), k, 0);
        const std::vector<int> counts = label_counts(labels, k);
        cohere_all_pairs(sphere.graph, sphere.centroids, k, 0, {}, labels);
        EXPECT_EQ(label_counts(labels, k), counts) << k;
    }
}

TEST(Cohesion, TheNumberOfThreadsDoesNotMatter) {
    const Case sphere(4); // 2,560 slots: up to five threads
    const int k = 50;
    const std::vector<int> start = random_balanced_labels(sphere.face_count(), k, 1);
    std::vector<int> expected = start;
    SwapLimits limits;
    limits.thread_count = 1;
    limits.max_iterations = 4;
    const SwapIterations expected_history =
        cohere_all_pairs(sphere.graph, sphere.centroids, k, 0, limits, expected);
    for (int threads : {1, 2, 3, 5}) {
        std::vector<int> labels = start;
        limits.thread_count = threads;
        const SwapIterations history =
            cohere_all_pairs(sphere.graph, sphere.centroids, k, 0, limits, labels);
        EXPECT_EQ(labels, expected) << threads << " threads";
        EXPECT_EQ(history.swaps, expected_history.swaps);
        EXPECT_EQ(history.energy, expected_history.energy);
    }
}

TEST(Cohesion, CoincidingCentroidsArePartedOnce) {
    // Every sub-mesh is a pair of opposite points: all centroids lie at the centre of the sphere.
    const std::vector<Vec3> centroids{{1, 0, 0},
                                      {-1, 0, 0},
                                      {0, 1, 0},
                                      {0, -1, 0},
                                      {0, 0, 1},
                                      {0, 0, -1},
                                      {0.6, 0.8, 0},
                                      {-0.6, -0.8, 0}};
    std::vector<int> labels{0, 0, 1, 1, 2, 2, 3, 3};
    ASSERT_EQ(cohesion_energy(centroids, labels, 4), 8.0);
    const DualGraph graph = build_dual_graph(octahedron());
    const SwapIterations history = cohere_all_pairs(graph, centroids, 4, 0, {}, labels);
    EXPECT_EQ(history.swaps.front(), 0.0);
    EXPECT_GT(history.count(), 1);
    EXPECT_LT(history.energy.back(), 7.0);
    EXPECT_EQ(label_counts(labels, 4), std::vector<int>(4, 2));
}

TEST(Cohesion, EndsWhenAllFacesLieAtOnePoint) {
    const TriangleMesh mesh = octahedron();
    const std::vector<Vec3> centroids(8, Vec3{0, 0, 1});
    std::vector<int> labels = random_balanced_labels(8, 3, 0);
    const SwapIterations history =
        cohere_all_pairs(build_dual_graph(mesh), centroids, 3, 0, {}, labels);
    EXPECT_EQ(history.energy.back(), 0.0);
    EXPECT_EQ(label_counts(labels, 3), (std::vector<int>{3, 3, 2}));
}

TEST(Cohesion, StopsAtLimitsAndOnCancel) {
    const Case sphere(2);
    std::vector<int> labels = random_balanced_labels(sphere.face_count(), 10, 0);
    const std::vector<int> start = labels;
    SwapLimits limits;
    limits.max_iterations = 1;
    EXPECT_EQ(cohere_all_pairs(sphere.graph, sphere.centroids, 10, 0, limits, labels).count(), 1);

    const Deadline passed(1e-9);
    limits.deadline = &passed;
    labels = start;
    const SwapIterations cut =
        cohere_all_pairs(sphere.graph, sphere.centroids, 10, 0, limits, labels);
    EXPECT_TRUE(cut.time_limit_hit);
    EXPECT_EQ(labels, start);

    const auto refuse = [](double, const char*) { return false; };
    EXPECT_THROW(cohere_all_pairs(sphere.graph, sphere.centroids, 10, 0, {}, labels, refuse),
                 Cancelled);
    EXPECT_EQ(labels, start);
}

} // namespace
} // namespace spheroseg
