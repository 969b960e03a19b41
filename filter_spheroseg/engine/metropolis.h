// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace spheroseg {

constexpr int kQuantileCount = 1 << 12;

/// Quantiles of the exponential distribution with mean 1. A move is accepted when its cost is at
/// most temperature * (one of them, drawn at random): the Metropolis rule u <= exp(-cost /
/// temperature), solved for the cost, so that the most that a move may cost is known before it is
/// described.
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
