// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_levels.h"

#include "../engine/level_mesh.h"
#include "bisection.h"
#include "component.h"
#include "random.h"
#include "recount.h"
#include "repair.h"

#include <algorithm>
#include <numeric>

namespace spheroseg::fuzz {

namespace {

bool neighbors_share_edges(const Patchwork& patchwork,
                           const TriangleMesh& mesh,
                           const Surface& surface) {
    std::size_t side_count = 0;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int g : patchwork.neighbors(f)) {
            side_count += g >= 0;
        }
    }
    const auto refers = [&](int face, const int(&ends)[2], int other) {
        for (int c = 0; c < 3; ++c) {
            const int a = mesh.faces[face][c];
            const int b = mesh.faces[face][next_corner(c)];
            if (patchwork.neighbor(face, c) == other &&
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

const char* find_fault(const Patchwork& patchwork, int total_weight, bool sound) {
    const TriangleMesh mesh = test::mesh_of(patchwork);
    const Surface surface(mesh);
    if (!surface.is_clean() || surface.component_sizes().size() != 1) {
        return "a level is one surface";
    }
    if (!neighbors_share_edges(patchwork, mesh, surface)) {
        return "neighbours on a level share an edge";
    }
    if (!loads_add_up(patchwork, total_weight)) {
        return "weights on a level add up";
    }
    if (sound && !surface.recount(cell_labels(patchwork), patchwork.submesh_count()).is_whole()) {
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
    for (int f = 0; f < patchwork.face_count(); ++f) {
        std::array<int, 3> expected =
            prepared.dual_graph().neighbors[component.mesh_face(patchwork.label(f))];
        std::array<int, 3> found = patchwork.neighbors(f);
        std::transform(found.begin(), found.end(), found.begin(), [&](int g) {
            return g < 0 ? g : component.mesh_face(patchwork.label(g));
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
    for (int f = 0; f < patchwork.face_count(); ++f) {
        patchwork.set_label(f, static_cast<int>(random.below(used)));
    }
}

} // namespace

const char* find_bad_level(PreparedMesh& prepared, int seed, int thread_count) {
    Random random(static_cast<std::uint64_t>(seed), 3);
    for (Component& component : prepared.components()) {
        const Multilevel& levels = component.multilevel(thread_count, {});
        Patchwork patchwork = levels.coarsen(static_cast<int>(random.below(300)), 1);
        label(patchwork, random);
        bool sound = repair(patchwork) == 0;
        std::vector<int> loads = patchwork.load;
        for (;;) {
            const char* fault = find_fault(patchwork, levels.total_weight(), sound);
            if (fault || patchwork.load != loads) {
                return fault ? fault : "loads stay the same on finer levels";
            }
            if (patchwork.face_count() >= component.face_count()) {
                break;
            }
            if (levels.uncoarsen(patchwork, thread_count)) {
                sound = repair_unsound(patchwork) == 0;
                loads = patchwork.load;
            }
        }
        if (!is_the_mesh(prepared, component, levels, patchwork)) {
            return "the finest level is the mesh";
        }
    }
    return nullptr;
}

} // namespace spheroseg::fuzz
