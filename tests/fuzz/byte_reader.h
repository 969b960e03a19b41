// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>

namespace spheroseg::fuzz {

/// Reads numbers off a byte string from its front; zeros once it is used up.
class ByteReader {
public:
    ByteReader(const std::uint8_t* bytes, std::size_t size) : bytes_(bytes), size_(size) {}

    bool empty() const { return at_ >= size_; }
    int byte() { return empty() ? 0 : bytes_[at_++]; }
    int word() {
        const int high = byte();
        return high << 8 | byte();
    }
    /// In [0, bound); bound > 0. Takes two bytes where one is too few.
    int below(int bound) { return bound <= 256 ? byte() % bound : word() % bound; }
    /// In [least, most].
    int between(int least, int most) { return least + below(most - least + 1); }
    void skip_to(std::size_t position) { at_ = position; }

private:
    const std::uint8_t* bytes_;
    std::size_t size_;
    std::size_t at_ = 0;
};

} // namespace spheroseg::fuzz
