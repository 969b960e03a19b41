// SPDX-License-Identifier: GPL-3.0-or-later
#include "orientation.h"

namespace spheroseg {

namespace {

/// A sum of doubles that do not overlap, smallest first: exact.
class Expansion {
public:
    void add(double value) {
        int count = 0;
        for (int i = 0; i < count_; ++i) {
            const double sum = value + parts_[i];
            const double virtual_part = sum - value;
            const double error = (value - (sum - virtual_part)) + (parts_[i] - virtual_part);
            if (error != 0.0) {
                parts_[count++] = error;
            }
            value = sum;
        }
        parts_[count++] = value;
        count_ = count;
    }

    void add_product(double a, double b, double c) {
        const double high = a * b;
        const double low = std::fma(a, b, -high);
        for (double factor : {low, high}) {
            const double product = factor * c;
            add(std::fma(factor, c, -product));
            add(product);
        }
    }

    int sign() const {
        for (int i = count_; i-- > 0;) {
            if (parts_[i] != 0.0) {
                return parts_[i] > 0.0 ? 1 : -1;
            }
        }
        return 0;
    }

private:
    std::array<double, 25> parts_;
    int count_ = 0;
};

} // namespace

int orientation(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double xy = b.x * c.y;
    const double yx = b.y * c.x;
    const double yz = b.y * c.z;
    const double zy = b.z * c.y;
    const double zx = b.z * c.x;
    const double xz = b.x * c.z;
    const double determinant = a.x * (yz - zy) + a.y * (zx - xz) + a.z * (xy - yx);
    const double permanent = std::abs(a.x) * (std::abs(yz) + std::abs(zy)) +
        std::abs(a.y) * (std::abs(zx) + std::abs(xz)) +
        std::abs(a.z) * (std::abs(xy) + std::abs(yx));
    // Six roundings at most on the way of each term; 8 * 2^-53 leaves room for the bound's own.
    const double bound = 8.0 * 0x1.0p-53 * permanent;
    if (determinant > bound || determinant < -bound) {
        return determinant > 0.0 ? 1 : -1;
    }
    Expansion exact;
    exact.add_product(a.x, b.y, c.z);
    exact.add_product(-a.x, b.z, c.y);
    exact.add_product(a.y, b.z, c.x);
    exact.add_product(-a.y, b.x, c.z);
    exact.add_product(a.z, b.x, c.y);
    exact.add_product(-a.z, b.y, c.x);
    return exact.sign();
}

} // namespace spheroseg
