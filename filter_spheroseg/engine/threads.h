// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <omp.h>

namespace spheroseg {

/// The OpenMP library ends the process when it is asked for more threads than there is memory for.
constexpr int kMaxThreads = 256;

/// 0 or less: all cores. At most kMaxThreads, or all cores if these are more.
inline int resolve_thread_count(int thread_count) {
    const int core_count = omp_get_num_procs();
    return thread_count > 0 ? std::min(thread_count, std::max(core_count, kMaxThreads))
                            : core_count;
}

/// Faces that a plain loop over all of them should have per thread: waking one takes as long as
/// going over some thousands.
constexpr int kFacesPerThread = 8192;

/// Where share `i` of `share_count` nearly equal shares of `items` items begins.
inline int share_begin(int i, int share_count, int items) {
    return static_cast<int>(static_cast<std::int64_t>(items) * i / share_count);
}

/// As resolve_thread_count, but at least 1 and no more than there are shares of `share` items.
inline int threads_for(int thread_count, std::int64_t items, std::int64_t share) {
    return static_cast<int>(
        std::clamp<std::int64_t>(items / share, 1, resolve_thread_count(thread_count)));
}

} // namespace spheroseg
