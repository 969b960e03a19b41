// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
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

} // namespace spheroseg
