// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <omp.h>

namespace spheroseg {

/// 0 or less: all cores.
inline int resolve_thread_count(int thread_count) {
    return thread_count > 0 ? thread_count : omp_get_num_procs();
}

} // namespace spheroseg
