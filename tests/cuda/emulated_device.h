// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "device.h"

#include <functional>
#include <map>

namespace spheroseg::test {

/// The kernels' own source, run by the emulation of the execution model.
class EmulatedDevice : public cuda::Device {
public:
    /// What the device holds and has done; outlives it.
    struct Log {
        std::size_t bytes_held = 0;
        std::size_t most_bytes_held = 0;
        int calls = 0;
        int launches = 0;
    };

    /// Threads of a block: results must not depend on it.
    unsigned int threads = 32;
    unsigned long long order_seed = 0;
    std::size_t free_memory = std::size_t{1} << 34;
    /// Called before each call; may throw, as a failing device does.
    std::function<void(const char* call)> before_call;

    explicit EmulatedDevice(Log& log, int multiprocessor_count = 4) : log_(log) {
        info_.name = "emulation";
        info_.multiprocessor_count = multiprocessor_count;
    }

    const cuda::DeviceInfo& info() const override { return info_; }
    std::size_t free_bytes() override;
    void* allocate(std::size_t bytes) override;
    void release(void* memory) noexcept override;
    void clear(void* memory, std::size_t bytes) override;
    void upload(void* to, const void* from, std::size_t bytes) override;
    void download(void* to, const void* from, std::size_t bytes) override;
    void play_cohesion_tiles(const cuda::CohesionArrays& arrays,
                             const cuda::TilePhase& phase,
                             int capacity) override;
    void measure_bounds(const cuda::RefinementArrays& arrays) override;
    void play_refinement_batch(const cuda::RefinementArrays& arrays, int batch_rounds) override;
    void anneal_groups(const cuda::AnnealArrays& arrays,
                       const Phase& phase,
                       const FreeLoads& loads) override;
    void anneal_groups(const cuda::AnnealArrays& arrays,
                       const Phase& phase,
                       const BoundedLoads& loads) override;

private:
    void begin_call(const char* name);
    void launch(unsigned int blocks_x,
                unsigned int blocks_y,
                std::size_t shared_bytes,
                const std::function<void()>& kernel);

    Log& log_;
    cuda::DeviceInfo info_;
    std::map<void*, std::size_t> held_;
};

} // namespace spheroseg::test
