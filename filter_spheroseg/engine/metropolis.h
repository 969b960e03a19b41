// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace spheroseg {

constexpr int kQuantileCount = 1 << 12;

/// Quantiles of the exponential distribution. A move that costs at most temperature * a random one
/// of them is accepted: the Metropolis rule, random number first.
inline const std::array<float, kQuantileCount>& exponential_quantiles() {
    static const std::array<float, kQuantileCount> quantiles = [] {
        std::array<float, kQuantileCount> values;
        for (std::size_t i = 0; i < values.size(); ++i) {
            const double u = (static_cast<double>(i) + 0.5) / kQuantileCount;
            values[i] = static_cast<float>(-std::log(u));
        }
        return values;
    }();
    return quantiles;
}

} // namespace spheroseg
