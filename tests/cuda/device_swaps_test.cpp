// SPDX-License-Identifier: GPL-3.0-or-later
// The host side: memory, errors and cancelling.
#include "device_swaps.h"

#include "all_pairs_cohesion.h"
#include "all_pairs_refinement.h"
#include "cohesion_state.h"
#include "emulated_device.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

const TriangleMesh& mesh() {
    static const TriangleMesh shared = icosphere(1);
    return shared;
}

const DualGraph& graph() {
    static const DualGraph shared = build_dual_graph(mesh());
    return shared;
}

constexpr int kSubmeshCount = 6;

void run_all_pairs(SwapDevice& device, const Progress& progress = {}) {
    SwapLimits limits;
    limits.device = &device;
    limits.max_iterations = 2;
    std::vector<int> labels = random_balanced_labels(graph().face_count(), kSubmeshCount, 0);
    const std::vector<Vec3> centroids = face_centroids_on_sphere(mesh(), mesh().positions);
    cohere_all_pairs(graph(), centroids, kSubmeshCount, 0, limits, labels, progress);
    refine_all_pairs(graph(), limits, labels, progress);
}

cuda::SwapTuning small_tuning() {
    return {4, 16, 1, 400, 2};
}

TEST(DeviceSwaps, TakeTheMemoryTheyCheckFor) {
    EmulatedDevice::Log log;
    cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(log), small_tuning());
    run_all_pairs(device);
    EXPECT_EQ(log.bytes_held, 0U);
    EXPECT_EQ(log.most_bytes_held,
              std::max(cuda::cohesion_bytes(graph().face_count(), kSubmeshCount),
                       cuda::refinement_bytes(graph().face_count())));
}

TEST(DeviceSwaps, TooLittleMemoryIsAnErrorBeforeAnyIsTaken) {
    EmulatedDevice::Log log;
    auto emulated = std::make_unique<EmulatedDevice>(log);
    emulated->free_memory = std::size_t{10} << 20;
    cuda::DeviceSwaps device(std::move(emulated), small_tuning());
    try {
        run_all_pairs(device);
        FAIL() << "expected a DeviceError";
    } catch (const DeviceError& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find("found 10 MiB on emulation"), std::string::npos) << message;
        EXPECT_NE(message.find("device \"cpu\""), std::string::npos) << message;
    }
    EXPECT_EQ(log.most_bytes_held, 0U);
}

TEST(DeviceSwaps, AFailureOfAnyCallBecomesDeviceErrorAndLeaksNothing) {
    EmulatedDevice::Log whole;
    {
        cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(whole), small_tuning());
        run_all_pairs(device);
    }
    ASSERT_GT(whole.calls, 50);
    for (int failing = 1; failing <= whole.calls; ++failing) {
        EmulatedDevice::Log log;
        auto emulated = std::make_unique<EmulatedDevice>(log);
        emulated->before_call = [&](const char* call) {
            if (log.calls == failing) {
                throw DeviceError(std::string("injected into ") + call);
            }
        };
        {
            cuda::DeviceSwaps device(std::move(emulated), small_tuning());
            EXPECT_THROW(run_all_pairs(device), DeviceError) << "call " << failing;
        }
        EXPECT_EQ(log.bytes_held, 0U) << "call " << failing;
        EXPECT_EQ(log.calls, failing) << "calls after the failure";
    }
}

TEST(DeviceSwaps, CancellingAtAnyReportLeaksNothing) {
    int reports = 0;
    EmulatedDevice::Log log;
    cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(log), small_tuning());
    run_all_pairs(device, [&](double, const char*) { return ++reports > 0; });
    ASSERT_GT(reports, 4);
    for (int last = 1; last <= reports; ++last) {
        int calls = 0;
        EXPECT_THROW(run_all_pairs(device, [&](double, const char*) { return ++calls < last; }),
                     Cancelled);
        EXPECT_EQ(log.bytes_held, 0U) << "report " << last;
    }
}

TEST(DeviceSwaps, TheTimeLimitEndsThemWithBalancedLabels) {
    EmulatedDevice::Log log;
    cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(log), small_tuning());
    const Deadline deadline(1e-9);
    SwapLimits limits;
    limits.device = &device;
    limits.deadline = &deadline;
    const std::vector<int> start = random_balanced_labels(graph().face_count(), kSubmeshCount, 0);
    std::vector<int> labels = start;
    const std::vector<Vec3> centroids = face_centroids_on_sphere(mesh(), mesh().positions);
    EXPECT_TRUE(
        cohere_all_pairs(graph(), centroids, kSubmeshCount, 0, limits, labels).time_limit_hit);
    EXPECT_EQ(labels, start);
    EXPECT_TRUE(refine_all_pairs(graph(), limits, labels).time_limit_hit);
    EXPECT_EQ(labels, start);
}

TEST(DeviceSwaps, LaunchesPlayManyRoundsEach) {
    // 1,280 faces: 640 slots in blocks of 64, so that 2 launches play 32 rounds.
    const DualGraph big = build_dual_graph(icosphere(3));
    EmulatedDevice::Log log;
    cuda::SwapTuning tuning;
    tuning.min_slots_per_block = tuning.max_slots_per_block = 64;
    cuda::DeviceSwaps device(std::make_unique<EmulatedDevice>(log), tuning);
    SwapLimits limits;
    limits.device = &device;
    limits.max_iterations = 1;
    std::vector<int> labels = random_balanced_labels(1280, 20, 0);
    const TriangleMesh sphere = icosphere(3);
    const std::vector<Vec3> centroids = face_centroids_on_sphere(sphere, sphere.positions);
    cohere_all_pairs(big, centroids, 20, 0, limits, labels);
    EXPECT_EQ(log.launches, 2 * 40); // 1,279 rounds
}

} // namespace
} // namespace spheroseg
