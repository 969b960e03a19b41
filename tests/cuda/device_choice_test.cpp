// SPDX-License-Identifier: GPL-3.0-or-later
#include "device_swaps.h"
#include "segment.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

std::string device_error(PreparedMesh& mesh, const SegmentOptions& options) {
    try {
        segment(mesh, options);
    } catch (const DeviceError& error) {
        return error.what();
    }
    return "";
}

TEST(DeviceChoice, CudaWithoutADeviceSaysWhyAndAutoFallsBackSilently) {
    const cuda::DeviceSearch search = cuda::find_device();
    if (search.device) {
        GTEST_SKIP() << "this machine has a usable device, " << search.device->info().name;
    }
    EXPECT_FALSE(search.reason.empty());
    PreparedMesh mesh(icosphere(2));
    SegmentOptions options;
    for (Method method : {Method::all_pairs, Method::fast}) {
        options.method = method;
        options.device = Device::cuda;
        const std::string error = device_error(mesh, options);
        EXPECT_NE(error.find(search.reason), std::string::npos) << error;
        EXPECT_NE(error.find("\"auto\" or \"cpu\""), std::string::npos) << error;
        if (!cuda::built_with_cuda()) {
            EXPECT_NE(error.find("SPHEROSEG_CUDA=ON"), std::string::npos) << error;
        }
        options.device = Device::automatic;
        EXPECT_FALSE(segment(mesh, options).used_cuda);
    }
}

TEST(DeviceChoice, AutoGivesTheLabelsOfTheCoresAboveTheSizeThatLooksForADevice) {
    PreparedMesh mesh(displaced_sphere(5, 0.1));
    ASSERT_GE(mesh.mesh().face_count(), cuda::kLeastFacesForDevice);
    SegmentOptions options;
    options.method = Method::all_pairs;
    options.max_cohesion_iterations = 1;
    options.max_refinement_iterations = 1;
    options.submesh_count = 20;
    const std::vector<int> labels = segment(mesh, options).labels;
    options.device = Device::cpu;
    EXPECT_EQ(segment(mesh, options).labels, labels);
}

} // namespace
} // namespace spheroseg
