// SPDX-License-Identifier: GPL-3.0-or-later
#include "orientation.h"

#include "random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace spheroseg {
namespace {

__extension__ using Wide = __int128;
using Rows = std::array<std::array<std::int64_t, 3>, 3>;

/// A random integer in [-2^(bits - 1), 2^(bits - 1)).
std::int64_t integer(Random& random, int bits) {
    return static_cast<std::int64_t>(random.next() >> (64 - bits)) -
        (std::int64_t{1} << (bits - 1));
}

/// Sign of a determinant of integers whose products fit into 125 bits.
int integer_orientation(const Rows& m) {
    const auto minor = [&](int i, int j) {
        return static_cast<Wide>(m[1][i]) * m[2][j] - static_cast<Wide>(m[1][j]) * m[2][i];
    };
    const Wide det = m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1);
    return det > 0 ? 1 : det < 0 ? -1 : 0;
}

/// Expects that of `orientation`, either way round; returns it.
int expect_integer_orientation(const Rows& m) {
    const auto row = [&](int r) {
        return Vec3{static_cast<double>(m[r][0]),
                    static_cast<double>(m[r][1]),
                    static_cast<double>(m[r][2])};
    };
    const int expected = integer_orientation(m);
    EXPECT_EQ(orientation(row(0), row(1), row(2)), expected);
    EXPECT_EQ(orientation(row(1), row(0), row(2)), -expected);
    return expected;
}

TEST(Orientation, OfTheAxes) {
    const Vec3 x = {1, 0, 0};
    const Vec3 y = {0, 1, 0};
    const Vec3 z = {0, 0, 1};
    EXPECT_EQ(orientation(x, y, z), 1);
    EXPECT_EQ(orientation(y, x, z), -1);
    EXPECT_EQ(orientation(x, y, x), 0);
    EXPECT_EQ(orientation(x, y, {0.3, -0.7, 0.0}), 0);
}

TEST(Orientation, AgreesWithIntegerArithmeticOnNearlyFlatTriples) {
    Random random(11);
    int zeros = 0;
    for (int i = 0; i < 20000; ++i) {
        Rows m{};
        const std::int64_t s = integer(random, 8);
        const std::int64_t t = integer(random, 8);
        for (int c = 0; c < 3; ++c) {
            m[0][c] = integer(random, 28);
            m[1][c] = integer(random, 28);
            m[2][c] = s * m[0][c] + t * m[1][c];
        }
        m[2][i % 3] += static_cast<int>(random.below(3)) - 1;
        zeros += expect_integer_orientation(m) == 0;
    }
    EXPECT_GT(zeros, 1000);
}

TEST(Orientation, AgreesWithIntegerArithmeticOnNearlyParallelTriples) {
    // The determinant is about 2^-80 of its terms: rounded ones say nothing about its sign.
    Random random(12);
    int signs[3] = {};
    for (int i = 0; i < 20000; ++i) {
        Rows m{};
        const std::int64_t s = integer(random, 8);
        const std::int64_t t = integer(random, 8);
        for (int c = 0; c < 3; ++c) {
            m[0][c] = integer(random, 28);
            m[1][c] = s * m[0][c] + integer(random, 2);
            m[2][c] = t * m[1][c] + s * m[0][c] + integer(random, 2);
        }
        ++signs[expect_integer_orientation(m) + 1];
    }
    EXPECT_GT(*std::min_element(std::begin(signs), std::end(signs)), 1000);
}

TEST(Orientation, SeesTheLastBit) {
    const Vec3 a = {1.0, 0x1.0p-40, 0.0};
    const Vec3 b = {1.0, 0x1.0p-40, 0x1.0p-200};
    const Vec3 c = {1.0, 0x1.0000000000001p-40, 0.0};
    EXPECT_EQ(orientation(a, b, c), -orientation(a, c, b));
    EXPECT_NE(orientation(a, b, c), 0);
}

} // namespace
} // namespace spheroseg
