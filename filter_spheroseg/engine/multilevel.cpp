// SPDX-License-Identifier: GPL-3.0-or-later
#include "multilevel.h"

#include <algorithm>
#include <numeric>

namespace spheroseg {

namespace {

Cell cell_of(const Triangle& vertices, const std::array<int, 3>& neighbors, int weight) {
    return {{vertices[0], vertices[1], vertices[2]},
            {neighbors[0], neighbors[1], neighbors[2]},
            0,
            weight};
}

} // namespace

Multilevel::Multilevel(const CollapseHierarchy* hierarchy,
                       int face_count,
                       const std::vector<int>& weights)
    : hierarchy_(hierarchy), cell_of_face_(face_count), weight_(weights) {
    weight_.resize(face_count, 1);
    total_weight_ = std::accumulate(weight_.begin(), weight_.end(), 0);
}

Multilevel::Multilevel(const TriangleMesh& mesh,
                       const DualGraph& dual_graph,
                       const std::vector<int>& weights)
    : Multilevel(nullptr, mesh.face_count(), weights) {
    std::iota(cell_of_face_.begin(), cell_of_face_.end(), 0);
    base_.cells.reserve(cell_of_face_.size());
    for (int f = 0; f < mesh.face_count(); ++f) {
        base_.cells.push_back(cell_of(mesh.faces[f], dual_graph.neighbors[f], weight_[f]));
    }
}

Multilevel::Multilevel(const CollapseHierarchy& hierarchy,
                       int face_count,
                       const std::vector<int>& weights)
    : Multilevel(&hierarchy, face_count, weights) {
    const int step_count = hierarchy.step_count();
    const auto base_count = static_cast<int>(hierarchy.base_faces.size());
    faces_before_.resize(step_count);
    int next_cell = base_count;
    for (int step = step_count - 1; step >= 0; --step) {
        faces_before_[step] = next_cell;
        for (int f : {hierarchy.star_faces[hierarchy.star_begin[step]],
                      hierarchy.star_faces[hierarchy.star_begin[step + 1] - 1]}) {
            if (f < face_count) {
                cell_of_face_[f] = next_cell++;
            }
        }
    }
    for (int step = 0; step < step_count; ++step) {
        const int* star = hierarchy.star_faces.data() + hierarchy.star_begin[step];
        const int degree = hierarchy.star_begin[step + 1] - hierarchy.star_begin[step];
        if (star[0] < face_count) {
            weight_[star[1]] += weight_[star[0]];
        }
        if (star[degree - 1] < face_count) {
            weight_[star[degree - 2]] += weight_[star[degree - 1]];
        }
    }

    TriangleMesh base_mesh;
    int vertex_count = 0;
    for (const Triangle& triangle : hierarchy.base_triangles) {
        vertex_count =
            std::max(vertex_count, *std::max_element(triangle.begin(), triangle.end()) + 1);
    }
    base_mesh.positions.resize(vertex_count);
    base_mesh.faces = hierarchy.base_triangles;
    const DualGraph graph = build_dual_graph(base_mesh, 1);
    for (int f = 0; f < base_count; ++f) {
        cell_of_face_[hierarchy.base_faces[f]] = f;
        base_.cells.push_back(
            cell_of(base_mesh.faces[f], graph.neighbors[f], weight_[hierarchy.base_faces[f]]));
    }
}

Patchwork Multilevel::coarsen(int min_face_count, int submesh_count) const {
    Patchwork patchwork;
    patchwork.cells.reserve(cell_of_face_.size());
    patchwork.cells = base_.cells;
    patchwork.load.assign(submesh_count, 0);
    patchwork.load[0] = total_weight_;
    uncoarsen(patchwork, min_face_count);
    return patchwork;
}

void Multilevel::uncoarsen(Patchwork& patchwork, int min_face_count) const {
    if (!hierarchy_) {
        return;
    }
    // The steps that are still to be undone are those before this one.
    int step = static_cast<int>(
        std::partition_point(faces_before_.begin(),
                             faces_before_.end(),
                             [&](int faces) { return faces >= patchwork.face_count(); }) -
        faces_before_.begin());
    int round = static_cast<int>(std::upper_bound(hierarchy_->round_begin.begin(),
                                                  hierarchy_->round_begin.end(),
                                                  step - 1) -
                                 hierarchy_->round_begin.begin()) -
        1;
    for (; patchwork.face_count() < min_face_count && round >= 0; --round) {
        while (step > hierarchy_->round_begin[round]) {
            undo(patchwork, --step);
        }
    }
}

void Multilevel::undo(Patchwork& patchwork, int step) const {
    const int first = undo_side(patchwork, step, true);
    const int last = undo_side(patchwork, step, false);
    if (first >= 0 && last >= 0) {
        patchwork.cells[first].neighbor[0] = last;
        patchwork.cells[last].neighbor[2] = first;
    }
    const int vertex = hierarchy_->vertex[step];
    const int target = hierarchy_->target[step];
    for (int i = hierarchy_->star_begin[step] + 1; i + 1 < hierarchy_->star_begin[step + 1]; ++i) {
        if (hierarchy_->star_faces[i] < face_count()) {
            Cell& cell = patchwork.cells[cell_of_face_[hierarchy_->star_faces[i]]];
            cell.vertex[corner_of(cell, target)] = vertex;
        }
    }
}

/// Brings the first or the last face of a star back, between the one that took its place and what
/// lies beyond, but not yet beside the other one; returns its cell, or -1 if it belongs to a cap.
int Multilevel::undo_side(Patchwork& patchwork, int step, bool first) const {
    const int begin = hierarchy_->star_begin[step];
    const int end = hierarchy_->star_begin[step + 1];
    const int face = hierarchy_->star_faces[first ? begin : end - 1];
    if (face >= face_count()) {
        return -1;
    }
    const int vertex = hierarchy_->vertex[step];
    const int target = hierarchy_->target[step];
    const int rim = hierarchy_->ring_vertices[first ? begin + 1 : end - 1];
    const int heir = cell_of_face_[hierarchy_->star_faces[first ? begin + 1 : end - 2]];
    const int added = patchwork.face_count();
    std::vector<Cell>& cells = patchwork.cells;
    const int corner = corner_of(cells[heir], target);
    int& side = cells[heir].neighbor[first ? corner : previous_corner(corner)];
    const int beyond = side;
    side = added;
    cells[heir].weight -= weight_[face];
    if (beyond >= 0) {
        // There the shared edge runs the other way: from the rim, or from the target.
        cells[beyond].neighbor[corner_of(cells[beyond], first ? rim : target)] = added;
    }
    const Cell cell = first
        ? Cell{{vertex, target, rim}, {-1, beyond, heir}, cells[heir].label, weight_[face]}
        : Cell{{vertex, rim, target}, {heir, beyond, -1}, cells[heir].label, weight_[face]};
    cells.push_back(cell);
    return added;
}

std::vector<int> Multilevel::labels(const Patchwork& patchwork) const {
    std::vector<int> labels(cell_of_face_.size());
    for (std::size_t f = 0; f < labels.size(); ++f) {
        labels[f] = patchwork.cells[cell_of_face_[f]].label;
    }
    return labels;
}

void Multilevel::set_labels(Patchwork& patchwork, const std::vector<int>& labels) const {
    std::fill(patchwork.load.begin(), patchwork.load.end(), 0);
    for (std::size_t f = 0; f < labels.size(); ++f) {
        Cell& cell = patchwork.cells[cell_of_face_[f]];
        cell.label = labels[f];
        if (cell.label >= 0) {
            patchwork.load[cell.label] += cell.weight;
        }
    }
}

} // namespace spheroseg
