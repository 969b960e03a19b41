// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "round_tiles.h"
#include "swap_arrays.h"

#include <cuda_runtime_api.h>

namespace spheroseg::cuda {

// Launches; each returns the error of its launch.

cudaError_t launch_cohesion_tiles(const CohesionArrays& arrays,
                                  const TilePhase& phase,
                                  int capacity,
                                  cudaStream_t stream);
cudaError_t launch_measure_bounds(const RefinementArrays& arrays, cudaStream_t stream);
cudaError_t
launch_refinement_batch(const RefinementArrays& arrays, int batch_rounds, cudaStream_t stream);

/// Whether the build has code for the current device.
cudaError_t find_kernel_code();

} // namespace spheroseg::cuda
