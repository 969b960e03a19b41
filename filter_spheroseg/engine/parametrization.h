// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hierarchy.h"

namespace spheroseg {

/// Spherical parametrization: one unit vector per vertex; (0, 0, 1) for unreferenced vertices.
struct Parametrization {
    std::vector<Vec3> positions;
};

/// How good a spherical map is.
struct ParametrizationQuality {
    /// Triangles whose corners are not counter-clockwise seen from outside (exact predicate).
    int flipped_triangle_count = 0;
    /// Least area of a flat triangle on the sphere; the whole sphere has 4 pi.
    double min_triangle_area = 0.0;
    /// Area of a triangle on the sphere over 4 pi, over its area on the mesh over the mesh's:
    /// mean (area-weighted on the mesh) and largest of max(ratio, 1 / ratio); 0 for a mesh that
    /// has no area.
    double area_distortion_mean = 0.0;
    double area_distortion_max = 0.0;
    /// Mean over triangles of (sum of squared edge lengths) / (4 sqrt(3) area) on the sphere;
    /// 1 for equilateral triangles.
    double anisotropy_mean = 0.0;
};

/// Area of the unit sphere.
constexpr double kSphereArea = 12.566370614359172;

/// Maps a closed manifold genus-0 mesh onto the unit sphere without flipped triangles, by
/// re-inserting the vertices of `hierarchy` in reverse order, each where an angle-preserving
/// distortion is least within the kernel of its ring, with smoothing between the rounds.
/// Parallel, O(F log F); the result does not depend on the number of threads. The map is verified
/// before it is returned. Throws Cancelled, and InvalidInput when the hierarchy does not end at a
/// tetrahedron or no valid map was found.
/// Source: Spherical Parametric Measurement for Continuous and Balanced Mesh Segmentation, sec. 5.
Parametrization parametrize(const TriangleMesh& mesh,
                            const CollapseHierarchy& hierarchy,
                            int thread_count = 0,
                            const Progress& progress = {});

/// Faces without area on the mesh have no part in the area distortion.
/// Throws InvalidInput when the sizes differ.
ParametrizationQuality measure_parametrization(const TriangleMesh& mesh,
                                               const std::vector<Vec3>& sphere_positions);

/// True when there is one finite unit vector per referenced vertex (within 1e-4, so that single
/// precision hosts pass), no triangle is flipped or of zero area, and the triangles cover the
/// sphere once.
bool is_valid_parametrization(const TriangleMesh& mesh, const std::vector<Vec3>& sphere_positions);

} // namespace spheroseg
