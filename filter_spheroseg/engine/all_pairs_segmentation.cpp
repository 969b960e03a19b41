// SPDX-License-Identifier: GPL-3.0-or-later
#include "all_pairs_segmentation.h"

#include "all_pairs_cohesion.h"
#include "all_pairs_refinement.h"
#include "cohesion_state.h"
#include "device_swaps.h"

namespace spheroseg {

namespace {

void append(std::vector<double>& to, const std::vector<double>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

/// Adds the iterations of a step to the result.
void record(Segmentation& result, const SwapIterations& iterations) {
    append(result.boundary_edges_by_iteration, iterations.boundary_edges);
    append(result.seconds_by_iteration, iterations.seconds);
    append(result.energy_by_iteration, iterations.energy);
    result.time_limit_hit = result.time_limit_hit || iterations.time_limit_hit;
}

/// Cohesion and refinement, on `limits.device` unless it is null.
Segmentation swap_all_pairs(const PreparedMesh& prepared,
                            const std::vector<Vec3>& centroids,
                            const SegmentOptions& options,
                            SwapLimits limits,
                            const Progress& progress) {
    Segmentation result;
    const int submesh_count = requested_submesh_count(options, prepared.mesh().face_count());
    limits.max_iterations = options.max_cohesion_iterations;
    const StopWatch cohesion_watch;
    result.labels =
        random_balanced_labels(prepared.mesh().face_count(), submesh_count, options.seed);
    const SwapIterations cohesion = cohere_all_pairs(prepared.dual_graph(),
                                                     centroids,
                                                     submesh_count,
                                                     options.seed,
                                                     limits,
                                                     result.labels,
                                                     sub_progress(progress, 0.0, 0.9));
    record(result, cohesion);
    result.cohesion_iterations = cohesion.count();
    result.cohesion_seconds = cohesion_watch.elapsed_seconds();
    result.measures_after_cohesion =
        measure(prepared, result.labels, submesh_count, options.thread_count);

    limits.max_iterations = options.max_refinement_iterations;
    const StopWatch refinement_watch;
    const SwapIterations refinement = refine_all_pairs(
        prepared.dual_graph(), limits, result.labels, sub_progress(progress, 0.9, 1.0));
    record(result, refinement);
    result.refinement_iterations = refinement.count();
    result.refinement_seconds = refinement_watch.elapsed_seconds();
    result.used_cuda = limits.device != nullptr;
    return result;
}

Segmentation swap_on_best_device(const PreparedMesh& prepared,
                                 const std::vector<Vec3>& centroids,
                                 const SegmentOptions& options,
                                 SwapLimits limits,
                                 const Progress& progress) {
    const bool tries_device = options.device == Device::cuda ||
        (options.device == Device::automatic &&
         prepared.mesh().face_count() >= cuda::kLeastFacesForDevice);
    if (tries_device) {
        try {
            cuda::DeviceSwaps device(cuda::open_device());
            limits.device = &device;
            return swap_all_pairs(prepared, centroids, options, limits, progress);
        } catch (const DeviceError&) {
            if (options.device == Device::cuda) {
                throw;
            }
            limits.device = nullptr;
        }
    }
    return swap_all_pairs(prepared, centroids, options, limits, progress);
}

} // namespace

Segmentation segment_all_pairs(PreparedMesh& prepared,
                               const SegmentOptions& options,
                               const Deadline& deadline,
                               const Progress& progress) {
    const StopWatch watch;
    const std::vector<Vec3> centroids = face_centroids_on_sphere(
        prepared.mesh(),
        prepared.parametrization(options.thread_count, sub_progress(progress, 0.0, 0.1)).positions);
    const double parametrization_seconds = watch.elapsed_seconds();
    SwapLimits limits;
    limits.thread_count = options.thread_count;
    limits.deadline = &deadline;
    Segmentation result =
        swap_on_best_device(prepared, centroids, options, limits, sub_progress(progress, 0.1, 1.0));
    result.parametrization_seconds = parametrization_seconds;
    const int face_count = prepared.mesh().face_count();
    result.best_max_triangle_count_difference =
        face_count % requested_submesh_count(options, face_count) != 0;
    return result;
}

} // namespace spheroseg
