// SPDX-License-Identifier: GPL-3.0-or-later
// On a real GPU: skipped, with the reason, where there is none.
#include "device_swaps.h"
#include "segment.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

class Gpu : public testing::Test {
protected:
    void SetUp() override {
        const cuda::DeviceSearch search = cuda::find_device();
        if (!search.device) {
            GTEST_SKIP() << "no GPU: " << search.reason;
        }
    }
};

Segmentation segment_on(Device device, PreparedMesh& mesh, int k, std::uint64_t seed) {
    SegmentOptions options;
    options.method = Method::all_pairs;
    options.device = device;
    options.submesh_count = k;
    options.seed = seed;
    return segment(mesh, options);
}

TEST_F(Gpu, LabelsAreThoseOfTheCores) {
    for (const TriangleMesh& mesh : {tetrahedron(),
                                     icosphere(2),
                                     bipyramid(77),
                                     long_thin_limb(7, 210),
                                     displaced_sphere(4),
                                     limbed_figure(5)}) {
        PreparedMesh prepared(mesh);
        for (int k : {1, 3, 40, 200}) {
            for (std::uint64_t seed : {0, 1}) {
                if (k > mesh.face_count()) {
                    continue;
                }
                SCOPED_TRACE(std::to_string(mesh.face_count()) +
                             " faces, k = " + std::to_string(k));
                const Segmentation expected = segment_on(Device::cpu, prepared, k, seed);
                const Segmentation found = segment_on(Device::cuda, prepared, k, seed);
                EXPECT_TRUE(found.used_cuda);
                EXPECT_EQ(found.labels, expected.labels);
                EXPECT_EQ(found.energy_by_iteration, expected.energy_by_iteration);
                EXPECT_EQ(found.boundary_edges_by_iteration, expected.boundary_edges_by_iteration);
            }
        }
    }
}

TEST_F(Gpu, FastMakesTheLabelsOfTheCores) {
    for (const TriangleMesh& mesh : {displaced_sphere(4), torus(60, 40), open_grid(60)}) {
        PreparedMesh prepared(mesh);
        for (int k : {2, 60, 400}) {
            for (Effort effort : {Effort::draft, Effort::standard, Effort::high}) {
                SegmentOptions options;
                options.submesh_count = k;
                options.effort = effort;
                options.device = Device::cpu;
                const Segmentation expected = segment(prepared, options);
                options.device = Device::cuda;
                const Segmentation found = segment(prepared, options);
                EXPECT_TRUE(found.used_cuda);
                EXPECT_EQ(found.labels, expected.labels) << mesh.face_count() << " faces, k " << k;
            }
        }
    }
}

TEST_F(Gpu, CancellingGivesTheMemoryBack) {
    PreparedMesh prepared(displaced_sphere(5));
    segment_on(Device::cuda, prepared, 100, 0); // the context and its own memory are there now
    const std::size_t free_before = cuda::find_device().device->free_bytes();
    SegmentOptions options;
    options.method = Method::all_pairs;
    options.device = Device::cuda;
    int calls = 0;
    EXPECT_THROW(
        segment(prepared,
                options,
                [&](double fraction, const char*) { return fraction < 0.3 && ++calls < 1000; }),
        Cancelled);
    EXPECT_EQ(cuda::find_device().device->free_bytes(), free_before);
}

} // namespace
} // namespace spheroseg
