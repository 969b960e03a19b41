// SPDX-License-Identifier: GPL-3.0-or-later
#include "best_result.h"
#include "face_weights.h"
#include "load_lowering.h"
#include "segment.h"
#include "shares.h"
#include "weight_balance.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

std::vector<double> random_weights(int face_count, std::uint64_t seed) {
    Random random(seed);
    std::vector<double> weights(face_count);
    for (double& weight : weights) {
        weight = 1.0 + random.below(10);
    }
    return weights;
}

SegmentOptions weight_options(int submesh_count, std::vector<double> weights) {
    SegmentOptions options;
    options.submesh_count = submesh_count;
    options.effort = Effort::draft;
    options.balance = Balance::weight;
    options.face_weights = std::move(weights);
    return options;
}

/// What no segmentation can go below: the mean, and the heaviest face.
double least_imbalance(const std::vector<double>& weights, int submesh_count) {
    const double mean = std::accumulate(weights.begin(), weights.end(), 0.0) / submesh_count;
    return std::max(1.0, *std::max_element(weights.begin(), weights.end()) / mean);
}

TEST(FaceWeights, IdealLoadByHand) {
    EXPECT_DOUBLE_EQ(ideal_over_heaviest({1, 1, 1, 1}, 2), 2.0);
    // The 10 fills a sub-mesh alone; the others share 6 between two.
    EXPECT_DOUBLE_EQ(ideal_over_heaviest({1, 2, 10, 3}, 3), 0.3);
    EXPECT_DOUBLE_EQ(ideal_over_heaviest({100, 1, 10, 1}, 3), 0.02);
    EXPECT_DOUBLE_EQ(ideal_over_heaviest({5, 0, 0, 0}, 2), 0.0);
    EXPECT_DOUBLE_EQ(ideal_over_heaviest({0, 0}, 2), 0.0);
    EXPECT_DOUBLE_EQ(ideal_over_heaviest({1e308, 1e308, 1e308}, 1), 3.0);
}

TEST(FaceWeights, SharesOfTheIdealLoadByHand) {
    using Shares = std::vector<double>;
    EXPECT_EQ(load_shares({1, 1, 1, 1}, 2), (Shares{0.5, 0.5, 0.5, 0.5}));
    EXPECT_EQ(load_shares({2, 4, 100, 2}, 3), (Shares{0.5, 1, 1, 0.5}));
    EXPECT_EQ(load_shares({5, 0, 1e-300, 0}, 3), (Shares{1, 0, 1, 0}));
    EXPECT_EQ(load_shares({0, 0}, 2), (Shares{0, 0}));
    EXPECT_EQ(load_shares({1e20, 1e-308, 1e-308}, 2), (Shares{1, 0, 0}));
    EXPECT_EQ(load_shares({1e308, 1e308, 1e308, 1e308}, 1), (Shares{0.25, 0.25, 0.25, 0.25}));
}

TEST(FaceWeights, QuantizedLoadsAreOffByAtMostOneUnitPerFace) {
    for (int submesh_count : {1, 2, 7, 100, 1000}) {
        std::vector<double> weights = random_weights(2000, 3);
        weights[17] = 1e6;
        weights[18] = 0.0;
        weights[19] = 1e-9;
        const std::vector<int> quantized = quantized_weights(weights, submesh_count);
        const double ideal = 1e6 * ideal_over_heaviest(weights, submesh_count);
        const double unit = ideal * submesh_count / (1 << 29);
        std::int64_t sum = 0;
        for (std::size_t f = 0; f < weights.size(); ++f) {
            EXPECT_GE(quantized[f], 1);
            EXPECT_NEAR(quantized[f] * unit, std::min(weights[f], ideal), unit * 1.000001);
            sum += quantized[f];
        }
        EXPECT_LT(sum, 1 << 30);
    }
}

TEST(FaceWeights, AreasByHandAndWithoutOverflow) {
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 2, 0}, {0, 0, 1}};
    mesh.faces = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {0, 0, 1}};
    const std::vector<double> areas = face_areas(mesh);
    EXPECT_DOUBLE_EQ(areas[0] / areas[2], 4.0);
    EXPECT_DOUBLE_EQ(areas[1] / areas[2], 2.0);
    EXPECT_EQ(areas[3], 0.0);
    TriangleMesh moved = mesh;
    for (Vec3& p : moved.positions) {
        p = p + Vec3{1, 2, -3};
    }
    for (Triangle& face : moved.faces) {
        std::rotate(face.begin(), face.begin() + 1, face.end());
    }
    const std::vector<double> moved_areas = face_areas(moved);
    EXPECT_DOUBLE_EQ(moved_areas[0] / moved_areas[2], 4.0);
    EXPECT_DOUBLE_EQ(moved_areas[1] / moved_areas[2], 2.0);
    EXPECT_EQ(moved_areas[3], 0.0);
    for (double scale : {4e307, 0x1p-1030, 0x1p-1073}) { // the last ones are not normal
        TriangleMesh scaled = mesh;
        for (Vec3& p : scaled.positions) {
            p = p * scale;
        }
        EXPECT_DOUBLE_EQ(face_areas(scaled)[0] / areas[0], 1.0) << scale;
    }
}

TEST(FaceWeights, AreasDoNotDependOnUnusedVertices) {
    TriangleMesh mesh = octahedron();
    const std::vector<double> areas = face_areas(mesh);
    for (double far : {1e300, std::numeric_limits<double>::infinity()}) {
        mesh.positions.push_back({far, 0, 0});
        EXPECT_EQ(face_areas(mesh), areas);
    }
}

TEST(FaceWeights, ImbalanceByHand) {
    EXPECT_DOUBLE_EQ(weight_imbalance({1, 2, 3, 6}, {0, 0, 0, 1}, 2), 1.0);
    EXPECT_DOUBLE_EQ(weight_imbalance({1, 2, 3, 6}, {0, 0, 1, 1}, 2), 1.5);
}

TEST(FaceWeights, ImbalanceIsNotBelowOneByRounding) {
    const std::vector<double> weights = {1, 0.5, 0.4, 1, 0.5, 0.4, 1, 0.5, 0.4};
    EXPECT_EQ(weight_imbalance(weights, {0, 0, 0, 1, 1, 1, 2, 2, 2}, 3), 1.0);
}

TEST(FaceWeights, BadWeightsAreRefusedWithCountAndFirstFace) {
    const auto message = [](std::vector<double> weights,
                            const TriangleMesh& surface = octahedron()) -> std::string {
        PreparedMesh mesh(surface, 1);
        try {
            segment(mesh, weight_options(2, std::move(weights)));
        } catch (const InvalidOptions& error) {
            return error.what();
        }
        return "";
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double infinite = std::numeric_limits<double>::infinity();
    EXPECT_NE(
        message({1, 1, -2, 1, 1, -3, 1, 1}).find("2 of 8 are not; the first is face 2 with -2"),
        std::string::npos);
    EXPECT_NE(message({1, 1, 1, nan, 1, 1, 1, 1}).find("1 of 8 is not; the first is face 3"),
              std::string::npos);
    EXPECT_NE(message({1, 1, 1, 1, 1, 1, 1, infinite}).find("face 7 with inf"), std::string::npos);
    EXPECT_NE(message({-1, 1, 1, 1, 1, 1, 1, 1}).find("face 0 with -1"), std::string::npos);
    EXPECT_NE(message({0, 0, 0, 0, 0, 0, 0, 0}).find("weight above 0 is expected, but all 8 are 0"),
              std::string::npos);
    TriangleMesh point = octahedron();
    point.positions.assign(6, {1, 2, 3});
    EXPECT_NE(message({}, point).find("area above 0 is expected, but all 8 are 0. Correct the ver"),
              std::string::npos);
    EXPECT_EQ(message({0, 0, 0, 0, 0, 1, 0, 0}), "");
    EXPECT_NE(message({1, 2}).find("per face is expected (8), but there are 2"), std::string::npos);
}

TEST(FaceWeights, NeedTheMethodAndTheBalanceThatUseThem) {
    PreparedMesh mesh(octahedron(), 1);
    SegmentOptions options = weight_options(2, {});
    options.method = Method::all_pairs;
    EXPECT_THROW(segment(mesh, options), InvalidOptions);
    options = weight_options(2, std::vector<double>(8, 1.0));
    options.balance = Balance::triangle_count;
    EXPECT_THROW(segment(mesh, options), InvalidOptions);
}

TEST(ShareByWeight, LargestWeightPerSubmeshIsTheLeastPossible) {
    // Brute force over all shares of small cases.
    Random random(5);
    for (int round = 0; round < 200; ++round) {
        std::vector<double> weights;
        std::vector<int> face_counts;
        for (int i = 0; i < 3; ++i) {
            weights.push_back(random.below(20));
            face_counts.push_back(1 + static_cast<int>(random.below(5)));
        }
        const int most = face_counts[0] + face_counts[1] + face_counts[2];
        const int k = 3 + static_cast<int>(random.below(static_cast<std::uint32_t>(most - 2)));
        double best = 1e300;
        for (int a = 1; a <= face_counts[0]; ++a) {
            for (int b = 1; b <= face_counts[1]; ++b) {
                const int c = k - a - b;
                if (c >= 1 && c <= face_counts[2]) {
                    best =
                        std::min(best, std::max({weights[0] / a, weights[1] / b, weights[2] / c}));
                }
            }
        }
        const std::vector<int> shares = share_submeshes_by_weight(weights, face_counts, k);
        double largest = 0.0;
        for (int i = 0; i < 3; ++i) {
            EXPECT_GE(shares[i], 1);
            EXPECT_LE(shares[i], face_counts[i]);
            largest = std::max(largest, weights[i] / shares[i]);
        }
        EXPECT_EQ(std::accumulate(shares.begin(), shares.end(), 0), k);
        EXPECT_DOUBLE_EQ(largest, best);
    }
}

TEST(WeightBalance, LowerLoadsKeepsEverySubmeshSoundAndNeverRaisesABalancedOne) {
    for (std::uint64_t seed = 0; seed < 4; ++seed) {
        const Levels levels(displaced_sphere(4, 0.3, seed + 1));
        Patchwork patchwork = ragged_patchwork(levels, 40, seed);
        Random random(seed);
        std::fill(patchwork.load.begin(), patchwork.load.end(), 0);
        int total = 0;
        for (Cell& cell : patchwork.cells) {
            cell.weight = 1 + static_cast<int>(random.below(10));
            patchwork.load[cell.label] += cell.weight;
            total += cell.weight;
        }
        const int limit = total / 40 * 11 / 10;
        // A limit below the mean is out of reach.
        Patchwork stuck = patchwork;
        const int unreachable = total / 40 * 9 / 10;
        EXPECT_FALSE(lower_loads(stuck, unreachable));
        for (int l = 0; l < 40; ++l) {
            EXPECT_TRUE(patchwork.load[l] > unreachable || stuck.load[l] <= unreachable) << l;
        }
        EXPECT_TRUE(is_sound(measures_of(levels, stuck)));
        EXPECT_TRUE(lower_loads(patchwork, limit));
        std::vector<int> loads(40, 0);
        for (const Cell& cell : patchwork.cells) {
            loads[cell.label] += cell.weight;
        }
        EXPECT_EQ(loads, patchwork.load);
        EXPECT_LE(heaviest_load(patchwork), limit);
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    }
}

TEST(WeightBalance, LoweringStopsWhenTheTimeIsUpOrWhenCancelled) {
    const Levels levels(displaced_sphere(4));
    // A limit below the mean is out of reach.
    const Patchwork ragged = ragged_patchwork(levels, 400, 1);
    const int limit = levels.mesh.face_count() / 400 - 1;
    Patchwork patchwork;
    const auto reports_until = [&](const Deadline* deadline, int most) {
        int reports = 0;
        patchwork = ragged;
        EXPECT_FALSE(lower_loads(
            patchwork, limit, deadline, [&](double, const char*) { return ++reports < most; }));
        return reports;
    };
    const Deadline deadline(1e-9);
    EXPECT_GT(reports_until(nullptr, 1 << 30), 50);
    EXPECT_EQ(reports_until(&deadline, 1 << 30), 1);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
    EXPECT_THROW(reports_until(nullptr, 5), Cancelled);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
}

TEST(WeightBalance, TheFirstStepEndsWithItsTimeAndLaterOnesWithThatOfAll) {
    const Levels levels(displaced_sphere(4));
    const Patchwork ragged = ragged_patchwork(levels, 1700, 1); // three faces each: out of reach
    const auto reports_until = [&](const Deadline* deadline, const Deadline* first_deadline) {
        Patchwork patchwork = ragged;
        int reports = 0;
        AnnealControl control;
        control.deadline = deadline;
        control.progress = [&](double, const char*) { return ++reports > 0; };
        balance_by_weight(patchwork, schedule_of(10.0, 1), control, first_deadline);
        EXPECT_LE(heaviest_load(patchwork), heaviest_load(ragged));
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
        return reports;
    };
    const Deadline expired(1e-9);
    const int all = reports_until(nullptr, nullptr);
    const int first = reports_until(&expired, nullptr);
    EXPECT_GT(all, 2 * first);
    EXPECT_GT(first, 10);
    EXPECT_EQ(reports_until(&expired, &expired), 1);
}

TEST(WeightBalance, NeverRaisesTheHeaviestLoad) {
    const Levels levels(displaced_sphere(3));
    std::vector<int> weights;
    for (double weight : random_weights(levels.mesh.face_count(), 3)) {
        weights.push_back(weight == 1.0 ? 2000 : static_cast<int>(100.0 * weight));
    }
    const Multilevel weighted = levels.multilevel.with_weights(weights);
    // The mean is out of reach where so much lies on few faces.
    for (int k : {20, 50}) {
        Patchwork patchwork = weighted.coarsen(levels.mesh.face_count(), k);
        bisect(patchwork, k, 1, 1);
        repair(patchwork);
        for (int turn = 0; turn < 3; ++turn) {
            const int before = heaviest_load(patchwork);
            balance_by_weight(patchwork, schedule_of(10.0, 1), {});
            EXPECT_LE(heaviest_load(patchwork), before) << k << ", turn " << turn;
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k << ", turn " << turn;
        }
    }
}

TEST(WeightBalance, OfSeveralResultsTheBestBalancedOneIsKept) {
    TriangleMesh strip;
    strip.positions.resize(8);
    for (int i = 0; i < 6; ++i) {
        strip.faces.push_back({i, i + 1, i + 2});
    }
    const Levels levels(strip);
    ComponentTask task;
    task.submesh_count = 2;
    task.weights.assign(6, 1.0);
    const Multilevel weighted = levels.multilevel.with_weights(quantized_weights(task.weights, 2));
    BestResult best(weighted, task, 1);
    const std::vector<int> even = {0, 1, 0, 1, 0, 1};
    for (const std::vector<int>& labels :
         {std::vector<int>{0, 1, 1, 1, 1, 1}, even, std::vector<int>{0, 0, 1, 1, 1, 1}}) {
        Patchwork patchwork = weighted.coarsen(6, 2);
        weighted.set_labels(patchwork, labels);
        best.keep_if_better(patchwork, true, {});
    }
    EXPECT_EQ(best.labels(), even);
}

TEST(WeightBalance, EveryMeshIsSoundAndNearTheLeastImbalance) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        PreparedMesh prepared(mesh, 2);
        const int face_count = mesh.face_count();
        for (int k : {2, 7, face_count / 64, face_count / 20}) {
            if (k < 2 || k > face_count) {
                continue;
            }
            std::vector<double> hard = random_weights(face_count, 2);
            hard[face_count / 2] = std::accumulate(hard.begin(), hard.end(), 0.0) / 9.0;
            for (const std::vector<double>& weights :
                 {face_areas(mesh), random_weights(face_count, 1), hard}) {
                const Segmentation result = segment(prepared, weight_options(k, weights));
                EXPECT_TRUE(result.is_valid()) << name << ", k " << k;
                EXPECT_TRUE(is_sound(result.measures)) << name << ", k " << k;
                EXPECT_DOUBLE_EQ(result.weight_imbalance,
                                 weight_imbalance(weights, result.labels, k));
                // Faces can not be cut, so that one face more than the mean may be needed; in
                // stacks of slivers, nested or not, many faces hang together.
                const double ideal = ideal_over_heaviest(weights, k) *
                    *std::max_element(weights.begin(), weights.end());
                double heaviest_below = 0.0;
                for (double weight : weights) {
                    heaviest_below = std::max(heaviest_below, std::min(weight, ideal));
                }
                const double least = least_imbalance(weights, k);
                EXPECT_TRUE(result.weight_imbalance <= 1.03 * least + heaviest_below / ideal ||
                            name == "nested_slivers" || name == "slivers")
                    << result.weight_imbalance << " of " << least << ", " << name << ", k " << k;
                EXPECT_LE(result.weight_imbalance, 2.0 * least) << name << ", k " << k;
            }
        }
    }
}

TEST(WeightBalance, ExtremeWeightsGiveASoundResult) {
    const TriangleMesh mesh = icosphere(3);
    PreparedMesh prepared(mesh, 1);
    const int face_count = mesh.face_count();
    std::vector<double> one(face_count, 0.0);
    one[100] = 1.0;
    std::vector<double> huge(face_count, 1e308);
    std::vector<double> spread(face_count);
    for (int f = 0; f < face_count; ++f) {
        spread[f] = std::pow(10.0, f % 600 - 300);
    }
    std::vector<double> wider(face_count, 1e-308); // as parts of the heaviest all are 0
    wider[100] = 1e20;
    std::vector<double> half(face_count, 0.0);
    std::fill(half.begin(), half.begin() + face_count / 2, 1.0);
    for (const std::vector<double>& weights : {one, huge, spread, wider, half}) {
        for (int k : {1, 2, 30, face_count - 1, face_count}) {
            const Segmentation result = segment(prepared, weight_options(k, weights));
            EXPECT_TRUE(is_sound(result.measures)) << k;
            EXPECT_TRUE(std::isfinite(result.weight_imbalance));
            EXPECT_GE(result.weight_imbalance, 1.0 - 1e-12);
        }
    }
    EXPECT_LE(segment(prepared, weight_options(30, half)).weight_imbalance, 1.1);
}

TEST(WeightBalance, FewerHeavyFacesThanSubmeshesArePartedLikeOthers) {
    const TriangleMesh mesh = icosphere(3);
    PreparedMesh prepared(mesh, 1);
    std::vector<double> patch(mesh.face_count(), 0.0);
    std::fill(patch.begin(), patch.begin() + 60, 1.0);
    for (int k : {61, 100}) {
        const Segmentation result = segment(prepared, weight_options(k, patch));
        EXPECT_TRUE(is_sound(result.measures));
        // At most two of them together, where each alone would be k / 60.
        EXPECT_LE(result.weight_imbalance, 2.0 * k / 60.0 + 1e-9);
    }
}

TEST(WeightBalance, HugeWeightsAreWeights) {
    const TriangleMesh mesh = icosphere(3);
    PreparedMesh prepared(mesh, 1);
    std::vector<double> weights = random_weights(mesh.face_count(), 5);
    const double heaviest = *std::max_element(weights.begin(), weights.end());
    for (double& weight : weights) {
        weight *= 0x1p1023 / heaviest;
    }
    const Segmentation result = segment(prepared, weight_options(20, weights));
    EXPECT_LE(result.weight_imbalance, 1.05);
}

TEST(WeightBalance, EqualWeightsBalanceTheCounts) {
    PreparedMesh prepared(displaced_sphere(4), 1);
    const Segmentation result =
        segment(prepared, weight_options(40, std::vector<double>(5120, 0.25)));
    // 128 faces each.
    EXPECT_LE(result.measures.max_submesh_triangles, 130);
}

TEST(WeightBalance, SameLabelsForAnyThreadCountAndScaleOfTheWeights) {
    const TriangleMesh mesh = displaced_sphere(4);
    std::vector<double> weights = random_weights(mesh.face_count(), 4);
    SegmentOptions options = weight_options(70, weights);
    std::vector<int> reference;
    for (int threads : {1, 2, 3}) {
        PreparedMesh prepared(mesh, threads);
        options.thread_count = threads;
        const std::vector<int> labels = segment(prepared, options).labels;
        EXPECT_TRUE(reference.empty() || labels == reference);
        reference = labels;
    }
    for (double& weight : options.face_weights) {
        weight *= 1024.0;
    }
    PreparedMesh prepared(mesh, 1);
    EXPECT_EQ(segment(prepared, options).labels, reference);
}

TEST(WeightBalance, TheTimeLimitAndCancelHold) {
    const TriangleMesh mesh = displaced_sphere(4);
    PreparedMesh prepared(mesh, 2);
    SegmentOptions options = weight_options(80, random_weights(mesh.face_count(), 6));
    const std::vector<int> labels = segment(prepared, options).labels;
    for (double limit : {1e-9, 5e-3}) {
        options.time_limit_seconds = limit;
        const Segmentation result = segment(prepared, options);
        EXPECT_TRUE(is_sound(result.measures));
        EXPECT_TRUE(result.time_limit_hit);
    }
    options.time_limit_seconds = 0.0;
    for (int stop : {1, 5, 10}) {
        int left = stop;
        EXPECT_THROW(segment(prepared, options, [&](double, const char*) { return --left > 0; }),
                     Cancelled);
    }
    EXPECT_EQ(segment(prepared, options).labels, labels);
}

TEST(WeightBalance, ComponentsShareSubmeshesByWeight) {
    // Two equal spheres, the second three times as heavy: 10 and 30 of 40 sub-meshes.
    TriangleMesh mesh = displaced_sphere(3);
    const int half = mesh.face_count();
    append(mesh, displaced_sphere(3));
    std::vector<double> weights(2 * half, 1.0);
    std::fill(weights.begin() + half, weights.end(), 3.0);
    PreparedMesh prepared(mesh, 1);
    const Segmentation result = segment(prepared, weight_options(40, weights));
    EXPECT_TRUE(is_sound(result.measures));
    EXPECT_LE(result.weight_imbalance, 1.02);
    std::vector<int> first(result.labels.begin(), result.labels.begin() + half);
    std::sort(first.begin(), first.end());
    EXPECT_EQ(std::unique(first.begin(), first.end()) - first.begin(), 10);
}

} // namespace
} // namespace spheroseg
