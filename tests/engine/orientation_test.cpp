// SPDX-License-Identifier: GPL-3.0-or-later
#include "orientation.h"

#include "random.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

__extension__ using Wide = __int128;

/// Sign of a determinant of integers below 2^40 in size, in 128 bits.
int integer_orientation(const std::array<std::array<std::int64_t, 3>, 3>& m) {
    const auto minor = [&](int i, int j) {
        return static_cast<Wide>(m[1][i]) * m[2][j] - static_cast<Wide>(m[1][j]) * m[2][i];
    };
    const Wide det = m[0][0] * minor(1, 2) - m[0][1] * minor(0, 2) + m[0][2] * minor(0, 1);
    return det > 0 ? 1 : det < 0 ? -1 : 0;
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
    const auto integer = [&](int bits) {
        return static_cast<std::int64_t>(random.next() >> (64 - bits)) -
            (std::int64_t{1} << (bits - 1));
    };
    int zeros = 0;
    for (int i = 0; i < 20000; ++i) {
        std::array<std::array<std::int64_t, 3>, 3> m{};
        const std::int64_t s = integer(8);
        const std::int64_t t = integer(8);
        for (int c = 0; c < 3; ++c) {
            m[0][c] = integer(28);
            m[1][c] = integer(28);
            m[2][c] = s * m[0][c] + t * m[1][c];
        }
        m[2][i % 3] += static_cast<int>(random.below(3)) - 1;
        const auto row = [&](int r) {
            return Vec3{static_cast<double>(m[r][0]),
                        static_cast<double>(m[r][1]),
                        static_cast<double>(m[r][2])};
        };
        const int expected = integer_orientation(m);
        zeros += expected == 0;
        EXPECT_EQ(orientation(row(0), row(1), row(2)), expected);
        EXPECT_EQ(orientation(row(1), row(0), row(2)), -expected);
    }
    EXPECT_GT(zeros, 1000);
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
