// SPDX-License-Identifier: GPL-3.0-or-later
#include "component.h"

#include <algorithm>
#include <utility>

namespace spheroseg {

Component::Component(const TriangleMesh& mesh,
                     const DualGraph& dual_graph,
                     std::vector<int> faces,
                     const std::vector<int>& local_index)
    : faces_(std::move(faces)), own_(std::make_unique<Surface>()), mesh_(&own_->mesh),
      dual_graph_(&own_->dual_graph) {
    std::vector<int> vertices;
    vertices.reserve(3 * faces_.size());
    for (int f : faces_) {
        vertices.insert(vertices.end(), mesh.faces[f].begin(), mesh.faces[f].end());
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    own_->mesh.positions.resize(vertices.size());
    own_->mesh.faces.reserve(faces_.size());
    own_->dual_graph.neighbors.reserve(faces_.size());
    for (int f : faces_) {
        Triangle triangle;
        std::array<int, 3> neighbors;
        for (int c = 0; c < 3; ++c) {
            triangle[c] = static_cast<int>(
                std::lower_bound(vertices.begin(), vertices.end(), mesh.faces[f][c]) -
                vertices.begin());
            const int g = dual_graph.neighbors[f][c];
            neighbors[c] = g < 0 ? -1 : local_index[g];
        }
        own_->mesh.faces.push_back(triangle);
        own_->dual_graph.neighbors.push_back(neighbors);
    }
    orient_alike(own_->mesh, own_->dual_graph);
}

Component::Component(const TriangleMesh& mesh, const DualGraph& dual_graph)
    : mesh_(&mesh), dual_graph_(&dual_graph) {}

const CollapseHierarchy& Component::hierarchy(int thread_count, const Progress& progress) {
    if (!hierarchy_) {
        hierarchy_ = build_hierarchy(*mesh_, *dual_graph_, thread_count, progress);
    }
    return *hierarchy_;
}

const Multilevel& Component::multilevel(int thread_count, const Progress& progress) {
    if (!multilevel_ && hierarchy_) {
        multilevel_.emplace(*hierarchy_, face_count(), thread_count);
    } else if (!multilevel_) {
        multilevel_.emplace(build_hierarchy(*mesh_, *dual_graph_, thread_count, progress),
                            face_count(),
                            thread_count);
    }
    return *multilevel_;
}

const Multilevel& Component::finest_level(int thread_count) {
    if (!finest_level_) {
        finest_level_.emplace(*mesh_, *dual_graph_, thread_count);
    }
    return *finest_level_;
}

std::vector<std::vector<int>> faces_of_components(const DualGraph& dual_graph) {
    const FaceComponents found = face_components(dual_graph);
    std::vector<std::vector<int>> components(found.count());
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        components[found.of_face[f]].push_back(f);
    }
    return components;
}

void orient_alike(TriangleMesh& mesh, DualGraph& dual_graph) {
    std::vector<std::uint8_t> seen(mesh.faces.size(), 0);
    std::vector<int> queue;
    for (int start = 0; start < mesh.face_count(); ++start) {
        if (seen[start]) {
            continue;
        }
        seen[start] = 1;
        queue.assign(1, start);
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const int f = queue[head];
            for (int c = 0; c < 3; ++c) {
                const int g = dual_graph.neighbors[f][c];
                if (g < 0 || seen[g]) {
                    continue;
                }
                seen[g] = 1;
                queue.push_back(g);
                Triangle& face = mesh.faces[g];
                const int at = corner_of(face, mesh.faces[f][c]);
                if (face[(at + 1) % 3] == mesh.faces[f][(c + 1) % 3]) {
                    std::swap(face[1], face[2]);
                    std::swap(dual_graph.neighbors[g][0], dual_graph.neighbors[g][2]);
                }
            }
        }
    }
}

} // namespace spheroseg
