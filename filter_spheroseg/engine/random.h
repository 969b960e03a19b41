// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "host_device.h"

#include <cstdint>

namespace spheroseg {

/// SplitMix64 (Steele, Lea, Flood: Fast Splittable Pseudorandom Number Generators, 2014).
/// A stream is set by a seed and an element index, never by a thread number.
class Random {
public:
    SPHEROSEG_HOST_DEVICE explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
        : state_(mix(seed + kGap) ^ mix(stream * 0xD1B54A32D192ED03ULL + 1)) {}

    SPHEROSEG_HOST_DEVICE std::uint64_t next() { return mix(state_ += kGap); }

    /// What `next` returns after `count` more calls; skip(count) leaves those out.
    SPHEROSEG_HOST_DEVICE std::uint64_t after(std::uint64_t count) const {
        return mix(state_ + (count + 1) * kGap);
    }
    SPHEROSEG_HOST_DEVICE void skip(std::uint64_t count) { state_ += count * kGap; }

    /// Uniform in [0, bound); bound > 0 and below 2^32.
    std::uint32_t below(std::uint32_t bound) {
        return static_cast<std::uint32_t>(((next() >> 32) * bound) >> 32);
    }

    /// Uniform in [0, 1).
    double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

private:
    static constexpr std::uint64_t kGap = 0x9E3779B97F4A7C15ULL;

    SPHEROSEG_HOST_DEVICE static std::uint64_t mix(std::uint64_t z) {
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
        return z ^ (z >> 31);
    }

    std::uint64_t state_;
};

} // namespace spheroseg
