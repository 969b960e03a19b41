// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_levels.h"

#include "bisection.h"
#include "random.h"
#include "recount.h"
#include "repair.h"

#include <algorithm>
#include <numeric>

namespace spheroseg::fuzz {

namespace {

TriangleMesh mesh_of(const Patchwork& patchwork) {
    TriangleMesh mesh;
    int vertex_count = 0;
    for (const Cell& cell : patchwork.cells) {
        const auto& v = cell.vertex;
        mesh.faces.push_back({v[0], v[1], v[2]});
        vertex_count = std::max({vertex_count, v[0] + 1, v[1] + 1, v[2] + 1});
    }
    mesh.positions.resize(static_cast<std::size_t>(vertex_count));
    return mesh;
}

bool neighbors_share_edges(const Patchwork& patchwork, const Surface& surface) {
    std::size_t side_count = 0;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int g : patchwork.cells[f].neighbor) {
            side_count += g >= 0;
        }
    }
    const auto refers = [&](int face, const int(&ends)[2], int other) {
        const Cell& cell = patchwork.cells[face];
        for (int c = 0; c < 3; ++c) {
            const int a = cell.vertex[c];
            const int b = cell.vertex[next_corner(c)];
            if (cell.neighbor[c] == other &&
                ((a == ends[0] && b == ends[1]) || (a == ends[1] && b == ends[0]))) {
                return true;
            }
        }
        return false;
    };
    const std::vector<Surface::SharedEdge>& edges = surface.shared_edges();
    return side_count == 2 * edges.size() &&
        std::all_of(edges.begin(), edges.end(), [&](const Surface::SharedEdge& edge) {
               return refers(edge.faces[0], edge.vertices, edge.faces[1]) &&
                   refers(edge.faces[1], edge.vertices, edge.faces[0]);
           });
}

bool loads_add_up(const Patchwork& patchwork, int total_weight) {
    std::vector<int> loads(patchwork.load.size(), 0);
    for (const Cell& cell : patchwork.cells) {
        if (cell.weight < 1) {
            return false;
        }
        loads[cell.label] += cell.weight;
    }
    return loads == patchwork.load &&
        std::accumulate(loads.begin(), loads.end(), 0) == total_weight;
}

const char*
find_fault(const Patchwork& patchwork, const Surface& surface, int total_weight, bool sound) {
    if (!surface.is_clean() || surface.component_sizes().size() != 1) {
        return "a level is one surface";
    }
    if (!neighbors_share_edges(patchwork, surface)) {
        return "neighbours on a level share an edge";
    }
    if (!loads_add_up(patchwork, total_weight)) {
        return "weights on a level add up";
    }
    if (sound && !surface.recount(labels_of(patchwork), patchwork.submesh_count()).is_whole()) {
        return "sub-meshes stay sound on finer levels";
    }
    return nullptr;
}

/// The finest level has the neighbours of the mesh: names faces by labels.
bool is_the_mesh(const PreparedMesh& prepared,
                 const Component& component,
                 const Multilevel& levels,
                 Patchwork patchwork) {
    std::vector<int> faces(static_cast<std::size_t>(component.face_count()));
    std::iota(faces.begin(), faces.end(), 0);
    patchwork.load.resize(faces.size());
    levels.set_labels(patchwork, faces);
    if (patchwork.face_count() != component.face_count() || levels.labels(patchwork) != faces) {
        return false;
    }
    for (const Cell& cell : patchwork.cells) {
        std::array<int, 3> expected =
            prepared.dual_graph().neighbors[component.mesh_face(cell.label)];
        std::array<int, 3> found;
        std::transform(cell.neighbor, cell.neighbor + 3, found.begin(), [&](int g) {
            return g < 0 ? g : component.mesh_face(patchwork.cells[g].label);
        });
        std::sort(expected.begin(), expected.end());
        std::sort(found.begin(), found.end());
        if (found != expected) {
            return false;
        }
    }
    return true;
}

/// Labels by bisection, or drawn at random from some of them.
void label(Patchwork& patchwork, Random& random) {
    const auto face_count = static_cast<std::uint32_t>(patchwork.face_count());
    const std::uint32_t submesh_count =
        std::min(face_count, 1 + random.below(random.below(4) == 0 ? face_count : 12));
    const std::uint32_t used = 1 + random.below(submesh_count);
    patchwork.load.assign(submesh_count, 0);
    if (random.below(2) == 0) {
        bisect(patchwork, static_cast<int>(submesh_count), random.next(), 1);
        return;
    }
    for (Cell& cell : patchwork.cells) {
        cell.label = static_cast<int>(random.below(used));
    }
}

} // namespace

const char* find_bad_level(PreparedMesh& prepared, int seed, int thread_count) {
    Random random(static_cast<std::uint64_t>(seed), 3);
    for (Component& component : prepared.components()) {
        const Multilevel& levels = component.multilevel(thread_count, {});
        Patchwork patchwork = levels.coarsen(static_cast<int>(random.below(300)), 1);
        label(patchwork, random);
        const bool sound = repair(patchwork) == 0;
        const std::vector<int> loads = patchwork.load;
        for (;;) {
            const TriangleMesh mesh = mesh_of(patchwork);
            const char* fault = find_fault(patchwork, Surface(mesh), levels.total_weight(), sound);
            if (fault || patchwork.load != loads) {
                return fault ? fault : "loads stay the same on finer levels";
            }
            if (patchwork.face_count() >= component.face_count()) {
                break;
            }
            levels.uncoarsen(patchwork, 2 * patchwork.face_count());
        }
        if (!is_the_mesh(prepared, component, levels, patchwork)) {
            return "the finest level is the mesh";
        }
    }
    return nullptr;
}

} // namespace spheroseg::fuzz
