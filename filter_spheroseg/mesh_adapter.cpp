// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_adapter.h"

#include "errors.h"

#include <vcg/complex/algorithms/update/bounding.h>
#include <vcg/complex/algorithms/update/normal.h>

#include <cmath>
#include <string>

namespace spheroseg {

namespace {

/// Labels lie below: larger whole numbers have no exact value in single precision.
constexpr int kLabelLimit = 1 << 24;

using Allocator = vcg::tri::Allocator<CMeshO>;

Vec3 to_vec3(const Point3m& point) {
    return {static_cast<double>(point[0]),
            static_cast<double>(point[1]),
            static_cast<double>(point[2])};
}

Point3m to_point(const Vec3& v) {
    return Point3m(static_cast<Scalarm>(v.x), static_cast<Scalarm>(v.y), static_cast<Scalarm>(v.z));
}

} // namespace

HostMesh read_mesh(const CMeshO& host) {
    HostMesh adapted;
    adapted.vertex_index.reserve(host.vn);
    adapted.mesh.positions.reserve(host.vn);
    std::vector<int> compact_vertex(host.vert.size(), -1);
    for (std::size_t v = 0; v < host.vert.size(); ++v) {
        if (!host.vert[v].IsD()) {
            compact_vertex[v] = adapted.mesh.vertex_count();
            adapted.vertex_index.push_back(static_cast<int>(v));
            adapted.mesh.positions.push_back(to_vec3(host.vert[v].cP()));
        }
    }
    adapted.face_index.reserve(host.fn);
    adapted.mesh.faces.reserve(host.fn);
    for (std::size_t f = 0; f < host.face.size(); ++f) {
        if (host.face[f].IsD()) {
            continue;
        }
        Triangle triangle;
        for (int c = 0; c < 3; ++c) {
            triangle[c] = compact_vertex[vcg::tri::Index(host, host.face[f].cV(c))];
        }
        adapted.face_index.push_back(static_cast<int>(f));
        adapted.mesh.faces.push_back(triangle);
    }
    return adapted;
}

bool has_same_elements(const CMeshO& host,
                       const HostMesh& adapted,
                       const std::vector<Triangle>& faces) {
    const HostMesh now = read_mesh(host);
    return now.vertex_index == adapted.vertex_index && now.face_index == adapted.face_index &&
        now.mesh.faces == faces;
}

std::vector<int> read_labels(const CMeshO& host, const HostMesh& adapted) {
    if (!vcg::tri::HasPerFaceQuality(host)) {
        throw InvalidInput("Labels are expected in the face quality, but the mesh has none. Run a "
                           "segmentation first, or set the face quality.");
    }
    std::vector<int> labels(adapted.face_index.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const double quality = static_cast<double>(host.face[adapted.face_index[i]].cQ());
        // Written so that NaN fails as well.
        if (!(quality >= 0.0 && quality < kLabelLimit && quality == std::floor(quality))) {
            throw InvalidInput("Labels are expected as whole numbers from 0 to " +
                               std::to_string(kLabelLimit - 1) + " in the face quality, but face " +
                               std::to_string(adapted.face_index[i]) + " has " + to_text(quality) +
                               ". Run a segmentation first, or correct the face quality.");
        }
        labels[i] = static_cast<int>(quality);
    }
    return labels;
}

void check_label_range(int submesh_count) {
    if (submesh_count > kLabelLimit) {
        throw InvalidOptions("The face quality holds the labels of up to " +
                             std::to_string(kLabelLimit) + " sub-meshes, but " +
                             std::to_string(submesh_count) +
                             " are asked for. Ask for fewer sub-meshes.");
    }
}

std::vector<double>
read_face_attribute(const CMeshO& host, const HostMesh& adapted, const std::string& name) {
    const auto attribute = Allocator::FindPerFaceAttribute<Scalarm>(host, name);
    if (!Allocator::IsValidHandle<Scalarm>(host, attribute)) {
        std::vector<std::string> names;
        Allocator::GetAllPerFaceAttribute<Scalarm>(host, names);
        std::string listed;
        for (const std::string& other : names) {
            listed += (listed.empty() ? "" : ", ") + other;
        }
        throw InvalidInput("A per-face custom scalar attribute \"" + name +
                           "\" is expected as weight_attribute, but the mesh has " +
                           (listed.empty() ? "none of any name" : "only " + listed) +
                           ". Name one that is there, or leave weight_attribute empty for the "
                           "areas.");
    }
    std::vector<double> values(adapted.face_index.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = static_cast<double>(attribute[adapted.face_index[i]]);
    }
    return values;
}

std::optional<std::vector<Vec3>> read_sphere_positions(const CMeshO& host,
                                                       const HostMesh& adapted) {
    const auto attribute = Allocator::FindPerVertexAttribute<Point3m>(host, kSpherePosition);
    if (!Allocator::IsValidHandle<Point3m>(host, attribute)) {
        return std::nullopt;
    }
    std::vector<Vec3> positions(adapted.vertex_index.size());
    for (std::size_t i = 0; i < positions.size(); ++i) {
        positions[i] = to_vec3(attribute[adapted.vertex_index[i]]);
    }
    return positions;
}

void write_labels(CMeshO& host, const HostMesh& adapted, const std::vector<int>& labels) {
    for (std::size_t i = 0; i < labels.size(); ++i) {
        host.face[adapted.face_index[i]].Q() = static_cast<Scalarm>(labels[i]);
    }
}

void write_face_colors(CMeshO& host,
                       const HostMesh& adapted,
                       const std::vector<int>& labels,
                       const std::vector<std::array<std::uint8_t, 3>>& submesh_colors) {
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const auto& [red, green, blue] = submesh_colors[labels[i]];
        host.face[adapted.face_index[i]].C() = vcg::Color4b(red, green, blue, 255);
    }
}

void write_sphere_positions(CMeshO& host,
                            const HostMesh& adapted,
                            const std::vector<Vec3>& sphere_positions) {
    auto attribute = Allocator::FindPerVertexAttribute<Point3m>(host, kSpherePosition);
    if (!Allocator::IsValidHandle<Point3m>(host, attribute)) {
        Allocator::DeletePerVertexAttribute(host, kSpherePosition);
        attribute = Allocator::AddPerVertexAttribute<Point3m>(host, kSpherePosition);
    }
    for (std::size_t i = 0; i < sphere_positions.size(); ++i) {
        attribute[adapted.vertex_index[i]] = to_point(sphere_positions[i]);
    }
}

void move_vertices(CMeshO& host, const HostMesh& adapted, const std::vector<Vec3>& positions) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
        host.vert[adapted.vertex_index[i]].P() = to_point(positions[i]);
    }
    vcg::tri::UpdateNormal<CMeshO>::PerVertexNormalizedPerFaceNormalized(host);
    vcg::tri::UpdateBounding<CMeshO>::Box(host);
}

std::vector<Vec3> rounded_to_host(std::vector<Vec3> positions) {
    for (Vec3& position : positions) {
        position = to_vec3(to_point(position));
    }
    return positions;
}

} // namespace spheroseg
