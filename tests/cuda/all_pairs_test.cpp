// SPDX-License-Identifier: GPL-3.0-or-later
// The kernels against the engine's own cores, by emulation: labels and every number of the
// iterations must be the same.
#include "all_pairs_cohesion.h"
#include "all_pairs_refinement.h"
#include "cohesion_state.h"
#include "device_swaps.h"
#include "emulated_device.h"
#include "mesh_file.h"
#include "segment.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

struct Settings {
    unsigned int threads = 32;
    unsigned long long order_seed = 0;
    cuda::SwapTuning tuning{8, 64, 3, 20000, 4};
};

struct Run {
    std::vector<int> labels;
    SwapIterations cohesion;
    SwapIterations refinement;
    std::vector<int> cohesion_labels;
};

/// Cohesion, then refinement; on the cores when `device` is null.
Run run_all_pairs(const DualGraph& graph,
                  const std::vector<Vec3>& centroids,
                  int k,
                  std::uint64_t seed,
                  SwapDevice* device,
                  int max_iterations = 0) {
    Run run;
    SwapLimits limits;
    limits.thread_count = 1;
    limits.device = device;
    limits.max_iterations = max_iterations;
    run.labels = random_balanced_labels(graph.face_count(), k, seed);
    run.cohesion = cohere_all_pairs(graph, centroids, k, seed, limits, run.labels);
    run.cohesion_labels = run.labels;
    run.refinement = refine_all_pairs(graph, limits, run.labels);
    return run;
}

/// Points at random places of the sphere, not those of a mesh: cohesion looks at nothing else, and
/// so the number of faces may be odd.
std::vector<Vec3> random_directions(int count, std::uint64_t seed) {
    Random random(seed);
    std::vector<Vec3> points;
    for (int i = 0; i < count; ++i) {
        const Vec3 p{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
        points.push_back(p * (1.0 / length(p)));
    }
    return points;
}

void expect_same_run(const Run& expected, const Run& found) {
    EXPECT_EQ(found.cohesion_labels, expected.cohesion_labels);
    EXPECT_EQ(found.cohesion.swaps, expected.cohesion.swaps);
    EXPECT_EQ(found.cohesion.energy, expected.cohesion.energy);
    EXPECT_EQ(found.cohesion.boundary_edges, expected.cohesion.boundary_edges);
    EXPECT_EQ(found.labels, expected.labels);
    EXPECT_EQ(found.refinement.swaps, expected.refinement.swaps);
    EXPECT_EQ(found.refinement.energy, expected.refinement.energy);
    EXPECT_EQ(found.refinement.boundary_edges, expected.refinement.boundary_edges);
}

void expect_same_labels(const TriangleMesh& mesh,
                        const std::vector<Vec3>& centroids,
                        int k,
                        std::uint64_t seed,
                        const Settings& settings = {},
                        int max_iterations = 0) {
    const DualGraph graph = build_dual_graph(mesh);
    EmulatedDevice::Log log;
    {
        auto emulated = std::make_unique<EmulatedDevice>(log);
        emulated->threads = settings.threads;
        emulated->order_seed = settings.order_seed;
        cuda::DeviceSwaps device(std::move(emulated), settings.tuning);
        const Run expected = run_all_pairs(graph, centroids, k, seed, nullptr, max_iterations);
        const Run found = run_all_pairs(graph, centroids, k, seed, &device, max_iterations);
        expect_same_run(expected, found);
        EXPECT_GT(log.launches, 0);
    }
    EXPECT_EQ(log.bytes_held, 0U);
}

TEST(EmulatedAllPairs, LabelsAreThoseOfTheCores) {
    for (const TriangleMesh& mesh :
         {tetrahedron(), icosphere(1), icosphere(2), bipyramid(77), long_thin_limb(7, 21)}) {
        for (int k : {1, 2, 7, 40}) {
            for (std::uint64_t seed : {0, 5}) {
                if (k <= mesh.face_count()) {
                    SCOPED_TRACE(std::to_string(mesh.face_count()) +
                                 " faces, k = " + std::to_string(k));
                    if (seed == 0) {
                        expect_same_labels(mesh, random_directions(mesh.face_count(), 1), k, seed);
                    }
                    expect_same_labels(
                        mesh, face_centroids_on_sphere(mesh, mesh.positions), k, seed);
                }
            }
        }
    }
}

TEST(EmulatedAllPairs, LabelsAreThoseOfTheCoresOnTheSmallSampleMeshes) {
    for (const char* name : {"cube.obj", "flat_leaf.ply", "sliver_rod.ply", "spindle.ply"}) {
        PreparedMesh mesh(MeshFile::read(std::string(SPHEROSEG_SAMPLE_MESHES) + "/" + name));
        const std::vector<Vec3> centroids =
            face_centroids_on_sphere(mesh.mesh(), mesh.parametrization().positions);
        for (int k : {5, 12, 200}) {
            SCOPED_TRACE(std::string(name) + ", k = " + std::to_string(k));
            if (k <= mesh.mesh().face_count()) {
                expect_same_labels(mesh.mesh(), centroids, k, k, {}, 2);
            }
        }
    }
}

TEST(EmulatedAllPairs, NeitherThreadsNorTilesNorTheirOrderMatter) {
    const TriangleMesh mesh = icosphere(2);
    const std::vector<Vec3> centroids = face_centroids_on_sphere(mesh, mesh.positions);
    for (unsigned int threads : {1, 3, 32, 100}) {
        for (int slots : {1, 5, 31, 1000}) {
            Settings settings;
            settings.threads = threads;
            settings.order_seed = threads * 1000 + slots;
            settings.tuning.min_slots_per_block = slots;
            settings.tuning.max_slots_per_block = slots;
            settings.tuning.pairs_per_batch = 1000 + 100 * slots;
            SCOPED_TRACE(std::to_string(threads) + " threads, " + std::to_string(slots) +
                         " slots per block");
            expect_same_labels(mesh, centroids, 12, 3, settings, 2);
        }
    }
}

TEST(EmulatedAllPairs, RefinementOfRandomLabelsYieldsAsOnTheCores) {
    // Without cohesion many pairs of a round want to swap near each other.
    for (int k : {2, 3, 20, 300}) {
        const DualGraph graph = build_dual_graph(displaced_sphere(3));
        std::vector<int> expected = random_balanced_labels(graph.face_count(), k, 1);
        std::vector<int> found = expected;
        SwapLimits limits;
        const SwapIterations on_cores = refine_all_pairs(graph, limits, expected);
        EmulatedDevice::Log log;
        cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(log), Settings{}.tuning);
        limits.device = &device;
        const SwapIterations on_device = refine_all_pairs(graph, limits, found);
        EXPECT_EQ(found, expected) << k;
        EXPECT_EQ(on_device.swaps, on_cores.swaps) << k;
    }
}

TEST(EmulatedAllPairs, OddCountsOfFaces) {
    // Cohesion alone: no closed mesh has an odd number of faces.
    for (int face_count : {2, 3, 5, 7, 101}) {
        DualGraph graph;
        graph.neighbors.assign(face_count, {-1, -1, -1});
        const std::vector<Vec3> centroids = random_directions(face_count, 4);
        for (int k : {2, 9, 50}) {
            for (int slots : {1, 4, 23}) {
                if (k > face_count) {
                    continue;
                }
                std::vector<int> expected = random_balanced_labels(face_count, k, 8);
                std::vector<int> found = expected;
                SwapLimits limits;
                const SwapIterations on_cores =
                    cohere_all_pairs(graph, centroids, k, 8, limits, expected);
                EmulatedDevice::Log log;
                cuda::SwapTuning tuning;
                tuning.min_slots_per_block = tuning.max_slots_per_block = slots;
                cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(log), tuning);
                limits.device = &device;
                const SwapIterations on_device =
                    cohere_all_pairs(graph, centroids, k, 8, limits, found);
                EXPECT_EQ(found, expected) << face_count << " faces, k = " << k;
                EXPECT_EQ(on_device.swaps, on_cores.swaps);
                EXPECT_EQ(on_device.energy, on_cores.energy);
            }
        }
    }
}

} // namespace
} // namespace spheroseg
