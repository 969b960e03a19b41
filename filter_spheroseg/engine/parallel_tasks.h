// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel_failure.h"
#include "progress.h"
#include "waiting_threads.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <omp.h>

namespace spheroseg {

/// Counts tasks that have ended, and lets one thread wait for all of them.
class TaskCount {
public:
    explicit TaskCount(int left) : left_(left) {}

    void end_one() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            --left_;
        }
        ended_.notify_one();
    }

    /// Calls `meanwhile` at once, and again every few hundredths of a second, until all have ended.
    template <typename Meanwhile> void await_all(const Meanwhile& meanwhile) {
        std::unique_lock<std::mutex> lock(mutex_);
        while (left_ > 0) {
            lock.unlock();
            meanwhile();
            lock.lock();
            ended_.wait_for(lock, std::chrono::milliseconds(20), [&] { return left_ == 0; });
        }
    }

private:
    std::mutex mutex_;
    std::condition_variable ended_;
    int left_;
};

/// Runs task(i, progress) for i in [0, count) in parallel on at most `thread_count` threads. A task
/// passes its `progress` to what it calls; what it reports there is ignored. On the calling thread
/// such a report calls report(), and so does that thread every few hundredths of a second when it
/// has no task left; report() is never called on another one. When it returns false, all running
/// tasks end with Cancelled at their next report. Rethrows the first exception of a task or of
/// report(); after one no further task is begun. One thread is the calling one, without OpenMP, as
/// in for_each_task.
template <typename Report, typename Task>
void run_tasks(int count, int thread_count, const Report& report, const Task& task) {
    if (std::min(count, thread_count) <= 1) {
        const Progress progress = [&](double, const char*) { return report(); };
        for (int i = 0; i < count; ++i) {
            report_progress(progress, 0.0, "");
            task(i, progress);
        }
        return;
    }
    keep_waiting_threads_calm();
    std::atomic<bool> stopped{false};
    std::atomic<bool> cancelled{false};
    ParallelFailure failure;
    TaskCount tasks(count);
#pragma omp parallel num_threads(std::min(count, thread_count))
    {
        const bool is_caller = omp_get_thread_num() == 0;
        const auto report_on_caller = [&] {
            if (is_caller && !cancelled) {
                bool goes_on = false;
                failure.guard([&] { goes_on = report(); });
                cancelled = !goes_on;
            }
        };
#pragma omp for schedule(dynamic, 1) nowait
        for (int i = 0; i < count; ++i) {
            failure.guard([&] {
                if (stopped) {
                    return;
                }
                const Progress progress = [&](double, const char*) {
                    report_on_caller();
                    return !cancelled;
                };
                try {
                    report_progress(progress, 0.0, "");
                    task(i, progress);
                } catch (...) {
                    stopped = true;
                    throw;
                }
            });
            tasks.end_one();
        }
        if (is_caller) {
            tasks.await_all(report_on_caller);
        }
    }
    failure.rethrow();
    report_progress([&](double, const char*) { return !cancelled; }, 1.0, "");
}

} // namespace spheroseg
