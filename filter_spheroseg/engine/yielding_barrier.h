// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <thread>

namespace spheroseg {

/// Barrier for many short steps: waits actively for some microseconds, then lets other threads of
/// the machine run. OpenMP's own spins for milliseconds, which on a busy machine takes the time
/// that the missing thread needs.
class YieldingBarrier {
public:
    explicit YieldingBarrier(int member_count) : member_count_(member_count) {}

    void wait() {
        const unsigned phase = phase_.load(std::memory_order_acquire);
        if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == member_count_) {
            arrived_.store(0, std::memory_order_relaxed);
            phase_.store(phase + 1, std::memory_order_release);
            return;
        }
        for (int turn = 0; phase_.load(std::memory_order_acquire) == phase; ++turn) {
            if (turn >= kActiveTurns) {
                std::this_thread::yield();
            }
        }
    }

private:
    static constexpr int kActiveTurns = 2000;

    const int member_count_;
    std::atomic<int> arrived_{0};
    std::atomic<unsigned> phase_{0};
};

} // namespace spheroseg
