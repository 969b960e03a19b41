// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal_device.h"
#include "device.h"

namespace spheroseg::cuda {

/// Device memory, in bytes, that annealing takes for a patchwork of so many faces and sub-meshes.
std::size_t annealing_bytes(int face_count, int submesh_count, bool with_partners);

/// The annealing of `fast` on a device, with the labels that the engine makes on the cores. Checks
/// that the memory is there before it takes any.
class DeviceAnnealing : public AnnealDevice {
public:
    explicit DeviceAnnealing(std::unique_ptr<Device> device) : device_(std::move(device)) {}

    std::unique_ptr<spheroseg::DeviceGroups>
    begin_groups(const Patchwork& patchwork, bool with_partners, int thread_count) override;
    bool was_used() const override { return was_used_; }

private:
    std::unique_ptr<Device> device_;
    bool was_used_ = false;
};

} // namespace spheroseg::cuda
