// SPDX-License-Identifier: GPL-3.0-or-later
#include "anneal_kernels.h"

#define SPHEROSEG_DYNAMIC_SHARED(type, name) extern __shared__ type name[]

#include "anneal_kernels.cuh"

namespace spheroseg::cuda {

cudaError_t launch_anneal_groups(const AnnealArrays& arrays,
                                 const Phase& phase,
                                 const FreeLoads& loads,
                                 cudaStream_t stream) {
    anneal_groups<<<arrays.group_count, kAnnealThreads, sizeof(GroupState), stream>>>(
        arrays, phase, loads);
    return cudaGetLastError();
}

cudaError_t launch_anneal_groups(const AnnealArrays& arrays,
                                 const Phase& phase,
                                 const BoundedLoads& loads,
                                 cudaStream_t stream) {
    exchange_groups<<<arrays.group_count, kAnnealThreads, sizeof(GroupState), stream>>>(
        arrays, phase, loads);
    return cudaGetLastError();
}

} // namespace spheroseg::cuda
