// SPDX-License-Identifier: GPL-3.0-or-later
#include "ring_energy.h"

#include <algorithm>
#include <limits>

namespace spheroseg {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kShapeWeight = 0.28867513459481287; // 1 / (2 sqrt(3)): A is half a determinant.

/// Determinants below this times the lengths of their two edges are not trusted: rounding of the
/// differences and products adds less than 16 * 2^-53 of it.
constexpr double kDeterminantMargin = 1e-14;

constexpr int kMaxHalvings = 4;
/// Of the way to the nearest flip.
constexpr double kStepFraction = 0.8;
constexpr int kMaxKernelHalvings = 44;

Vec3 normalized(const Vec3& a) {
    return a * (1.0 / length(a));
}

} // namespace

struct VertexRing::Derivatives {
    double value = 0.0;
    double x = 0.0;
    double y = 0.0;
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
};

bool VertexRing::encloses(const Vec3& v) const {
    Vec3 p = corners_.back() - v;
    double pp = dot(p, p);
    for (const Vec3& corner : corners_) {
        const Vec3 q = corner - v;
        const double qq = dot(q, q);
        const double det = dot(v, cross(p, q));
        if (!(det > 0.0 && det * det > kDeterminantMargin * kDeterminantMargin * pp * qq)) {
            return false;
        }
        p = q;
        pp = qq;
    }
    return true;
}

bool VertexRing::find_start(Vec3& v) const {
    Vec3 area;
    Vec3 mean;
    const std::size_t degree = corners_.size();
    const Vec3& t = corners_[0];
    for (std::size_t j = 0; j < degree; ++j) {
        mean = mean + (corners_[j] - t);
        if (j >= 1 && j + 1 < degree) {
            area = area + cross(corners_[j] - t, corners_[j + 1] - t);
        }
    }
    mean = t + mean * (1.0 / static_cast<double>(degree));
    for (const Vec3& candidate : {area, mean}) {
        if (dot(candidate, candidate) > 0.0) {
            v = normalized(candidate);
            if (encloses(v)) {
                return true;
            }
        }
    }
    // The sum of the inward normals of the two edges at corner 0 leads into the kernel there.
    const Vec3 first = corners_[1] - t;
    const Vec3 last = corners_.back() - t;
    const Vec3 inward_first = cross(t, first);
    const Vec3 inward_last = cross(last, t);
    const Vec3 inward = normalized(inward_first) + normalized(inward_last);
    double step = 0.5 * std::min(length(first), length(last)) / length(inward);
    for (int i = 0; i < kMaxKernelHalvings; ++i, step *= 0.5) {
        v = normalized(t + inward * step);
        if (encloses(v)) {
            return true;
        }
    }
    return false;
}

void VertexRing::set_frame(const Vec3& v) {
    // Of the coordinate axes the one that is farthest from v.
    const Vec3 axis = std::abs(v.x) < std::min(std::abs(v.y), std::abs(v.z)) ? Vec3{1, 0, 0}
        : std::abs(v.y) < std::abs(v.z)                                      ? Vec3{0, 1, 0}
                                                                             : Vec3{0, 0, 1};
    u_ = normalized(cross(v, axis));
    w_ = cross(v, u_);
    const std::size_t degree = corners_.size();
    local_.resize(degree);
    for (std::size_t j = 0; j < degree; ++j) {
        const Vec3 p = corners_[j] - v;
        local_[j].u = dot(p, u_);
        local_[j].w = dot(p, w_);
        local_[j].v = dot(p, v);
    }
    for (std::size_t j = 0; j < degree; ++j) {
        LocalCorner& p = local_[j];
        const LocalCorner& q = local_[j + 1 < degree ? j + 1 : 0];
        const double du = q.u - p.u;
        const double dw = q.w - p.w;
        const double dv = q.v - p.v;
        p.next_edge = du * du + dw * dw + dv * dv;
        p.det = p.u * q.w - p.w * q.u;
        p.det_u = p.w * q.v - p.v * q.w - dw;
        p.det_w = p.v * q.u - p.u * q.v + du;
    }
}

/// Derivatives of the distortion by the step (x, y) along u and w, at the vertex. After a step the
/// vertex is normalised, so that squared distances have second derivatives 2 (1 + p.v) and the
/// determinants -det.
VertexRing::Derivatives VertexRing::differentiate(const DistortionWeights& weights) const {
    const double area_factor =
        4.0 * weights.area_weight * weights.target_area * weights.target_area;
    const std::size_t degree = local_.size();
    Derivatives d;
    for (std::size_t j = 0; j < degree; ++j) {
        const LocalCorner& p = local_[j];
        const LocalCorner& q = local_[j + 1 < degree ? j + 1 : 0];
        const double inverse = 1.0 / p.det;
        const double edges =
            p.u * p.u + p.w * p.w + p.v * p.v + q.u * q.u + q.w * q.w + q.v * q.v + p.next_edge;
        const double edges_u = -2.0 * (p.u + q.u);
        const double edges_w = -2.0 * (p.w + q.w);
        const double edges_curvature = 2.0 * (2.0 + p.v + q.v);
        const double slope_u = p.det_u * inverse;
        const double slope_w = p.det_w * inverse;
        const double shape_scale = kShapeWeight * inverse;
        const double area = area_factor * inverse * inverse;
        d.value += shape_scale * edges + area;
        d.x += shape_scale * (edges_u - edges * slope_u) - 2.0 * area * slope_u;
        d.y += shape_scale * (edges_w - edges * slope_w) - 2.0 * area * slope_w;
        const double both = shape_scale * (edges_curvature + edges) + 2.0 * area;
        const double square = 2.0 * shape_scale * edges + 6.0 * area;
        d.xx += both - 2.0 * shape_scale * edges_u * slope_u + square * slope_u * slope_u;
        d.yy += both - 2.0 * shape_scale * edges_w * slope_w + square * slope_w * slope_w;
        d.xy += square * slope_u * slope_w - shape_scale * (edges_u * slope_w + edges_w * slope_u);
    }
    return d;
}

double VertexRing::distortion(double x, double y, const DistortionWeights& weights) const {
    const double area_factor =
        4.0 * weights.area_weight * weights.target_area * weights.target_area;
    const double scale = 1.0 / std::sqrt(1.0 + x * x + y * y);
    const double mx = x * scale;
    const double my = y * scale;
    // scale - 1 without cancellation.
    const double mz = -(x * x + y * y) * scale * scale / (1.0 + scale);
    const auto distance = [&](const LocalCorner& p) {
        return (p.u - mx) * (p.u - mx) + (p.w - my) * (p.w - my) + (p.v - mz) * (p.v - mz);
    };
    const std::size_t degree = local_.size();
    double p_distance = distance(local_[0]);
    double sum = 0.0;
    for (std::size_t j = 0; j < degree; ++j) {
        const LocalCorner& p = local_[j];
        const double q_distance = distance(local_[j + 1 < degree ? j + 1 : 0]);
        const double det = (p.det + x * p.det_u + y * p.det_w) * scale;
        if (!(det > 0.0)) {
            return kInfinity;
        }
        const double inverse = 1.0 / det;
        sum += inverse *
            (kShapeWeight * (p_distance + q_distance + p.next_edge) + area_factor * inverse);
        p_distance = q_distance;
    }
    return sum;
}

/// The part of the step (x, y) that leads to the first determinant of 0; infinite when none does.
double VertexRing::longest_step(double x, double y) const {
    double longest = kInfinity;
    for (const LocalCorner& p : local_) {
        const double slope = x * p.det_u + y * p.det_w;
        if (slope < 0.0 && p.det < -slope * longest) {
            longest = p.det / -slope;
        }
    }
    return longest;
}

Vec3 VertexRing::moved(const Vec3& v, double x, double y) const {
    return normalized(v + u_ * x + w_ * y);
}

void VertexRing::minimize(Vec3& v,
                          const DistortionWeights& weights,
                          int iteration_count,
                          double overshoot) {
    for (int iteration = 0; iteration < iteration_count; ++iteration) {
        set_frame(v);
        const Derivatives d = differentiate(weights);
        const double determinant = d.xx * d.yy - d.xy * d.xy;
        double x;
        double y;
        if (d.xx > 0.0 && determinant > 1e-12 * d.xx * d.yy) {
            x = -(d.yy * d.x - d.xy * d.y) / determinant;
            y = -(d.xx * d.y - d.xy * d.x) / determinant;
        } else {
            const double curvature = std::abs(d.xx) + std::abs(d.yy) + 2.0 * std::abs(d.xy);
            x = -d.x / curvature;
            y = -d.y / curvature;
        }
        const double norm = std::sqrt(x * x + y * y);
        // A step of 0.5 is about 27 degrees.
        double step = std::min({overshoot, kStepFraction * longest_step(x, y), 0.5 / norm});
        int halvings = 0;
        while (!(distortion(step * x, step * y, weights) < d.value)) {
            if (++halvings > kMaxHalvings) {
                return;
            }
            step *= 0.5;
        }
        const Vec3 candidate = moved(v, step * x, step * y);
        if (!encloses(candidate)) {
            return;
        }
        v = candidate;
    }
}

} // namespace spheroseg
