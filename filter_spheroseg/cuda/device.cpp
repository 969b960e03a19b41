// SPDX-License-Identifier: GPL-3.0-or-later
#include "device.h"

namespace spheroseg::cuda {

namespace {

/// Kept free for the kernels' own needs and for other programs.
constexpr std::size_t kSpareBytes = std::size_t{64} << 20;

} // namespace

void require_memory(Device& device, std::size_t bytes, const char* step) {
    const std::size_t free = device.free_bytes();
    if (free < bytes + kSpareBytes) {
        throw DeviceError(std::string("Expected ") + std::to_string((bytes + kSpareBytes) >> 20) +
                          " MiB of free device memory for the " + step + ", found " +
                          std::to_string(free >> 20) + " MiB on " + device.info().name +
                          ". Close programs that use the device, or use device \"cpu\".");
    }
}

std::unique_ptr<Device> open_device() {
    DeviceSearch search = find_device();
    if (!search.device) {
        throw DeviceError("Expected a usable CUDA device, found none: " + search.reason +
                          ". Use device \"auto\" or \"cpu\".");
    }
    return std::move(search.device);
}

} // namespace spheroseg::cuda
