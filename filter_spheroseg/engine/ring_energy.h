// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

namespace spheroseg {

/// Weights of the distortion that a vertex on the unit sphere is moved by. With L the sum of the
/// squared edge lengths of a triangle and A half the determinant of its corners (its area, where
/// it is small), a triangle costs
///     L / (4 sqrt(3) A) + area_weight * (target_area / A)^2.
/// The first term is least for equilateral triangles; both go to infinity where A goes to 0, and
/// the second keeps triangles from shrinking without end.
struct DistortionWeights {
    double target_area = 0.0;
    double area_weight = 0.0;
};

/// The triangles (v, ring[j], ring[j + 1]) around a vertex v that may move; 3 * degree corners on
/// the unit sphere. Reusable storage, one per thread.
class VertexRing {
public:
    void clear() { corners_.clear(); }
    void add(const Vec3& corner) { corners_.push_back(corner); }

    /// True when every triangle of the ring with its centre at `v` is certain to be
    /// counter-clockwise: its determinant exceeds any rounding error.
    bool encloses(const Vec3& v) const;

    /// Finds a position that the ring encloses when its fan around corner 0 is counter-clockwise:
    /// the normalised vector area, the normalised mean, or a point near corner 0, on the
    /// bisector of the edges that meet there. Returns false when rounding leaves no room.
    bool find_start(Vec3& v) const;

    /// Moves `v`, which the ring must enclose, by up to `iteration_count` damped Newton steps that
    /// lower the distortion; the ring encloses the result. An `overshoot` between 1 and 2 lengthens
    /// the steps: sweeps over many vertices then converge faster (successive over-relaxation).
    void minimize(Vec3& v,
                  const DistortionWeights& weights,
                  int iteration_count,
                  double overshoot = 1.0);

private:
    struct Derivatives;
    /// A corner in the frame (u, w, v) at the vertex, relative to it.
    struct LocalCorner {
        double u;
        double w;
        double v;
        /// Squared length of the edge to the next corner.
        double next_edge;
        /// Determinant of the triangle at this corner: value and slope along u and w.
        double det;
        double det_u;
        double det_w;
    };

    void set_frame(const Vec3& v);
    Derivatives differentiate(const DistortionWeights& weights) const;
    double distortion(double x, double y, const DistortionWeights& weights) const;
    double longest_step(double x, double y) const;
    Vec3 moved(const Vec3& v, double x, double y) const;

    std::vector<Vec3> corners_;
    std::vector<LocalCorner> local_;
    Vec3 u_;
    Vec3 w_;
};

} // namespace spheroseg
