// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device.h"
#include "swap_device.h"

namespace spheroseg::cuda {

/// How the work is cut. Changes the time, never the labels; docs/gpu.md derives the defaults.
struct SwapTuning {
    int min_slots_per_block = 256;
    int max_slots_per_block = 512;
    /// Phases of cohesion between two looks at the clock.
    int phases_per_report = 100;
    /// Pairs of refinement that are tested at once.
    long long pairs_per_batch = 1LL << 22;
    /// Batches of refinement that are queued before the host looks how far they came.
    int batches_per_read = 64;
};

/// Blocks of a step of cohesion: so many that no multiprocessor idles, within the bounds of
/// `tuning`, at least two where there are two slots.
int cohesion_block_count(int face_count, int multiprocessor_count, const SwapTuning& tuning);

/// Device memory that the steps take for a mesh and k, in bytes.
std::size_t cohesion_bytes(int face_count, int submesh_count);
std::size_t refinement_bytes(int face_count);

/// Cohesion and refinement of `all_pairs` on a device, with the labels that the engine makes on the
/// cores. Checks that the memory is there before it takes any.
class DeviceSwaps : public SwapDevice {
public:
    explicit DeviceSwaps(std::unique_ptr<Device> device, const SwapTuning& tuning = {})
        : device_(std::move(device)), tuning_(tuning) {}

    std::unique_ptr<CohesionRounds> begin_cohesion(const PointArrays& faces,
                                                   const std::vector<int>& labels,
                                                   int submesh_count) override;
    std::unique_ptr<SwapRounds> begin_refinement(const DualGraph& dual_graph,
                                                 const std::vector<int>& labels) override;

private:
    std::unique_ptr<Device> device_;
    SwapTuning tuning_;
};

/// Below, the cores are done before a device has started: `auto` does not look for one.
constexpr int kLeastFacesForDevice = 20000;

} // namespace spheroseg::cuda
