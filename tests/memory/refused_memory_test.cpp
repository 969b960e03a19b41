// SPDX-License-Identifier: GPL-3.0-or-later
// Every allocation of the engine is refused once: nothing ends the program, nothing leaks (a
// sanitizer build sees that), and the mesh can be used afterwards.
#include "refusing_allocator.h"
#include "segment.h"

#include "../engine/test_meshes.h"

#include <gtest/gtest.h>

#include <string>

namespace spheroseg {
namespace {

using namespace test;

/// Calls `work(number)` with the allocation of that number refused, for each of the first `dense`
/// ones and then ever fewer until none was. `work` ends with `stop_refusing` and returns what that
/// said.
template <typename Work> void refuse_each_allocation(Work work, int dense = 50) {
    long long number = 0;
    while (work(number)) {
        number += 1 + number / dense;
    }

    EXPECT_GT(number, 20);
}

struct RefusedMemory : testing::TestWithParam<SegmentOptions> {};

/// Returns how many refusals were errors.
int refuse_in_segmentations(const TriangleMesh& mesh, const SegmentOptions& options, int dense) {
    PreparedMesh reference(mesh, 2);
    const std::vector<int> expected = segment(reference, options).labels;
    int error_count = 0;
    const auto refuse = [&](long long number) {
        std::optional<PreparedMesh> prepared;
        std::vector<int> labels;
        std::string message;
        TriangleMesh copy = mesh;
        refuse_allocation(number);
        try {
            prepared.emplace(std::move(copy), 2);
            labels = segment(*prepared, options).labels;
        } catch (const OutOfMemory& error) {
            stop_refusing();
            message = error.what();
        }
        if (message.empty()) {
            // Sorting does without its buffer where there is none: a refusal may go unnoticed.
            const bool was_refused = stop_refusing();
            EXPECT_EQ(labels, expected) << number;
            return was_refused;
        }
        EXPECT_NE(message.find("not enough memory"), std::string::npos) << message;
        if (++error_count % 8 == 0 && prepared) {
            EXPECT_EQ(segment(*prepared, options).labels, expected) << number;
        }
        return true;
    };
    refuse_each_allocation(refuse, dense);
    return error_count;
}

TEST_P(RefusedMemory, IsAnErrorThatHelpsAndTheMeshStaysUsable) {
    EXPECT_GT(refuse_in_segmentations(displaced_sphere(2), GetParam(), 50), 20);
}

SegmentOptions options_of(Method method, Effort effort, int submesh_count) {
    SegmentOptions options;
    options.method = method;
    options.effort = effort;
    options.submesh_count = submesh_count;
    options.thread_count = 2;
    options.max_cohesion_iterations = 3;
    options.max_refinement_iterations = 20;
    return options;
}

std::string name_of(const testing::TestParamInfo<SegmentOptions>& info) {
    return info.param.method == Method::all_pairs ? "AllPairs"
        : info.param.effort == Effort::high       ? "FastHigh"
                                                  : "FastDraft";
}

INSTANTIATE_TEST_SUITE_P(Methods,
                         RefusedMemory,
                         testing::Values(options_of(Method::fast, Effort::draft, 60),
                                         options_of(Method::fast, Effort::high, 60),
                                         options_of(Method::all_pairs, Effort::standard, 40)),
                         name_of);

TEST(RefusedMemory, OfAStartOnTheSphereIsAnErrorThatHelps) {
    const SegmentOptions options = options_of(Method::fast, Effort::high, 50);
    EXPECT_GT(refuse_in_segmentations(mesh_for_a_sphere_start(), options, 1), 10);
}

TEST(RefusedMemory, OfWorkThatThreadsShareIsAnErrorThatHelps) {
    const SegmentOptions options = options_of(Method::fast, Effort::draft, 1000);
    EXPECT_GT(refuse_in_segmentations(displaced_sphere(5), options, 25), 20);
}

TEST(RefusedMemory, OfTheSphericalMapIsAnErrorThatHelps) {
    const TriangleMesh mesh = displaced_sphere(2);
    refuse_each_allocation([&](long long number) {
        PreparedMesh prepared(mesh, 2);
        refuse_allocation(number);
        try {
            prepared.parametrization(2);
        } catch (const OutOfMemory&) {
            stop_refusing();
            EXPECT_TRUE(is_valid_parametrization(mesh, prepared.parametrization(2).positions));
            return true;
        }
        return stop_refusing();
    });
}

TEST(RefusedMemory, OfMeasuresThrows) {
    const TriangleMesh mesh = open_grid(8);
    const DualGraph graph = build_dual_graph(mesh, 2);
    std::vector<int> labels(mesh.faces.size(), 0);
    labels[5] = 3;
    const int disk_count = measure(mesh, graph, labels, 4, 2).disk_count;
    refuse_each_allocation([&](long long number) {
        refuse_allocation(number);
        int measured = 0;
        try {
            inspect(mesh, graph);
            measured = measure(mesh, graph, labels, 4, 2).disk_count;
        } catch (const std::bad_alloc&) {
            stop_refusing();
            return true;
        }
        EXPECT_EQ(measured, disk_count);
        return stop_refusing();
    });
}

} // namespace
} // namespace spheroseg
