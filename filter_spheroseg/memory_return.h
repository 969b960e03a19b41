// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

namespace spheroseg {

/// Gives free memory back to the system now and then, where GNU's allocator is used. What the host
/// keeps of each call, some kilobytes, comes to lie between blocks that the call frees, so that the
/// next call finds no room for its own: 30 bytes per face and call would be held for nothing.
class MemoryReturn {
public:
    /// After a segmentation of so many faces. Gives memory back once a million has come together,
    /// as that takes about a millisecond.
    void count(std::size_t faces);

private:
    std::size_t faces_ = 0;
};

} // namespace spheroseg
