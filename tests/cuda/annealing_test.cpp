// SPDX-License-Identifier: GPL-3.0-or-later
// The annealing of `fast` on a device against the engine's own cores, by emulation: labels, loads
// and boundary edges of every phase must be the same.
#include "anneal.h"
#include "balance.h"
#include "component_segmentation.h"
#include "device_groups.h"
#include "emulated_device.h"
#include "patchwork_meshes.h"
#include "segment.h"
#include "weight_balance.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

AnnealSchedule schedule_of(double proposals, std::uint64_t seed) {
    AnnealSchedule schedule;
    schedule.proposals_per_face = proposals;
    schedule.phase_count = 4;
    schedule.thread_count = 2;
    schedule.seed = seed;
    return schedule;
}

struct Outcome {
    std::vector<int> annealed;
    std::vector<int> labels;
    std::vector<int> load;
    std::vector<double> boundary_edges;
};

/// Annealing with free loads, exact balance, annealing with bounded loads, also in rounds; on the
/// cores when `device` is null.
Outcome run_annealings(const Levels& levels, int k, std::uint64_t seed, AnnealDevice* device) {
    Patchwork patchwork = ragged_patchwork(levels, k, seed);
    Outcome run;
    History history;
    AnnealControl control;
    control.device = device;
    control.history = &history;
    anneal(patchwork, schedule_of(30, seed), control);
    run.annealed = cell_labels(patchwork);
    EXPECT_TRUE(balance_exactly(patchwork));
    anneal_balanced(patchwork, schedule_of(30, seed), control);
    AnnealSchedule rounds = schedule_of(10, seed + 2);
    rounds.round_count = 3;
    anneal_balanced(patchwork, rounds, control);
    anneal_below(patchwork, heaviest_load(patchwork) + 2, schedule_of(10, seed + 1), control);
    run.labels = cell_labels(patchwork);
    run.load = patchwork.load;
    run.boundary_edges = std::move(history.boundary_edges);
    return run;
}

void expect_same(const Outcome& expected, const Outcome& found) {
    EXPECT_EQ(found.annealed, expected.annealed);
    EXPECT_EQ(found.labels, expected.labels);
    EXPECT_EQ(found.load, expected.load);
    EXPECT_EQ(found.boundary_edges, expected.boundary_edges);
}

std::unique_ptr<EmulatedDevice> emulated_device(EmulatedDevice::Log& log, unsigned int threads) {
    auto device = std::make_unique<EmulatedDevice>(log);
    device->threads = threads;
    device->order_seed = threads;
    return device;
}

TEST(EmulatedAnnealing, LabelsAreThoseOfTheCoresForAnyThreadsOfABlock) {
    for (const TriangleMesh& mesh : {displaced_sphere(3), torus(40, 16), grid_with_holes(24)}) {
        const Levels levels(mesh);
        // 80 sub-meshes are three groups and more.
        for (int k : {2, 80}) {
            const Outcome expected = run_annealings(levels, k, 4, nullptr);
            for (unsigned int threads : {1, 5, 32}) {
                SCOPED_TRACE(std::to_string(mesh.face_count()) + " faces, k = " +
                             std::to_string(k) + ", " + std::to_string(threads) + " threads");
                EmulatedDevice::Log log;
                {
                    cuda::DeviceAnnealing device(emulated_device(log, threads));
                    expect_same(expected, run_annealings(levels, k, 4, &device));
                    EXPECT_EQ(log.launches, 24);
                }
                EXPECT_EQ(log.bytes_held, 0U);
            }
        }
    }
}

Segmentation segment_with(PreparedMesh& mesh, const SegmentOptions& options, AnnealDevice* device) {
    return segment_fast(mesh, options, Deadline(0), {}, device);
}

TEST(EmulatedAnnealing, FastMakesTheSameLabelsOnADevice) {
    TriangleMesh two = displaced_sphere(3);
    append(two, icosphere(2));
    for (const TriangleMesh& mesh : {displaced_sphere(4), open_grid(20), two}) {
        PreparedMesh prepared(mesh);
        for (int k : {3, 100}) {
            for (Effort effort : {Effort::draft, Effort::standard}) {
                SegmentOptions options;
                options.submesh_count = k;
                options.effort = effort;
                EmulatedDevice::Log log;
                cuda::DeviceAnnealing device(emulated_device(log, 32));
                const Segmentation expected = segment_with(prepared, options, nullptr);
                const Segmentation found = segment_with(prepared, options, &device);
                EXPECT_EQ(found.labels, expected.labels);
                EXPECT_EQ(found.boundary_edges_by_iteration, expected.boundary_edges_by_iteration);
                EXPECT_FALSE(expected.used_cuda);
                // Small components of several stay on the cores.
                EXPECT_EQ(found.used_cuda, prepared.report().component_count == 1);
                EXPECT_EQ(found.used_cuda, log.launches > 0);
            }
        }
    }
}

TEST(EmulatedAnnealing, WeightedLevelsAndInitialLabelsToo) {
    PreparedMesh prepared(displaced_sphere(3));
    SegmentOptions options;
    options.submesh_count = 60;
    options.balance = Balance::weight;
    for (bool with_labels : {false, true}) {
        if (with_labels) {
            options.balance = Balance::triangle_count;
            for (int f = 0; f < prepared.mesh().face_count(); ++f) {
                options.initial_labels.push_back(f % 60);
            }
        }
        EmulatedDevice::Log log;
        cuda::DeviceAnnealing device(emulated_device(log, 32));
        EXPECT_EQ(segment_with(prepared, options, &device).labels,
                  segment_with(prepared, options, nullptr).labels);
        EXPECT_GT(log.launches, 0);
    }
}

TEST(EmulatedAnnealing, IsReportedWhereABetterStartCameFromTheCores) {
    PreparedMesh prepared(displaced_sphere(3));
    SegmentOptions options;
    options.submesh_count = 2;
    options.effort = Effort::high;
    EmulatedDevice::Log log;
    cuda::DeviceAnnealing device(emulated_device(log, 32));
    EXPECT_FALSE(device.was_used());
    EXPECT_TRUE(segment_with(prepared, options, &device).used_cuda);
    EXPECT_GT(log.launches, 0);
}

const Levels& small_levels() {
    static const Levels levels(icosphere(2));
    return levels;
}

void anneal_small(AnnealDevice& device, const Progress& progress = {}) {
    Patchwork patchwork = ragged_patchwork(small_levels(), 50, 1);
    AnnealControl control;
    control.device = &device;
    control.progress = progress;
    anneal(patchwork, schedule_of(4, 1), control);
    anneal_below(patchwork, 40, schedule_of(4, 1), control);
}

TEST(DeviceAnnealing, TakesTheMemoryItChecksFor) {
    EmulatedDevice::Log log;
    cuda::DeviceAnnealing device(emulated_device(log, 4));
    const int face_count = small_levels().mesh.face_count();
    device.begin_groups(ragged_patchwork(small_levels(), 50, 1), false, 1);
    EXPECT_EQ(log.most_bytes_held, cuda::annealing_bytes(face_count, 50, false));
    device.begin_groups(ragged_patchwork(small_levels(), 50, 1), true, 1);
    EXPECT_EQ(log.most_bytes_held, cuda::annealing_bytes(face_count, 50, true));
    EXPECT_EQ(log.bytes_held, 0U);
}

TEST(DeviceAnnealing, TooLittleMemoryIsAnErrorBeforeAnyIsTaken) {
    EmulatedDevice::Log log;
    auto emulated = emulated_device(log, 4);
    emulated->free_memory = std::size_t{1} << 20;
    cuda::DeviceAnnealing device(std::move(emulated));
    EXPECT_THROW(anneal_small(device), DeviceError);
    EXPECT_EQ(log.most_bytes_held, 0U);
}

TEST(DeviceAnnealing, AFailureOfAnyCallBecomesDeviceErrorAndLeaksNothing) {
    EmulatedDevice::Log whole;
    {
        cuda::DeviceAnnealing device(emulated_device(whole, 4));
        anneal_small(device);
    }
    ASSERT_GT(whole.calls, 100);
    for (int failing = 1; failing <= whole.calls; ++failing) {
        EmulatedDevice::Log log;
        auto emulated = emulated_device(log, 4);
        emulated->before_call = [&](const char* call) {
            if (log.calls == failing) {
                throw DeviceError(std::string("injected into ") + call);
            }
        };
        {
            cuda::DeviceAnnealing device(std::move(emulated));
            EXPECT_THROW(anneal_small(device), DeviceError) << "call " << failing;
        }
        EXPECT_EQ(log.bytes_held, 0U) << "call " << failing;
        EXPECT_EQ(log.calls, failing) << "calls after the failure";
    }
}

TEST(DeviceAnnealing, CancellingBetweenPhasesLeaksNothing) {
    for (int last = 1; last <= 8; ++last) {
        EmulatedDevice::Log log;
        cuda::DeviceAnnealing device(emulated_device(log, 4));
        int calls = 0;
        EXPECT_THROW(anneal_small(device, [&](double, const char*) { return ++calls < last; }),
                     Cancelled);
        EXPECT_EQ(log.bytes_held, 0U) << "report " << last;
    }
}

} // namespace
} // namespace spheroseg
