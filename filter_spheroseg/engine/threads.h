// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "waiting_threads.h"

#include <algorithm>
#include <cstdint>
#include <omp.h>
#include <vector>

namespace spheroseg {

/// The OpenMP library ends the process when it is asked for more threads than there is memory for.
constexpr int kMaxThreads = 256;

/// 0 or less: all cores. At most kMaxThreads, or all cores if these are more.
inline int resolve_thread_count(int thread_count) {
    if (thread_count > 0 && thread_count <= kMaxThreads) {
        return thread_count; // without a system call
    }
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
/// Where it is several, they are about to be used: it sees to it that they do not spin for long.
inline int threads_for(int thread_count, std::int64_t items, std::int64_t share) {
    const auto threads = static_cast<int>(
        std::clamp<std::int64_t>(items / share, 1, resolve_thread_count(thread_count)));
    if (threads > 1) {
        keep_waiting_threads_calm();
    }
    return threads;
}

/// Calls work(i) for i in [0, count) on so many threads, whichever is free. `work` must not throw.
/// One thread is the calling one, without OpenMP, which makes a team and system calls even for
/// that.
template <typename Work> void for_each_task(int count, int threads, const Work& work) {
    if (std::min(count, threads) <= 1) {
        for (int i = 0; i < count; ++i) {
            work(i);
        }
        return;
    }
#pragma omp parallel for schedule(dynamic, 1) num_threads(std::min(count, threads))
    for (int i = 0; i < count; ++i) {
        work(i);
    }
}

/// Calls work(begin, end) for as many nearly equal shares of [0, items) as threads, each on a
/// thread of its own: on the same one each time, whose cache may still hold it. `work` must not
/// throw.
template <typename Work> void for_each_share(int items, int threads, const Work& work) {
    if (threads <= 1) {
        work(0, items);
        return;
    }
#pragma omp parallel for schedule(static, 1) num_threads(threads)
    for (int t = 0; t < threads; ++t) {
        work(share_begin(t, threads, items), share_begin(t + 1, threads, items));
    }
}

/// Keeps the items for which keep(item) holds, in their order, on so many threads.
template <typename Keep> void keep_items(std::vector<int>& items, int threads, const Keep& keep) {
    const auto count = static_cast<int>(items.size());
    const auto begin_of = [&](int t) { return items.begin() + share_begin(t, threads, count); };
    std::vector<std::vector<int>::iterator> ends(threads);
    for_each_task(threads, threads, [&](int t) {
        ends[t] = std::copy_if(begin_of(t), begin_of(t + 1), begin_of(t), keep);
    });
    auto end = ends[0];
    for (int t = 1; t < threads; ++t) {
        end = std::copy(begin_of(t), ends[t], end);
    }
    items.erase(end, items.end());
}

/// Items that a thread takes at a time where some take longer than others.
constexpr int kChunk = 256;

/// Calls work(begin, end) for the chunks of [0, items), on so many threads.
template <typename Work> void for_each_chunk(int items, int threads, const Work& work) {
    for_each_task((items + kChunk - 1) / kChunk, threads, [&](int i) {
        work(i * kChunk, std::min(items, (i + 1) * kChunk));
    });
}

/// Calls work(i) for i in [0, items), chunk by chunk, on so many threads.
template <typename Work> void for_each_item(int items, int threads, const Work& work) {
    for_each_chunk(items, threads, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            work(i);
        }
    });
}

} // namespace spheroseg
