// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <functional>

/// CUDA's execution model on one core of the host, for the kernels' own source: each CUDA thread is
/// a fibre that runs until its next barrier. Blocks, and threads between two barriers, run in an
/// order that the seed of the launch decides, so that a result that depends on their order differs
/// between seeds. A barrier that some threads of a block miss is an error, as is an access outside
/// the dynamic shared memory (with the address sanitizer).
namespace spheroseg::emulation {

struct Index {
    unsigned int x = 0;
    unsigned int y = 0;
    unsigned int z = 0;
};

extern Index thread_index;
extern Index block_index;
extern Index block_size;
extern Index grid_size;

struct Launch {
    Index grid{1, 1, 1};
    unsigned int threads = 1;
    std::size_t shared_bytes = 0;
    unsigned long long order_seed = 0;
};

/// Runs the kernel for every thread. Throws std::logic_error on a barrier that is not reached by
/// all threads of a block.
void run(const Launch& launch, const std::function<void()>& kernel);

/// As wrong as the device's may be, and more: up to 2^-22 of itself, in either direction; 0 of a
/// denormal number.
float rough_root(float value);

void* shared_memory();
void barrier();
/// Barrier that returns whether any thread of the block passed true.
bool barrier_or(bool value);

} // namespace spheroseg::emulation

#define __global__
#define __device__
#define __launch_bounds__(...)
#define threadIdx (::spheroseg::emulation::thread_index)
#define blockIdx (::spheroseg::emulation::block_index)
#define blockDim (::spheroseg::emulation::block_size)
#define gridDim (::spheroseg::emulation::grid_size)
#define SPHEROSEG_DYNAMIC_SHARED(type, name)                                                       \
    type* const name = static_cast<type*>(::spheroseg::emulation::shared_memory())
#define SPHEROSEG_VOLATILE_READ(value) (value)
#define SPHEROSEG_UNROLL
#define SPHEROSEG_ROUGH_ROOT(value) ::spheroseg::emulation::rough_root(value)

inline void __syncthreads() {
    ::spheroseg::emulation::barrier();
}
inline int __syncthreads_or(int value) {
    return ::spheroseg::emulation::barrier_or(value != 0) ? 1 : 0;
}
template <typename T> T atomicAdd(T* to, T value) {
    const T before = *to;
    *to = before + value;
    return before;
}
template <typename T> T atomicMin(T* to, T value) {
    const T before = *to;
    *to = std::min(before, value);
    return before;
}
inline float __fadd_rn(float a, float b) {
    return a + b;
}
inline float __fsub_rn(float a, float b) {
    return a - b;
}
inline float __fmul_rn(float a, float b) {
    return a * b;
}
inline float __fsqrt_rn(float a) {
    return std::sqrt(a);
}
inline float __fmaf_rn(float a, float b, float c) {
    return a * b + c; // used where either rounding will do
}
inline float __int_as_float(int bits) {
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}
