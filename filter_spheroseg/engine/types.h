// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace spheroseg {

struct Vec3 {
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Vec3 operator*(const Vec3& a, double s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline Vec3 operator*(double s, const Vec3& a) {
    return a * s;
}
inline double dot(const Vec3& a, const Vec3& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(const Vec3& a) {
    return std::sqrt(dot(a, a));
}

/// Three vertex indices, counter-clockwise seen from outside.
using Triangle = std::array<int, 3>;

/// The corner, 0 to 2, of a triangle that is at one of its vertices.
inline int corner_of(const Triangle& triangle, int vertex) {
    return triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
}

/// The most faces that a mesh may have: their sides are numbered in an int, with three bits to
/// spare.
constexpr int kMaxFaces = 1 << 28;

/// Indexed triangle mesh. Vertex indices in `faces` lie in [0, positions.size()).
/// Vertices that no face refers to are allowed and ignored.
struct TriangleMesh {
    std::vector<Vec3> positions;
    std::vector<Triangle> faces;

    int vertex_count() const { return static_cast<int>(positions.size()); }
    int face_count() const { return static_cast<int>(faces.size()); }
};

} // namespace spheroseg
