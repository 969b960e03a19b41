// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "chord_swaps.h"
#include "dual_graph.h"

#include <memory>

namespace spheroseg {

/// Rounds of pair swaps that a device plays instead of this machine's cores. What it holds on the
/// device is released with it. Every function throws DeviceError when the device fails.
class SwapRounds {
public:
    virtual ~SwapRounds() = default;
    /// Rounds to play between two looks at the clock: some tens of milliseconds.
    virtual int rounds_per_report() const = 0;
    /// Plays the rounds [round_begin, round_end), of `RoundRobin`, and returns the number of swaps.
    virtual long long play(int round_begin, int round_end) = 0;
    /// Labels after the rounds played so far.
    virtual void read_labels(std::vector<int>& labels) = 0;
};

/// Rounds of Algorithm 1, as `swap_run` plays them.
class CohesionRounds : public SwapRounds {
public:
    /// One centroid per sub-mesh, for the rounds to come. To be called before the first of them.
    virtual void set_centroids(const PointArrays& centroids) = 0;
};

/// A processor beside this machine's cores. It makes the same swaps as they do, bit for bit.
class SwapDevice {
public:
    virtual ~SwapDevice() = default;
    virtual std::unique_ptr<CohesionRounds>
    begin_cohesion(const PointArrays& faces, const std::vector<int>& labels, int submesh_count) = 0;
    /// Rounds of Algorithm 3, with the decisions and the yielding of `refine_all_pairs`.
    virtual std::unique_ptr<SwapRounds> begin_refinement(const DualGraph& dual_graph,
                                                         const std::vector<int>& labels) = 0;
};

} // namespace spheroseg
