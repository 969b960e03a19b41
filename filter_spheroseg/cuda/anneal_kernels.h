// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal_arrays.h"

#include <cuda_runtime_api.h>

namespace spheroseg::cuda {

// Launches; each returns its error.

cudaError_t launch_anneal_groups(const AnnealArrays& arrays,
                                 const Phase& phase,
                                 const FreeLoads& loads,
                                 cudaStream_t stream);
cudaError_t launch_anneal_groups(const AnnealArrays& arrays,
                                 const Phase& phase,
                                 const BoundedLoads& loads,
                                 cudaStream_t stream);

} // namespace spheroseg::cuda
