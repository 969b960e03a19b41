// SPDX-License-Identifier: GPL-3.0-or-later
#include "errors.h"
#include "face_weights.h"
#include "orientation.h"
#include "parametrization.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

namespace spheroseg {

namespace {

constexpr double kUnitTolerance = 1e-4;

/// Area of the spherical triangle with these unit corners, negative when clockwise (van Oosterom,
/// Strackee: The Solid Angle of a Plane Triangle, 1983).
double spherical_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double determinant = dot(a, cross(b - a, c - a));
    return 2.0 * std::atan2(determinant, 1.0 + dot(a, b) + dot(b, c) + dot(c, a));
}

double flat_area(const Vec3& a, const Vec3& b, const Vec3& c) {
    return 0.5 * length(cross(b - a, c - a));
}

double squared_edges(const Vec3& a, const Vec3& b, const Vec3& c) {
    return dot(b - a, b - a) + dot(c - b, c - b) + dot(a - c, a - c);
}

} // namespace

ParametrizationQuality measure_parametrization(const TriangleMesh& mesh,
                                               const std::vector<Vec3>& sphere_positions) {
    if (sphere_positions.size() != mesh.positions.size()) {
        throw InvalidInput("Expected one position on the sphere for each of " +
                           std::to_string(mesh.positions.size()) + " vertices, found " +
                           std::to_string(sphere_positions.size()) +
                           ". Parametrize the mesh anew.");
    }
    ParametrizationQuality quality;
    const int face_count = mesh.face_count();
    if (face_count == 0) {
        return quality;
    }
    const std::vector<double> areas = face_areas(mesh);
    const double mesh_area = std::accumulate(areas.begin(), areas.end(), 0.0);
    quality.min_triangle_area = std::numeric_limits<double>::infinity();
    for (int f = 0; f < face_count; ++f) {
        const Triangle& t = mesh.faces[f];
        const Vec3& a = sphere_positions[t[0]];
        const Vec3& b = sphere_positions[t[1]];
        const Vec3& c = sphere_positions[t[2]];
        quality.flipped_triangle_count += orientation(a, b, c) <= 0;
        const double area = flat_area(a, b, c);
        quality.min_triangle_area = std::min(quality.min_triangle_area, area);
        quality.anisotropy_mean += squared_edges(a, b, c) / (4.0 * std::sqrt(3.0) * area);
        const double share = areas[f] / mesh_area;
        if (share > 0.0) {
            const double ratio = std::abs(spherical_area(a, b, c)) / kSphereArea / share;
            const double distortion = std::max(ratio, 1.0 / ratio);
            quality.area_distortion_mean += share * distortion;
            quality.area_distortion_max = std::max(quality.area_distortion_max, distortion);
        }
    }
    quality.anisotropy_mean /= face_count;
    return quality;
}

bool is_valid_parametrization(const TriangleMesh& mesh, const std::vector<Vec3>& sphere_positions) {
    if (sphere_positions.size() != mesh.positions.size()) {
        return false;
    }
    double covered = 0.0;
    for (const Triangle& t : mesh.faces) {
        for (int v : t) {
            // Also false for NaN.
            if (!(std::abs(length(sphere_positions[v]) - 1.0) <= kUnitTolerance)) {
                return false;
            }
        }
        const Vec3& a = sphere_positions[t[0]];
        const Vec3& b = sphere_positions[t[1]];
        const Vec3& c = sphere_positions[t[2]];
        if (orientation(a, b, c) <= 0) {
            return false;
        }
        covered += spherical_area(a, b, c);
    }
    // Triangles that all look outside may still wind around the sphere twice.
    return mesh.face_count() == 0 || covered < 1.5 * kSphereArea;
}

} // namespace spheroseg
