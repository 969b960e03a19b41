// SPDX-License-Identifier: GPL-3.0-or-later
#include "warm_start.h"

#include "segment.h"
#include "soundness.h"

#include "patchwork_meshes.h"
#include "small_steps.h"
#include "thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <string_view>

namespace spheroseg {
namespace {

using namespace test;

SegmentOptions warm_options(std::vector<int> labels, Effort effort = Effort::draft) {
    SegmentOptions options;
    options.effort = effort;
    options.initial_labels = std::move(labels);
    return options;
}

double kept_share(const std::vector<int>& before, const std::vector<int>& after) {
    int kept = 0;
    for (std::size_t f = 0; f < before.size(); ++f) {
        kept += before[f] == after[f];
    }
    return kept / static_cast<double>(before.size());
}

/// Labels of the nearest of `k` random faces, by steps between neighbours: uneven, in one piece.
std::vector<int> blobs(const DualGraph& graph, int k, std::uint64_t seed) {
    Random random(seed);
    std::vector<int> labels(graph.neighbors.size(), -1);
    std::vector<int> queue;
    while (static_cast<int>(queue.size()) < k) {
        const auto face = static_cast<int>(random.below(graph.face_count()));
        if (labels[face] < 0) {
            labels[face] = static_cast<int>(queue.size());
            queue.push_back(face);
        }
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
        for (int neighbor : graph.neighbors[queue[head]]) {
            if (neighbor >= 0 && labels[neighbor] < 0) {
                labels[neighbor] = labels[queue[head]];
                queue.push_back(neighbor);
            }
        }
    }
    return labels;
}

std::vector<std::vector<int>> hostile_labels(const DualGraph& graph, int k) {
    const int face_count = graph.face_count();
    std::vector<int> random_labels(face_count);
    std::vector<int> lone(face_count, k - 1);
    std::vector<int> interleaved(face_count);
    Random random(9);
    for (int f = 0; f < face_count; ++f) {
        random_labels[f] = f < k ? f : static_cast<int>(random.below(k));
        interleaved[f] = f % k;
    }
    for (int l = 0; l + 1 < k; ++l) {
        lone[l] = l;
    }
    return {random_labels, lone, labels_by_number(face_count, k), interleaved, blobs(graph, k, 4)};
}

TEST(WarmStart, SoundSubmeshesByHand) {
    // Around an octahedron's vertex 4 lie faces; opposite ones touch in that vertex only.
    const Levels levels(octahedron());
    const int face_count = levels.mesh.face_count();
    Patchwork patchwork = levels.multilevel.coarsen(face_count, 2);
    const auto sound = [&](const std::vector<int>& labels) {
        levels.multilevel.set_labels(patchwork, labels);
        return sound_submeshes(patchwork);
    };
    EXPECT_EQ(sound(std::vector<int>(face_count, 0)), (std::vector<std::uint8_t>{1, 0}));
    for (int f = 0; f < face_count; ++f) {
        for (int g = 0; g < f; ++g) {
            std::vector<int> labels(face_count, 0);
            labels[f] = labels[g] = 1;
            const Measures measures = measure(levels.mesh, levels.graph, labels, 2, 1);
            const std::vector<std::uint8_t> result = sound(labels);
            EXPECT_EQ(result[0] && result[1],
                      measures.bowtie_count == 0 && measures.disconnected_submesh_count == 0);
        }
    }
}

TEST(WarmStart, SoundAgreesWithTheMeasuresOnRandomLabels) {
    for (const TriangleMesh& mesh : {icosphere(2), open_grid(8), bipyramid(20), torus(8, 6)}) {
        const Levels levels(mesh);
        const int face_count = mesh.face_count();
        Patchwork patchwork = levels.multilevel.coarsen(face_count, 2);
        Random random(3);
        for (int round = 0; round < 300; ++round) {
            // A blob grown at random, against the rest.
            std::vector<int> labels(face_count, 0);
            labels[random.below(face_count)] = 1;
            const int grows = static_cast<int>(random.below(4 * face_count));
            for (int i = 0; i < grows; ++i) {
                const auto f = static_cast<int>(random.below(face_count));
                const int g = levels.graph.neighbors[f][random.below(3)];
                labels[f] = g >= 0 && labels[g] == 1 ? 1 : labels[f];
            }
            const Measures measures = measure(levels.mesh, levels.graph, labels, 2, 1);
            levels.multilevel.set_labels(patchwork, labels);
            const std::vector<std::uint8_t> sound = sound_submeshes(patchwork);
            EXPECT_EQ(sound[0] && sound[1], is_sound(measures));
        }
    }
}

TEST(WarmStart, CompactingKeepsTheOrder) {
    EXPECT_EQ(compacted({7, 3, 7, 100, 3}), (std::vector<int>{1, 0, 1, 2, 0}));
    EXPECT_EQ(distinct_label_count({7, 3, 7, 100, 3}), 3);
    EXPECT_EQ(distinct_label_count({}), 0);
}

TEST(WarmStart, RenamingKeepsTheLargestOverlaps) {
    std::vector<int> labels = {2, 2, 2, 0, 0, 1, 1};
    rename_like(labels, {0, 0, 1, 1, 1, 0, 2}, 3);
    // Label 2 has two faces of name 0, label 0 two of name 1; 1 gets what is left.
    EXPECT_EQ(labels, (std::vector<int>{0, 0, 0, 1, 1, 2, 2}));
    // Faces without a name count for none.
    labels = {0, 1, 1, 0};
    rename_like(labels, {-1, 0, 0, 1}, 2);
    EXPECT_EQ(labels, (std::vector<int>{1, 0, 0, 1}));
}

TEST(WarmStart, HostileLabelsOnEveryMeshBecomeValid) {
    int run = 0;
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        PreparedMesh prepared(mesh, 2);
        const int face_count = mesh.face_count();
        // Exact balance of few faces each takes long on tubes 3 to 6 vertices around.
        const bool narrow = name == "needle" || name == "long_thin_limb";
        for (int k : {2, 7, face_count / 64, face_count / (narrow ? 64 : 5)}) {
            if (k < 2 || k > face_count) {
                continue;
            }
            int kind = 0;
            for (const std::vector<int>& labels : hostile_labels(prepared.dual_graph(), k)) {
                if (run++ % kThinning == 0) {
                    const Segmentation result = segment(prepared, warm_options(labels));
                    EXPECT_TRUE(result.is_valid()) << name << ", k " << k << ", kind " << kind;
                    EXPECT_EQ(result.measures.submesh_count, k);
                }
                ++kind;
            }
        }
    }
}

TEST(WarmStart, OpenMeshesHandlesAndComponentsToo) {
    TriangleMesh three = displaced_sphere(2);
    for (const TriangleMesh& other : {open_grid(10), torus(10, 6)}) {
        append(three, other);
    }
    for (const TriangleMesh& mesh : {open_grid(20), torus(20, 12), three}) {
        PreparedMesh prepared(mesh, 1);
        for (int k : {3, 20, 60}) {
            for (const std::vector<int>& labels : hostile_labels(prepared.dual_graph(), k)) {
                const std::vector<int> filled = [&] {
                    // Blobs reach only the components that have a seed.
                    std::vector<int> copy = labels;
                    std::replace(copy.begin(), copy.end(), -1, 0);
                    return copy;
                }();
                const Segmentation result = segment(prepared, warm_options(filled));
                EXPECT_TRUE(result.is_valid()) << mesh.face_count() << " faces, k " << k;
                EXPECT_EQ(result.measures.submesh_count, distinct_label_count(filled));
            }
        }
    }
}

TEST(WarmStart, ValidLabelsDoNotGetWorseAndKeepTheirNumbers) {
    for (const TriangleMesh& mesh :
         {displaced_sphere(4), limbed_figure(3), open_grid(30), torus(30, 20)}) {
        PreparedMesh prepared(mesh, 2);
        for (Effort effort : {Effort::draft, Effort::standard, Effort::high}) {
            SegmentOptions options;
            options.submesh_count = 30;
            options.effort = effort;
            const Segmentation cold = segment(prepared, options);
            ASSERT_TRUE(cold.is_valid());
            for (Effort again : {Effort::draft, Effort::standard}) {
                const Segmentation warm = segment(prepared, warm_options(cold.labels, again));
                EXPECT_TRUE(warm.is_valid());
                EXPECT_LE(warm.measures.boundary_edge_count, cold.measures.boundary_edge_count);
                EXPECT_GE(kept_share(cold.labels, warm.labels), 0.5);
                if (warm.measures.boundary_edge_count == cold.measures.boundary_edge_count) {
                    EXPECT_EQ(warm.labels, cold.labels);
                }
            }
        }
    }
}

/// Gives so many random faces at a boundary the label beyond it.
void change_sides(std::vector<int>& labels, const DualGraph& graph, int count, std::uint64_t seed) {
    Random random(seed);
    while (count > 0) {
        const auto face = static_cast<int>(random.below(graph.face_count()));
        const int neighbor = graph.neighbors[face][random.below(3)];
        if (neighbor >= 0 && labels[neighbor] != labels[face]) {
            labels[face] = labels[neighbor];
            --count;
        }
    }
}

void expect_little_change(const TriangleMesh& mesh, int k) {
    SCOPED_TRACE(k);
    PreparedMesh prepared(mesh, 2);
    SegmentOptions options;
    options.submesh_count = k;
    options.effort = Effort::high;
    const Segmentation first = segment(prepared, options);
    ASSERT_TRUE(first.is_valid());
    for (Effort effort : {Effort::draft, Effort::standard}) {
        // A face at a narrow place may cut a sub-mesh, so that there is more to mend: means.
        double boundary = 0.0;
        double kept = 0.0;
        for (std::uint64_t seed = 0; seed < 5; ++seed) {
            std::vector<int> changed = first.labels;
            change_sides(changed, prepared.dual_graph(), 6, seed);
            const Segmentation again = segment(prepared, warm_options(changed, effort));
            EXPECT_TRUE(again.is_valid());
            boundary += 0.2 * static_cast<double>(again.measures.boundary_edge_count);
            kept += 0.2 * kept_share(first.labels, again.labels);
        }
        EXPECT_LE(boundary, 1.01 * static_cast<double>(first.measures.boundary_edge_count));
        EXPECT_GE(kept, 0.95);
    }
}

TEST(WarmStart, AFewFacesThatChangeSidesLeaveTheRestAsItIs) {
    for (const TriangleMesh& mesh :
         {displaced_sphere(4), limbed_figure(3), open_grid(30), torus(30, 20)}) {
        expect_little_change(mesh, 30);
    }
    // Of six or seven faces, so that the mean is far from both.
    expect_little_change(displaced_sphere(4), 788);
}

/// Three faces in a row, and three around a vertex; the second one comes first when `swapped`.
TriangleMesh row_and_fan(bool swapped) {
    TriangleMesh mesh;
    for (int v = 0; v < 9; ++v) {
        mesh.positions.push_back({1.0 * v, 1.0 * (v % 2), 1.0 * (v % 3)});
    }
    mesh.faces = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {5, 6, 8}, {6, 7, 8}, {7, 5, 8}};
    if (swapped) {
        std::rotate(mesh.faces.begin(), mesh.faces.begin() + 3, mesh.faces.end());
    }
    return mesh;
}

TEST(WarmStart, NumbersAreKeptByOtherStartsAndByTheSearchToo) {
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const int face_count = 60 + 18 * static_cast<int>(seed);
        PreparedMesh prepared(random_tree(face_count, seed), 1);
        for (int k : {face_count / 2, face_count / 3}) {
            SegmentOptions options;
            options.submesh_count = k;
            options.effort = Effort::draft;
            // Labels that are valid where such exist, numbered the other way round; then six faces
            // change sides.
            std::vector<int> labels = segment(prepared, options).labels;
            for (int& label : labels) {
                label = k - 1 - label;
            }
            change_sides(labels, prepared.dual_graph(), 6, seed);
            options.initial_labels = compacted(labels);
            const Segmentation result = segment(prepared, options);
            std::vector<int> renamed = result.labels;
            rename_like(renamed, options.initial_labels, result.measures.submesh_count);
            EXPECT_EQ(result.labels, renamed) << face_count << " faces, k " << k;
        }
    }
}

TEST(WarmStart, ValidLabelsMayShareSubmeshesOutInAnotherWay) {
    // Of three sub-meshes either component may have two; cutting the row costs one boundary edge,
    // the fan two.
    for (bool swapped : {false, true}) {
        PreparedMesh prepared(row_and_fan(swapped), 1);
        const std::vector<int> labels =
            swapped ? std::vector<int>{0, 0, 0, 1, 1, 2} : std::vector<int>{0, 0, 1, 2, 2, 2};
        for (Balance balance : {Balance::triangle_count, Balance::weight}) {
            SegmentOptions options = warm_options(labels);
            options.balance = balance;
            if (balance == Balance::weight) {
                options.face_weights.assign(6, 1.0);
            }
            const Segmentation result = segment(prepared, options);
            EXPECT_TRUE(result.is_valid());
            EXPECT_EQ(result.measures.boundary_edge_count, 1);
            EXPECT_EQ(result.labels, labels);
        }
    }
}

TEST(WarmStart, LabelsWithGapsAreCompactedInOrder) {
    PreparedMesh prepared(displaced_sphere(3), 1);
    SegmentOptions options;
    options.submesh_count = 12;
    options.effort = Effort::high;
    std::vector<int> labels = segment(prepared, options).labels;
    SegmentOptions with_gaps = warm_options(labels);
    for (int& label : with_gaps.initial_labels) {
        label = 1000 * label + 5;
    }
    // Neither is used.
    with_gaps.submesh_count = 77;
    with_gaps.triangles_per_submesh = 3;
    const Segmentation result = segment(prepared, with_gaps);
    EXPECT_EQ(result.measures.submesh_count, 12);
    EXPECT_EQ(result.labels, segment(prepared, warm_options(labels)).labels);
}

TEST(WarmStart, BadLabelsAreRefused) {
    PreparedMesh prepared(octahedron(), 1);
    EXPECT_THROW(segment(prepared, warm_options({0, 1})), InvalidOptions);
    EXPECT_THROW(segment(prepared, warm_options({0, 1, 0, 1, -1, 0, 1, 0})), InvalidOptions);
    SegmentOptions options = warm_options({0, 1, 0, 1, 0, 0, 1, 0});
    options.method = Method::all_pairs;
    EXPECT_THROW(segment(prepared, options), InvalidOptions);
}

TEST(WarmStart, SameLabelsForAnyThreadCount) {
    const TriangleMesh mesh = displaced_sphere(4);
    std::vector<int> reference;
    for (int threads : {1, 2, 3}) {
        PreparedMesh prepared(mesh, threads);
        SegmentOptions options = warm_options(blobs(prepared.dual_graph(), 60, 2));
        options.thread_count = threads;
        const std::vector<int> labels = segment(prepared, options).labels;
        EXPECT_TRUE(reference.empty() || labels == reference);
        reference = labels;
    }
}

TEST(WarmStart, TheTimeLimitAndCancelHold) {
    const TriangleMesh mesh = displaced_sphere(4);
    PreparedMesh prepared(mesh, 2);
    SegmentOptions options = warm_options(blobs(prepared.dual_graph(), 60, 2));
    const std::vector<int> labels = segment(prepared, options).labels;
    options.time_limit_seconds = 1e-9;
    EXPECT_TRUE(segment(prepared, options).is_valid());
    options.time_limit_seconds = 0.0;
    for (int stop : {1, 4, 10}) {
        int left = stop;
        EXPECT_THROW(segment(prepared, options, [&](double, const char*) { return --left > 0; }),
                     Cancelled);
    }
    EXPECT_EQ(segment(prepared, options).labels, labels);
}

TEST(WarmStart, ASubmeshThatIsThreeTimesTooHeavyIsPartedEvenlyInItsPlace) {
    const Levels levels(open_grid(16));
    const int face_count = levels.mesh.face_count();
    Patchwork patchwork = levels.multilevel.coarsen(face_count, 4);
    // The last quarter of the rows is sub-mesh 2, all others are 1; 0 and 3 are empty.
    std::vector<int> labels(face_count, 1);
    std::fill(labels.begin() + face_count / 4 * 3, labels.end(), 2);
    levels.multilevel.set_labels(patchwork, labels);
    adopt_labels(patchwork, 1);
    const std::vector<int> adopted = levels.multilevel.labels(patchwork);
    for (int f = 0; f < face_count; ++f) {
        EXPECT_EQ(adopted[f] == 2, labels[f] == 2);
    }
    EXPECT_EQ(patchwork.load, std::vector<int>(4, face_count / 4));
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
}

TEST(WarmStart, CancelIsHeardWhileASubmeshIsParted) {
    const Levels levels(displaced_sphere(5));
    // All faces are in one sub-mesh of 40.
    const Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 40);
    int cuts = 0;
    const auto count_cuts = [&](double value, const char* step) {
        EXPECT_EQ(value, 0.0) << step;
        cuts += std::string_view(step) == "Bisection";
        return true;
    };
    Patchwork whole = patchwork;
    adopt_labels(whole, 1, count_cuts);
    ASSERT_GE(cuts, 2);
    for (int stop = 1; stop <= cuts; ++stop) {
        int left = stop;
        Patchwork cut_short = patchwork;
        EXPECT_THROW(adopt_labels(cut_short,
                                  1,
                                  [&](double, const char* step) {
                                      left -= std::string_view(step) == "Bisection";
                                      return left > 0;
                                  }),
                     Cancelled);
    }
}

TEST(WarmStart, ProgressRisesInSmallSteps) {
    const TriangleMesh mesh = displaced_sphere(4);
    PreparedMesh first(mesh, 1);
    for (int k : {10, 60}) {
        SegmentOptions options;
        options.submesh_count = k;
        options.effort = Effort::draft;
        const std::vector<int> good = segment(first, options).labels;
        for (const std::vector<int>& labels : {good, blobs(first.dual_graph(), k, 2)}) {
            for (Balance balance : {Balance::triangle_count, Balance::weight}) {
                PreparedMesh prepared(mesh, 1);
                options = warm_options(labels, Effort::standard);
                options.balance = balance;
                options.thread_count = 1;
                SCOPED_TRACE(k);
                expect_small_steps(prepared, options);
            }
        }
    }
}

TEST(WarmStart, GoesTogetherWithWeights) {
    const TriangleMesh mesh = displaced_sphere(4);
    PreparedMesh prepared(mesh, 2);
    SegmentOptions options = warm_options(blobs(prepared.dual_graph(), 50, 2));
    options.balance = Balance::weight;
    const Segmentation first = segment(prepared, options);
    EXPECT_TRUE(is_sound(first.measures));
    EXPECT_LE(first.weight_imbalance, 1.02);
    options.initial_labels = first.labels;
    const Segmentation second = segment(prepared, options);
    EXPECT_TRUE(is_sound(second.measures));
    EXPECT_LE(second.weight_imbalance, first.weight_imbalance + 0.001);
}

} // namespace
} // namespace spheroseg
