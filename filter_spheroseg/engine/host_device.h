// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Marks functions that run on the cores and, where nvcc compiles them, on a GPU too; "inner"
/// ones are inlined wherever they are called.
#if defined(__CUDACC__)
#define SPHEROSEG_HOST_DEVICE __host__ __device__
#define SPHEROSEG_INNER __host__ __device__ __forceinline__
#else
#define SPHEROSEG_HOST_DEVICE
#define SPHEROSEG_INNER __attribute__((always_inline)) inline
#endif
