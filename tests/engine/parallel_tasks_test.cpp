// SPDX-License-Identifier: GPL-3.0-or-later
#include "parallel_tasks.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace spheroseg {
namespace {

/// Runs two tasks on two threads: that of the calling thread ends as soon as the other one runs,
/// and that one goes on until it is told to end, or has heard that `limit` is up.
template <typename Report> void run_with_idle_caller(const Report& report) {
    const Deadline limit(20.0);
    std::atomic<int> begun{0};
    run_tasks(2, 2, report, [&](int, const Progress& watch) {
        ++begun;
        while (begun < 2 && !limit.expired()) {
            std::this_thread::yield();
        }
        while (omp_get_thread_num() != 0 && !limit.expired()) {
            report_progress(watch, 0.5, "");
            std::this_thread::yield();
        }
    });
}

TEST(ParallelTasks, RunsEachTaskOnce) {
    for (int threads : {1, 2, 5}) {
        std::vector<std::atomic<int>> runs(17);
        run_tasks(
            17, threads, [] { return true; }, [&](int i, const Progress&) { ++runs[i]; });
        for (const std::atomic<int>& count : runs) {
            EXPECT_EQ(count, 1);
        }
    }
}

TEST(ParallelTasks, CanBeCancelledWhileTheCallingThreadHasNoTaskLeft) {
    const auto caller = std::this_thread::get_id();
    int calls = 0;
    const auto report = [&] {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        return ++calls < 5;
    };
    EXPECT_THROW(run_with_idle_caller(report), Cancelled);
    EXPECT_EQ(calls, 5);
}

TEST(ParallelTasks, WhatAReportThrowsEndsAllTasks) {
    int calls = 0;
    const auto report = [&]() -> bool {
        if (++calls == 5) {
            throw std::runtime_error("a report");
        }
        return true;
    };
    EXPECT_THROW(run_with_idle_caller(report), std::runtime_error);
    EXPECT_EQ(calls, 5);
}

TEST(ParallelTasks, BeginsNoTaskAfterAFailure) {
    for (int threads : {1, 3}) {
        std::atomic<int> begun{0};
        const auto task = [&](int, const Progress&) {
            ++begun;
            throw std::bad_alloc();
        };
        EXPECT_THROW(run_tasks(
                         100, threads, [] { return true; }, task),
                     std::bad_alloc);
        EXPECT_LE(begun, threads);
    }
}

} // namespace
} // namespace spheroseg
