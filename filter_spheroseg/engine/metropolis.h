// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace spheroseg {

/// Quantiles of the exponential distribution. A move that costs at most
/// temperature * quantile(random bits) is accepted: the Metropolis rule, random number first.
class ExponentialQuantiles {
public:
    static constexpr int kBits = 12;

    static const ExponentialQuantiles& get() {
        static const ExponentialQuantiles table;
        return table;
    }
    double operator()(std::uint64_t bits) const { return values_[bits & ((1U << kBits) - 1)]; }

private:
    ExponentialQuantiles() {
        for (std::size_t i = 0; i < values_.size(); ++i) {
            const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(values_.size());
            values_[i] = static_cast<float>(-std::log(u));
        }
    }
    std::array<float, 1 << kBits> values_;
};

} // namespace spheroseg
