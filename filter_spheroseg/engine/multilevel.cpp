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
    for (int step = 0; step < step_count; ++step) {
        const int* star = hierarchy.star_faces.data() + hierarchy.star_begin[step];
        const int degree = hierarchy.star_begin[step + 1] - hierarchy.star_begin[step];
        const int cell = base_count + 2 * (step_count - 1 - step);
        cell_of_face_[star[0]] = cell;
        cell_of_face_[star[degree - 1]] = cell + 1;
        weight_[star[1]] += weight_[star[0]];
        weight_[star[degree - 2]] += weight_[star[degree - 1]];
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
    const auto base_count = static_cast<int>(base_.cells.size());
    int step = hierarchy_->step_count() - (patchwork.face_count() - base_count) / 2;
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
    const int begin = hierarchy_->star_begin[step];
    const int degree = hierarchy_->star_begin[step + 1] - begin;
    const int* star = hierarchy_->star_faces.data() + begin;
    const int* ring = hierarchy_->ring_vertices.data() + begin;
    const int vertex = hierarchy_->vertex[step];
    const int target = ring[0];

    const int first = patchwork.face_count();
    const int last = first + 1;
    const int next_to_first = cell_of_face_[star[1]];
    const int next_to_last = cell_of_face_[star[degree - 2]];
    std::vector<Cell>& cells = patchwork.cells;
    // The outer neighbours of the two new faces.
    const int corner_first = corner_of(cells[next_to_first], target);
    const int corner_last = kPrevious[corner_of(cells[next_to_last], target)];
    const int outer_first = cells[next_to_first].neighbor[corner_first];
    const int outer_last = cells[next_to_last].neighbor[corner_last];

    Cell new_first = {{vertex, target, ring[1]},
                      {last, outer_first, next_to_first},
                      cells[next_to_first].label,
                      weight_[star[0]]};
    Cell new_last = {{vertex, ring[degree - 1], target},
                     {next_to_last, outer_last, first},
                     cells[next_to_last].label,
                     weight_[star[degree - 1]]};
    cells[next_to_first].neighbor[corner_first] = first;
    cells[next_to_last].neighbor[corner_last] = last;
    cells[next_to_first].weight -= new_first.weight;
    cells[next_to_last].weight -= new_last.weight;
    // In the outer faces the shared edges run the other way: from ring[1], and from the target.
    if (outer_first >= 0) {
        cells[outer_first].neighbor[corner_of(cells[outer_first], ring[1])] = first;
    }
    if (outer_last >= 0) {
        cells[outer_last].neighbor[corner_of(cells[outer_last], target)] = last;
    }
    for (int i = 1; i < degree - 1; ++i) {
        Cell& cell = cells[cell_of_face_[star[i]]];
        cell.vertex[corner_of(cell, target)] = vertex;
    }
    cells.push_back(new_first);
    cells.push_back(new_last);
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
