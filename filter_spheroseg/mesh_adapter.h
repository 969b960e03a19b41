// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

#include <common/ml_document/cmesh.h>

#include <optional>
#include <string>

namespace spheroseg {

/// Name of the per-vertex point attribute that holds the spherical parametrization.
inline constexpr const char* kSpherePosition = "sphere_position";

/// The faces and vertices of a host mesh that are not deleted, in the host's order, with their
/// indices there. A face that uses a deleted vertex gets vertex index -1, which the engine rejects.
struct HostMesh {
    TriangleMesh mesh;
    std::vector<int> face_index;
    std::vector<int> vertex_index;
};

/// O(V + F).
HostMesh read_mesh(const CMeshO& host);

/// True when the host still has all elements where they were when `adapted` was read from it, and
/// no others, and its faces the same vertices. `faces`: adapted.mesh.faces, which may have been
/// moved from.
bool has_same_elements(const CMeshO& host,
                       const HostMesh& adapted,
                       const std::vector<Triangle>& faces);

/// Labels in face quality, one per face of `adapted`. Throws InvalidInput when the mesh has no face
/// quality, or when a value is not a whole number in [0, 2^24): a single precision host holds no
/// larger ones exactly.
std::vector<int> read_labels(const CMeshO& host, const HostMesh& adapted);

/// Throws InvalidOptions when `submesh_count` sub-meshes have more labels than face quality can
/// hold, 2^24.
void check_label_range(int submesh_count);

/// A per-face custom scalar attribute. Throws InvalidInput when the mesh has none with this name;
/// the message lists those that it has.
std::vector<double>
read_face_attribute(const CMeshO& host, const HostMesh& adapted, const std::string& name);

/// The `sphere_position` attribute, or nothing when the mesh has none.
std::optional<std::vector<Vec3>> read_sphere_positions(const CMeshO& host, const HostMesh& adapted);

/// Writes labels to face quality, which must be enabled.
void write_labels(CMeshO& host, const HostMesh& adapted, const std::vector<int>& labels);

/// Gives each face the colour of its label; face colours must be enabled.
void write_face_colors(CMeshO& host,
                       const HostMesh& adapted,
                       const std::vector<int>& labels,
                       const std::vector<std::array<std::uint8_t, 3>>& submesh_colors);

/// Writes the `sphere_position` attribute; creates it when it is missing, and replaces one of
/// another type.
void write_sphere_positions(CMeshO& host,
                            const HostMesh& adapted,
                            const std::vector<Vec3>& sphere_positions);

/// Moves the vertices, and updates normals and the bounding box.
void move_vertices(CMeshO& host, const HostMesh& adapted, const std::vector<Vec3>& positions);

/// `positions` as the host's scalar type stores them.
std::vector<Vec3> rounded_to_host(std::vector<Vec3> positions);

} // namespace spheroseg
