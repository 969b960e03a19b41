// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "boundary.h"
#include "group_moves.h"

#include <memory>

namespace spheroseg {

/// The length limit of a label's list of exchange partners that begins with `count` faces.
inline std::size_t partner_capacity(std::size_t count) {
    return 16 * count + 64;
}

/// Anneals the groups of a patchwork on a device. What it holds there is released with it. Every
/// function throws DeviceError when the device fails.
class DeviceGroups {
public:
    virtual ~DeviceGroups() = default;
    /// Makes the proposals of all groups of a phase, as the cores do: the same labels, loads and
    /// lists. Returns the change of the number of boundary edges. Labels may have changed since the
    /// last call only by this object's doing.
    virtual std::int64_t run(const Phase& phase,
                             const FreeLoads& loads,
                             Patchwork& patchwork,
                             Grouping& grouping,
                             BoundaryFaces& boundary) = 0;
    virtual std::int64_t run(const Phase& phase,
                             const BoundedLoads& loads,
                             Patchwork& patchwork,
                             Grouping& grouping,
                             BoundaryFaces& boundary) = 0;
};

/// A processor beside this machine's cores.
class AnnealDevice {
public:
    virtual ~AnnealDevice() = default;
    /// `with_partners`: for phases with `BoundedLoads`, else for those with `FreeLoads`.
    virtual std::unique_ptr<DeviceGroups>
    begin_groups(const Patchwork& patchwork, bool with_partners, int thread_count) = 0;
    /// Whether a phase has run on it, for the result that was kept or for another.
    virtual bool was_used() const = 0;
};

} // namespace spheroseg
