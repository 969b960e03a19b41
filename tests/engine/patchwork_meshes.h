// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"
#include "bisection.h"
#include "component.h"
#include "level_mesh.h"
#include "measures.h"
#include "multilevel.h"
#include "repair.h"
#include "submesh_boundaries.h"

#include "test_meshes.h"

#include <algorithm>

namespace spheroseg::test {

/// A mesh with its dual graph, hierarchy and levels.
struct Levels {
    explicit Levels(TriangleMesh from)
        : mesh(std::move(from)), graph(build_dual_graph(mesh)),
          hierarchy(build_hierarchy(mesh, graph, 1)), multilevel(hierarchy, mesh.face_count()) {}

    TriangleMesh mesh;
    DualGraph graph;
    CollapseHierarchy hierarchy;
    Multilevel multilevel;
};

/// What hangs together of a mesh after a share of its faces was taken out at random; the largest
/// part of it. Keeps the positions of all vertices.
inline TriangleMesh sieve(const TriangleMesh& from, double share, std::uint64_t seed) {
    TriangleMesh mesh{from.positions, {}};
    Random random(seed);
    for (const Triangle& t : from.faces) {
        if (random.uniform() >= share) {
            mesh.faces.push_back(t);
        }
    }
    std::vector<int> largest;
    for (const std::vector<int>& faces : faces_of_components(build_dual_graph(mesh, 1))) {
        largest = faces.size() > largest.size() ? faces : largest;
    }
    TriangleMesh result{from.positions, {}};
    for (int f : largest) {
        result.faces.push_back(mesh.faces[f]);
    }
    return result;
}

/// The finest level parted by bisection: sound, with loads that may be far from even.
inline Patchwork rough_patchwork(const Levels& levels, int submesh_count, std::uint64_t seed) {
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), submesh_count);
    bisect(patchwork, submesh_count, seed, 1);
    repair(patchwork);
    return patchwork;
}

/// The finest level parted into disks by bisection, then ragged by random moves that are allowed.
inline Patchwork ragged_patchwork(const Levels& levels, int submesh_count, std::uint64_t seed) {
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), submesh_count);
    bisect(patchwork, submesh_count, seed, 1);
    patchwork.may_close_rings = false;
    repair(patchwork);
    patchwork.may_close_rings = true;
    Random random(seed);
    for (int i = 0; i < 20 * patchwork.face_count(); ++i) {
        const auto face = static_cast<int>(random.below(patchwork.face_count()));
        const auto corner = static_cast<int>(random.below(3));
        Move move;
        if (is_allowed_pass(patchwork, {face, corner}, move)) {
            apply(patchwork, move);
        }
    }
    return patchwork;
}

/// A short annealing, of eight phases.
inline AnnealSchedule schedule_of(double proposals, int thread_count) {
    AnnealSchedule schedule;
    schedule.proposals_per_face = proposals;
    schedule.phase_count = 8;
    schedule.thread_count = thread_count;
    schedule.seed = 5;
    return schedule;
}

inline Measures measures_of(const Levels& levels, const Patchwork& patchwork) {
    return measure(levels.mesh,
                   levels.graph,
                   levels.multilevel.labels(patchwork),
                   patchwork.submesh_count(),
                   1);
}

/// Every sub-mesh has a face, is connected and has no bowtie; it need not be balanced.
inline bool is_sound(const Measures& measures) {
    return measures.min_submesh_triangles >= 1 && measures.disconnected_submesh_count == 0 &&
        measures.bowtie_count == 0;
}

/// Whether sound parts of `least` to `most` faces exist: all labellings are tried.
inline bool
cut_exists(const Levels& levels, int k, int least, int most, std::vector<int>& labels, int face) {
    if (face == levels.mesh.face_count()) {
        const Measures measures = measure(levels.mesh, levels.graph, labels, k, 1);
        return is_sound(measures) && measures.min_submesh_triangles >= least &&
            measures.max_submesh_triangles <= most;
    }
    int used = 0;
    for (int f = 0; f < face; ++f) {
        used = std::max(used, labels[f] + 1);
    }
    for (int l = 0; l < std::min(used + 1, k); ++l) {
        labels[face] = l;
        if (cut_exists(levels, k, least, most, labels, face + 1)) {
            return true;
        }
    }
    return false;
}

/// The mesh that a patchwork is, and its labels measured.
inline Measures measures_of_level(const Patchwork& patchwork) {
    const TriangleMesh mesh = mesh_of(patchwork);
    return measure(
        mesh, build_dual_graph(mesh), cell_labels(patchwork), patchwork.submesh_count(), 1);
}

} // namespace spheroseg::test
