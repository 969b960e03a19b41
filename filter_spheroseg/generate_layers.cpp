// SPDX-License-Identifier: GPL-3.0-or-later
#include "generate_layers.h"

#include "errors.h"
#include "new_layers.h"

#include <vcg/complex/algorithms/update/bounding.h>
#include <vcg/complex/algorithms/update/flag.h>
#include <vcg/complex/algorithms/update/selection.h>

#include <QStringList>

#include <algorithm>
#include <numeric>

namespace spheroseg {

QString layer_name(const MeshModel& source, const QString& part) {
    static const QStringList suffixes = {"ply", "obj",  "qobj", "off", "stl",  "3ds", "dae", "ctm",
                                         "glb", "gltf", "wrl",  "x3d", "x3dv", "vmi", "fbx", "u3d",
                                         "e57", "pts",  "apts", "ptx", "xyz",  "asc", "txt", "gts",
                                         "tri", "bre",  "nxs",  "nxz", "3mf",  "dxf"};
    QString name = source.label();
    const int dot = name.lastIndexOf('.');
    if (dot >= 0 && suffixes.contains(name.mid(dot + 1), Qt::CaseInsensitive)) {
        name.truncate(dot);
    }
    return (name + " " + part).trimmed();
}

void copy_texture_images(const MeshModel& source, MeshModel& layer) {
    for (const auto& [name, image] : source.getTextures()) {
        layer.addTexture(name, image); // shares the pixels
    }
}

namespace {

using Allocator = vcg::tri::Allocator<CMeshO>;

// Topology is the layer's own and is computed when a filter asks for it.
constexpr int kNotCopied = MeshModel::MM_FACEFACETOPO | MeshModel::MM_VERTFACETOPO;

/// Elements of the source that make up one layer, in the layer's order. `compact_` counts without
/// deleted elements, `host_` with them.
struct Part {
    std::vector<int> compact_faces;
    std::vector<int> compact_vertices;
    std::vector<int> host_faces;
    std::vector<int> host_vertices;
};

/// Collects parts one after the other; `local_` is kept between them, so a part costs its own size.
class PartCollector {
public:
    explicit PartCollector(const HostMesh& host)
        : host_(host), local_(host.mesh.positions.size(), -1) {}

    Part collect(std::vector<int> compact_faces) {
        Part part;
        part.compact_faces = std::move(compact_faces);
        for (int face : part.compact_faces) {
            part.host_faces.push_back(host_.face_index[face]);
            for (int vertex : host_.mesh.faces[face]) {
                if (local_[vertex] < 0) {
                    local_[vertex] = 0;
                    part.compact_vertices.push_back(vertex);
                }
            }
        }
        std::sort(part.compact_vertices.begin(), part.compact_vertices.end());
        for (std::size_t i = 0; i < part.compact_vertices.size(); ++i) {
            local_[part.compact_vertices[i]] = static_cast<int>(i);
            part.host_vertices.push_back(host_.vertex_index[part.compact_vertices[i]]);
        }
        return part;
    }

    int local_index(int compact_vertex) const { return local_[compact_vertex]; }

    void forget(const Part& part) {
        for (int vertex : part.compact_vertices) {
            local_[vertex] = -1;
        }
    }

private:
    const HostMesh& host_;
    std::vector<int> local_;
};

template <class Value>
void copy_vertex_attributes(const CMeshO& source, const Part& part, CMeshO& target) {
    std::vector<std::string> names;
    Allocator::GetAllPerVertexAttribute<Value>(source, names);
    for (const std::string& name : names) {
        if (name == kSourceVertex) {
            continue;
        }
        const auto from = Allocator::FindPerVertexAttribute<Value>(source, name);
        auto to = Allocator::AddPerVertexAttribute<Value>(target, name);
        for (std::size_t i = 0; i < part.host_vertices.size(); ++i) {
            to[i] = from[part.host_vertices[i]];
        }
    }
}

template <class Value>
void copy_face_attributes(const CMeshO& source, const Part& part, CMeshO& target) {
    std::vector<std::string> names;
    Allocator::GetAllPerFaceAttribute<Value>(source, names);
    for (const std::string& name : names) {
        if (name == kSourceFace) {
            continue;
        }
        const auto from = Allocator::FindPerFaceAttribute<Value>(source, name);
        auto to = Allocator::AddPerFaceAttribute<Value>(target, name);
        for (std::size_t i = 0; i < part.host_faces.size(); ++i) {
            to[i] = from[part.host_faces[i]];
        }
    }
}

void write_source_attributes(const Part& part, CMeshO& target) {
    auto vertices = Allocator::AddPerVertexAttribute<Scalarm>(target, kSourceVertex);
    for (std::size_t i = 0; i < part.compact_vertices.size(); ++i) {
        vertices[i] = static_cast<Scalarm>(part.compact_vertices[i]);
    }
    auto faces = Allocator::AddPerFaceAttribute<Scalarm>(target, kSourceFace);
    for (std::size_t i = 0; i < part.compact_faces.size(); ++i) {
        faces[i] = static_cast<Scalarm>(part.compact_faces[i]);
    }
}

/// The inner edges of polygons are marked. Where a polygon was cut, they lie on the border now, and
/// MeshLab would write it broken.
void unmark_inner_edges_on_border(CMeshO& layer) {
    const auto has_inner_edge = [](const CFaceO& face) { return face.IsAnyF(); };
    if (std::none_of(layer.face.begin(), layer.face.end(), has_inner_edge)) {
        return;
    }
    vcg::tri::UpdateFlags<CMeshO>::FaceBorderFromNone(layer);
    for (CFaceO& face : layer.face) {
        for (int c = 0; c < 3; ++c) {
            if (face.IsB(c)) {
                face.ClearF(c);
            }
        }
    }
}

void fill_layer(const CMeshO& source,
                const HostMesh& host,
                const PartCollector& collector,
                const Part& part,
                CMeshO& target) {
    Allocator::AddVertices(target, part.host_vertices.size());
    Allocator::AddFaces(target, part.host_faces.size());
    for (std::size_t i = 0; i < part.host_vertices.size(); ++i) {
        target.vert[i].ImportData(source.vert[part.host_vertices[i]]);
    }
    for (std::size_t i = 0; i < part.host_faces.size(); ++i) {
        target.face[i].ImportData(source.face[part.host_faces[i]]);
        const Triangle& corners = host.mesh.faces[part.compact_faces[i]];
        for (int c = 0; c < 3; ++c) {
            target.face[i].V(c) = &target.vert[collector.local_index(corners[c])];
        }
    }
    unmark_inner_edges_on_border(target);
    copy_vertex_attributes<Scalarm>(source, part, target);
    copy_vertex_attributes<Point3m>(source, part, target);
    copy_face_attributes<Scalarm>(source, part, target);
    copy_face_attributes<Point3m>(source, part, target);
    write_source_attributes(part, target);
    target.textures = source.textures;
    target.normalmaps = source.normalmaps;
    target.Tr = source.Tr;
    vcg::tri::UpdateSelection<CMeshO>::Clear(target);
    vcg::tri::UpdateBounding<CMeshO>::Box(target);
}

void require_vertices(const HostMesh& host) {
    for (std::size_t face = 0; face < host.mesh.faces.size(); ++face) {
        for (int vertex : host.mesh.faces[face]) {
            if (vertex < 0) {
                throw InvalidInput("Face " + std::to_string(host.face_index[face]) +
                                   " uses a deleted vertex. Repair the mesh first.");
            }
        }
    }
}

/// All faces, those of equal labels one after the other in the order of the mesh.
std::vector<int> faces_by_label(const std::vector<int>& labels) {
    std::vector<int> faces(labels.size());
    std::iota(faces.begin(), faces.end(), 0);
    std::stable_sort(
        faces.begin(), faces.end(), [&](int a, int b) { return labels[a] < labels[b]; });
    return faces;
}

} // namespace

int generate_submesh_layers(MeshDocument& document,
                            const MeshModel& source,
                            const HostMesh& host,
                            const std::vector<int>& labels,
                            const Progress& progress) {
    require_vertices(host);
    const std::vector<int> faces = faces_by_label(labels);
    PartCollector collector(host);
    NewLayers layers(document);
    for (auto begin = faces.begin(); begin != faces.end();) {
        const auto done = static_cast<double>(begin - faces.begin());
        report_progress(progress, done / static_cast<double>(faces.size()), "Layers");
        const int label = labels[*begin];
        const auto end =
            std::find_if(begin, faces.end(), [&](int face) { return labels[face] != label; });
        const Part part = collector.collect({begin, end});
        MeshModel& layer = layers.add(layer_name(source, QString::number(label)));
        layer.updateDataMask(source.dataMask() & ~kNotCopied);
        fill_layer(source.cm, host, collector, part, layer.cm);
        copy_texture_images(source, layer);
        collector.forget(part);
        begin = end;
    }
    layers.keep();
    return layers.count();
}

} // namespace spheroseg
