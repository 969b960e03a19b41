// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel_failure.h"
#include "progress.h"

#include <algorithm>
#include <atomic>
#include <omp.h>

namespace spheroseg {

/// Runs task(i, watch) for i in [0, count), side by side on at most `thread_count` threads, and
/// rethrows what one of them throws; after a failure no other task is begun. Each gives `watch` to
/// what it calls, as its progress; report() is called when that is heard on the calling thread, and
/// answers false to have all tasks end with Cancelled.
template <typename Report, typename Task>
void run_tasks(int count, int thread_count, const Report& report, const Task& task) {
    std::atomic<bool> stopped{false};
    std::atomic<bool> cancelled{false};
    ParallelFailure failure;
#pragma omp parallel for schedule(dynamic, 1)                                                      \
    num_threads(std::max(1, std::min(count, thread_count)))
    for (int i = 0; i < count; ++i) {
        failure.guard([&] {
            if (stopped) {
                return;
            }
            const bool reports = omp_get_thread_num() == 0;
            const Progress watch = [&](double, const char*) {
                if (reports && !report()) {
                    cancelled = true;
                }
                return !cancelled;
            };
            try {
                report_progress(watch, 0.0, "");
                task(i, watch);
            } catch (...) {
                stopped = true;
                throw;
            }
        });
    }
    failure.rethrow();
}

} // namespace spheroseg
