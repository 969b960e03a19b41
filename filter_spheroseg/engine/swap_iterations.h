// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "progress.h"

#include <vector>

namespace spheroseg {

class SwapDevice;

/// How long the iterations of a swapping step may go on, and where.
struct SwapLimits {
    /// 0: all cores.
    int thread_count = 0;
    /// 0: until converged.
    int max_iterations = 0;
    /// Running since the start of the whole operation; null: no limit.
    const Deadline* deadline = nullptr;
    /// Plays the rounds instead of the cores; null: none.
    SwapDevice* device = nullptr;

    bool expired() const { return deadline != nullptr && deadline->expired(); }
};

/// What the iterations of a swapping step did; the vectors have one entry per iteration.
struct SwapIterations {
    std::vector<double> boundary_edges;
    std::vector<double> seconds;
    std::vector<double> energy;
    std::vector<double> swaps;
    /// The last iteration was cut short, or the next one not begun.
    bool time_limit_hit = false;

    int count() const { return static_cast<int>(seconds.size()); }
};

/// Fraction to report after so many of an unknown number of iterations: rises towards 1.
inline double open_ended_fraction(double iterations) {
    return iterations / (iterations + 8.0);
}

} // namespace spheroseg
