// SPDX-License-Identifier: GPL-3.0-or-later
#include "swap_kernels.h"

#define SPHEROSEG_DYNAMIC_SHARED(type, name) extern __shared__ type name[]
#define SPHEROSEG_VOLATILE_READ(value) (*const_cast<const volatile int*>(&(value)))
#define SPHEROSEG_UNROLL _Pragma("unroll")
#define SPHEROSEG_ROUGH_ROOT(value) rough_root(value)

namespace {

/// Off by at most 2^-23 of itself; 0 of a denormal number.
__device__ inline float rough_root(float value) {
    float root;
    asm("sqrt.approx.ftz.f32 %0, %1;" : "=f"(root) : "f"(value));
    return root;
}

} // namespace

#include "cohesion_kernels.cuh"
#include "refinement_kernels.cuh"

namespace spheroseg::cuda {

namespace {

unsigned int blocks_for(int count, int per_block) {
    return static_cast<unsigned int>((count + per_block - 1) / per_block);
}

} // namespace

cudaError_t launch_cohesion_tiles(const CohesionArrays& arrays,
                                  const TilePhase& phase,
                                  int capacity,
                                  cudaStream_t stream) {
    const int tiles = phase.block_count - (phase.wedges ? 1 : 0);
    play_cohesion_tiles<<<tiles, kCohesionThreads, tile_bytes(capacity), stream>>>(
        arrays, phase, capacity);
    return cudaGetLastError();
}

cudaError_t launch_measure_bounds(const RefinementArrays& arrays, cudaStream_t stream) {
    measure_bounds<<<blocks_for(arrays.face_count, kScanThreads), kScanThreads, 0, stream>>>(
        arrays);
    return cudaGetLastError();
}

cudaError_t
launch_refinement_batch(const RefinementArrays& arrays, int batch_rounds, cudaStream_t stream) {
    const int slots = slot_count_of(arrays.face_count);
    const dim3 scan(blocks_for(slots, kScanThreads * kSlotsPerScanThread), batch_rounds);
    find_round<<<scan, kScanThreads, 0, stream>>>(arrays);
    cudaError_t error = cudaGetLastError();
    if (error == cudaSuccess) {
        decide_round<<<blocks_for(slots, kScanThreads), kScanThreads, 0, stream>>>(arrays);
        error = cudaGetLastError();
    }
    if (error == cudaSuccess) {
        commit_round<<<1, kCommitThreads, 0, stream>>>(arrays, batch_rounds);
        error = cudaGetLastError();
    }
    return error;
}

cudaError_t find_kernel_code() {
    cudaFuncAttributes attributes;
    return cudaFuncGetAttributes(&attributes, play_cohesion_tiles);
}

} // namespace spheroseg::cuda
