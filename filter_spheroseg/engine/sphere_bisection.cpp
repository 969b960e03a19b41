// SPDX-License-Identifier: GPL-3.0-or-later
#include "sphere_bisection.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace spheroseg {

namespace {

/// Squarings of the covariance matrix: 2^20 steps of the power iteration.
constexpr int kSquarings = 20;

using Matrix = std::array<Vec3, 3>; // symmetric, by columns

Matrix scaled(const Matrix& m) {
    const double trace = m[0].x + m[1].y + m[2].z;
    const double scale = trace > 0.0 ? 1.0 / trace : 0.0;
    return {m[0] * scale, m[1] * scale, m[2] * scale};
}

/// Direction of the largest spread; any direction when there is none.
Vec3 principal_axis(const Matrix& covariance) {
    Matrix power = scaled(covariance);
    for (int i = 0; i < kSquarings; ++i) {
        Matrix square;
        for (int c = 0; c < 3; ++c) {
            square[c] = {dot(power[0], power[c]), dot(power[1], power[c]), dot(power[2], power[c])};
        }
        power = scaled(square);
    }
    return *std::max_element(power.begin(), power.end(), [](const Vec3& a, const Vec3& b) {
        return dot(a, a) < dot(b, b);
    });
}

class SphereBisection {
public:
    SphereBisection(const std::vector<Vec3>& points, int part_count)
        : points_(points), part_count_(part_count), labels_(points.size(), 0),
          order_(points.size()) {
        std::iota(order_.begin(), order_.end(), 0);
    }

    std::vector<int> run() {
        split(0, static_cast<int>(points_.size()), 0, part_count_);
        return std::move(labels_);
    }

private:
    using Key = std::pair<double, int>; // place along the axis, index: all different

    /// Faces of the labels below `label`.
    int face_count_below(int label) const {
        const int face_count = static_cast<int>(points_.size());
        return face_count / part_count_ * label + std::min(label, face_count % part_count_);
    }

    Vec3 axis_of(int begin, int end) const {
        Vec3 mean;
        for (int i = begin; i < end; ++i) {
            mean = mean + points_[order_[i]];
        }
        mean = mean * (1.0 / (end - begin));
        Matrix covariance;
        for (int i = begin; i < end; ++i) {
            const Vec3 p = points_[order_[i]] - mean;
            covariance = {
                covariance[0] + p * p.x, covariance[1] + p * p.y, covariance[2] + p * p.z};
        }
        return principal_axis(covariance);
    }

    /// Labels the points order_[begin, end) with [label, label + parts).
    void split(int begin, int end, int label, int parts) {
        if (parts == 1) {
            for (int i = begin; i < end; ++i) {
                labels_[order_[i]] = label;
            }
            return;
        }
        const int left_parts = parts / 2;
        const int middle = begin + face_count_below(label + left_parts) - face_count_below(label);
        const Vec3 axis = axis_of(begin, end);
        const auto key = [&](int face) { return Key{dot(points_[face], axis), face}; };
        keys_.clear();
        for (int i = begin; i < end; ++i) {
            keys_.push_back(key(order_[i]));
        }
        const auto cut = keys_.begin() + (middle - begin);
        std::nth_element(keys_.begin(), cut, keys_.end());
        // Both sides stay in the order of the faces, so that sums do not depend on the library.
        std::stable_partition(
            order_.begin() + begin, order_.begin() + end, [&, first_right = *cut](int face) {
                return key(face) < first_right;
            });
        split(begin, middle, label, left_parts);
        split(middle, end, label + left_parts, parts - left_parts);
    }

    const std::vector<Vec3>& points_;
    const int part_count_;
    std::vector<int> labels_;
    std::vector<int> order_;
    std::vector<Key> keys_;
};

} // namespace

std::vector<int> balanced_sphere_labels(const std::vector<Vec3>& face_centroids,
                                        int submesh_count) {
    return SphereBisection(face_centroids, submesh_count).run();
}

} // namespace spheroseg
