// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

#include <string>

namespace spheroseg {

/// What a mesh is. Counts are 0 where nothing was found; `first_...` is an index or -1.
struct MeshReport {
    int face_count = 0;
    int referenced_vertex_count = 0;
    int edge_count = 0;
    /// Components of faces joined by shared edges.
    int component_count = 0;
    int boundary_edge_count = 0;
    int first_boundary_face = -1;
    /// Edges with more than two faces.
    int non_manifold_edge_count = 0;
    int first_non_manifold_face = -1;
    /// Edges whose two faces run along them in the same direction.
    int inconsistent_edge_count = 0;
    int first_inconsistent_face = -1;
    /// Referenced vertices whose faces are more than one edge-connected fan.
    int non_manifold_vertex_count = 0;
    int first_non_manifold_vertex = -1;
    /// Faces that name a vertex twice (zero-area faces with three different vertices are not
    /// degenerate in this sense).
    int degenerate_face_count = 0;
    int first_degenerate_face = -1;
    /// Faces with the same three vertices as an earlier face.
    int duplicate_face_count = 0;
    int first_duplicate_face = -1;
    /// Referenced vertices with a NaN or infinite coordinate.
    int non_finite_vertex_count = 0;
    int first_non_finite_vertex = -1;
    /// V - E + F over referenced vertices.
    int euler_characteristic = 0;
    /// Sum of genera when closed, manifold and oriented; else -1.
    int genus = -1;

    bool is_closed_genus_zero() const;
    /// What `measure` may know of the mesh.
    VertexFanCount fans_per_vertex() const;
};

/// Examines a mesh in O(F log F). Its vertex indices must be in range, as `build_dual_graph`
/// checks.
MeshReport inspect(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count = 0);

/// Empty when `report` describes one closed, oriented, manifold component of genus 0 with finite
/// coordinates; else one message: what was expected, what was found (count and first index), and
/// which MeshLab filter mends it.
std::string closed_genus_zero_error(const MeshReport& report);

/// Empty when the faces make surfaces: at least one face, finite coordinates, three different
/// vertices in every face, and no edge with more than two faces. Open borders, handles, several
/// components, pinched vertices and any orientation are fine. Else a message as above.
std::string surface_error(const MeshReport& report);

/// The message for fewer sub-meshes than components.
std::string too_many_components_error(const MeshReport& report, int submesh_count);

} // namespace spheroseg
