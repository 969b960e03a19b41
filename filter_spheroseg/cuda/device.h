// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal_arrays.h"
#include "errors.h"
#include "round_tiles.h"
#include "swap_arrays.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace spheroseg::cuda {

struct DeviceInfo {
    std::string name;
    int multiprocessor_count = 0;
};

/// What the engine asks of a GPU: memory and seven kernels. Launches and uploads are done in
/// their order; a download waits for everything before it. Every function but `release` throws
/// DeviceError, which names the call, the device and the reason.
class Device {
public:
    virtual ~Device() = default;
    virtual const DeviceInfo& info() const = 0;
    virtual std::size_t free_bytes() = 0;
    virtual void* allocate(std::size_t bytes) = 0;
    virtual void release(void* memory) noexcept = 0;
    virtual void clear(void* memory, std::size_t bytes) = 0;
    /// `from` may change as soon as this returns.
    virtual void upload(void* to, const void* from, std::size_t bytes) = 0;
    virtual void download(void* to, const void* from, std::size_t bytes) = 0;

    virtual void
    play_cohesion_tiles(const CohesionArrays& arrays, const TilePhase& phase, int capacity) = 0;
    virtual void measure_bounds(const RefinementArrays& arrays) = 0;
    /// Moves the cursor to the round after the next one with a swap, which is made, or by
    /// `batch_rounds` when there is none among them.
    virtual void play_refinement_batch(const RefinementArrays& arrays, int batch_rounds) = 0;

    /// Makes the proposals of all groups.
    virtual void
    anneal_groups(const AnnealArrays& arrays, const Phase& phase, const FreeLoads& loads) = 0;
    virtual void
    anneal_groups(const AnnealArrays& arrays, const Phase& phase, const BoundedLoads& loads) = 0;
};

/// The first usable GPU of this machine, or why there is none.
struct DeviceSearch {
    std::unique_ptr<Device> device;
    std::string reason; // as in "no NVIDIA driver is installed"; empty with a device
};

/// Without a driver, without a device, or in a build without CUDA: a reason, never an exception.
DeviceSearch find_device();

/// The first usable device. Throws DeviceError, which says why there is none.
std::unique_ptr<Device> open_device();

/// Throws DeviceError, which says what is needed, when a device has less than so many bytes free
/// (and some to spare).
void require_memory(Device& device, std::size_t bytes, const char* step);

/// Whether this build has kernels at all.
bool built_with_cuda();

/// Device memory for `count` elements, released with it.
template <typename T> class DeviceArray {
public:
    DeviceArray(Device& device, std::size_t count)
        : device_(&device), count_(count),
          data_(static_cast<T*>(device.allocate(sizeof(T) * count))) {}
    DeviceArray(Device& device, const std::vector<T>& values) : DeviceArray(device, values.size()) {
        upload(values);
    }
    ~DeviceArray() { device_->release(data_); }
    DeviceArray(const DeviceArray&) = delete;
    DeviceArray& operator=(const DeviceArray&) = delete;

    T* data() const { return data_; }
    void clear() { device_->clear(data_, sizeof(T) * count_); }
    /// `values` has `count` elements or fewer: the first ones are replaced.
    void upload(const std::vector<T>& values) {
        device_->upload(data_, values.data(), sizeof(T) * values.size());
    }
    void download(std::vector<T>& values) const {
        values.resize(count_);
        device_->download(values.data(), data_, sizeof(T) * count_);
    }

private:
    Device* device_;
    std::size_t count_;
    T* data_;
};

} // namespace spheroseg::cuda
