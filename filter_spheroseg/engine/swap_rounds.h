// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "round_robin.h"
#include "swap_device.h"
#include "swap_iterations.h"

#include <algorithm>

namespace spheroseg {

/// One iteration of a swapping step over all pairs of faces, round by round.
struct IterationOverRounds {
    /// Shown with the progress.
    const char* step;
    /// Iterations before this one.
    int iterations_done;
    const RoundRobin& schedule;
    /// Pairs that the cores play in some tens of milliseconds, between two looks at the clock and
    /// the progress callback.
    long long pairs_per_report;

    /// Has `device`, or where that is null play_on_cores(round_begin, round_end), play all rounds;
    /// returns the number of swaps. `complete` becomes false when the time limit cut it short.
    template <typename Play>
    long long play(SwapRounds* device,
                   const SwapLimits& limits,
                   const Progress& progress,
                   bool& complete,
                   const Play& play_on_cores) const {
        const int rounds = schedule.round_count();
        const int stride = device != nullptr
            ? device->rounds_per_report()
            : static_cast<int>(
                  std::max(1LL, pairs_per_report / std::max(1, schedule.slot_count())));
        long long swap_count = 0;
        for (int begin = 0; begin < rounds; begin += stride) {
            if (limits.expired()) {
                complete = false;
                break;
            }
            const double part = static_cast<double>(begin) / rounds;
            report_progress(progress, open_ended_fraction(iterations_done + part), step);
            const int end = std::min(rounds, begin + stride);
            swap_count += device != nullptr ? device->play(begin, end) : play_on_cores(begin, end);
        }
        return swap_count;
    }
};

} // namespace spheroseg
