// SPDX-License-Identifier: GPL-3.0-or-later
#include "emulated_device.h"

#include "emulation.h"

#include "anneal_kernels.cuh"
#include "cohesion_kernels.cuh"
#include "refinement_kernels.cuh"

namespace spheroseg::test {

namespace {

unsigned int blocks_for(int count, unsigned int per_block) {
    return (static_cast<unsigned int>(count) + per_block - 1) / per_block;
}

} // namespace

void EmulatedDevice::begin_call(const char* name) {
    ++log_.calls;
    if (before_call) {
        before_call(name);
    }
}

std::size_t EmulatedDevice::free_bytes() {
    begin_call("free_bytes");
    return free_memory - log_.bytes_held;
}

void* EmulatedDevice::allocate(std::size_t bytes) {
    begin_call("allocate");
    void* memory = ::operator new(bytes);
    std::memset(memory, 0x5a, bytes); // as garbage as a device's
    held_[memory] = bytes;
    log_.bytes_held += bytes;
    log_.most_bytes_held = std::max(log_.most_bytes_held, log_.bytes_held);
    return memory;
}

void EmulatedDevice::release(void* memory) noexcept {
    log_.bytes_held -= held_.at(memory);
    held_.erase(memory);
    ::operator delete(memory);
}

void EmulatedDevice::clear(void* memory, std::size_t bytes) {
    begin_call("clear");
    std::memset(memory, 0, bytes);
}

void EmulatedDevice::upload(void* to, const void* from, std::size_t bytes) {
    begin_call("upload");
    std::memcpy(to, from, bytes);
}

void EmulatedDevice::download(void* to, const void* from, std::size_t bytes) {
    begin_call("download");
    std::memcpy(to, from, bytes);
}

void EmulatedDevice::launch(unsigned int blocks_x,
                            unsigned int blocks_y,
                            std::size_t shared_bytes,
                            const std::function<void()>& kernel) {
    ++log_.launches;
    emulation::run({{blocks_x, blocks_y, 1},
                    threads,
                    shared_bytes,
                    order_seed + static_cast<unsigned long long>(log_.launches)},
                   kernel);
}

void EmulatedDevice::play_cohesion_tiles(const cuda::CohesionArrays& arrays,
                                         const cuda::TilePhase& phase,
                                         int capacity) {
    begin_call("play_cohesion_tiles");
    launch(phase.block_count - (phase.wedges ? 1 : 0), 1, cuda::tile_bytes(capacity), [&] {
        cuda::play_cohesion_tiles(arrays, phase, capacity);
    });
}

void EmulatedDevice::measure_bounds(const cuda::RefinementArrays& arrays) {
    begin_call("measure_bounds");
    launch(blocks_for(arrays.face_count, threads), 1, 0, [&] { cuda::measure_bounds(arrays); });
}

void EmulatedDevice::play_refinement_batch(const cuda::RefinementArrays& arrays, int batch_rounds) {
    begin_call("play_refinement_batch");
    const int slots = cuda::slot_count_of(arrays.face_count);
    launch(blocks_for(slots, threads * cuda::kSlotsPerScanThread), batch_rounds, 0, [&] {
        cuda::find_round(arrays);
    });
    launch(blocks_for(slots, threads), 1, 0, [&] { cuda::decide_round(arrays); });
    launch(1, 1, 0, [&] { cuda::commit_round(arrays, batch_rounds); });
}

void EmulatedDevice::anneal_groups(const cuda::AnnealArrays& arrays,
                                   const Phase& phase,
                                   const FreeLoads& loads) {
    begin_call("anneal_groups");
    launch(arrays.group_count, 1, sizeof(cuda::GroupState), [&] {
        cuda::anneal_groups(arrays, phase, loads);
    });
}

void EmulatedDevice::anneal_groups(const cuda::AnnealArrays& arrays,
                                   const Phase& phase,
                                   const BoundedLoads& loads) {
    begin_call("exchange_groups");
    launch(arrays.group_count, 1, sizeof(cuda::GroupState), [&] {
        cuda::exchange_groups(arrays, phase, loads);
    });
}

} // namespace spheroseg::test
