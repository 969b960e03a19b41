// SPDX-License-Identifier: GPL-3.0-or-later
#include "multilevel.h"

#include "threads.h"

#include <algorithm>

namespace spheroseg {

Multilevel::Multilevel(const CollapseHierarchy& hierarchy, int face_count, int thread_count)
    : levels_(
          std::make_shared<const MeshLevels>(build_levels(hierarchy, face_count, thread_count))) {}

Multilevel::Multilevel(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count)
    : levels_(
          std::make_shared<const MeshLevels>(build_finest_level(mesh, dual_graph, thread_count))) {}

Multilevel Multilevel::with_weights(const std::vector<int>& weights) const {
    Multilevel weighted = *this;
    weighted.weight_before_.assign(1, 0);
    for (int f : levels_->face_at) {
        weighted.weight_before_.push_back(weighted.weight_before_.back() + weights[f]);
    }
    return weighted;
}

/// The number of cells tells the level: two that have as many are linked alike, because collapses
/// that take no face of the mesh away, in the middle of caps, change no link between others.
const Level& Multilevel::level_of(const Patchwork& patchwork) const {
    return *std::find_if(levels_->levels.begin(), levels_->levels.end(), [&](const Level& level) {
        return level.cell_count() == patchwork.face_count();
    });
}

const Level& Multilevel::level_with(int min_face_count) const {
    const Level* level = &levels_->levels.front();
    for (const Level& coarser : levels_->levels) {
        level = coarser.cell_count() >= min_face_count ? &coarser : level;
    }
    return *level;
}

int Multilevel::quartered_cell_count(int min_face_count) const {
    int count = face_count();
    for (int l = 1; l <= levels_->quartered_count; ++l) {
        const int coarser = levels_->levels[l].cell_count();
        count = coarser >= min_face_count ? coarser : count;
    }
    return count;
}

Patchwork Multilevel::coarsen(int min_face_count, int submesh_count, int thread_count) const {
    const Level& level = level_with(min_face_count);
    Patchwork patchwork;
    patchwork.cells.resize(level.cell_count());
    patchwork.hubs = level.hubs;
    patchwork.load.assign(submesh_count, 0);
    patchwork.load[0] = total_weight();
    const int threads = threads_for(thread_count, level.cell_count(), kFacesPerThread);
    for_each_share(level.cell_count(), threads, [&](int begin, int end) {
        fill(patchwork, level, begin, end, 0);
    });
    patchwork.tell_neighbors(thread_count);
    return patchwork;
}

/// Sets the cells [first, end) of a level but for what their neighbours are.
void Multilevel::fill(
    Patchwork& patchwork, const Level& level, int first, int end, int label) const {
    for (int i = first; i < end; ++i) {
        Cell& cell = patchwork.cells[i];
        std::copy(level.sides[i].begin(), level.sides[i].end(), cell.side);
        patchwork.set_own_label(i, label);
        cell.weight = weight_before(level.begin_of(i + 1)) - weight_before(level.begin_of(i));
    }
}

bool Multilevel::uncoarsen(Patchwork& patchwork, int thread_count) const {
    const Level& level = level_of(patchwork);
    if (&level == &levels_->levels.front()) {
        return false;
    }
    const Level& finer = *(&level - 1);
    const std::vector<int> labels = cell_labels(patchwork);
    std::vector<Cell>().swap(patchwork.cells); // gives the memory back before it takes more
    patchwork.cells.resize(finer.cell_count());
    patchwork.hubs = finer.hubs;
    const int threads = threads_for(thread_count, finer.cell_count(), kFacesPerThread);
    for_each_share(level.cell_count(), threads, [&](int begin, int end) {
        int cell = finer.first_cell_from(level.begin[begin]);
        for (int i = begin; i < end; ++i) {
            const int first = cell;
            while (finer.begin_of(cell) < level.begin[i + 1]) {
                ++cell;
            }
            fill(patchwork, finer, first, cell, labels[i]);
        }
    });
    patchwork.tell_neighbors(thread_count);
    return level.closes_holes;
}

std::vector<int> Multilevel::labels(const Patchwork& patchwork) const {
    std::vector<int> labels(levels_->face_at.size());
    for (std::size_t i = 0; i < labels.size(); ++i) {
        labels[levels_->face_at[i]] = patchwork.cells[i].label;
    }
    return labels;
}

void Multilevel::set_labels(Patchwork& patchwork, const std::vector<int>& labels) const {
    std::fill(patchwork.load.begin(), patchwork.load.end(), 0);
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const int label = labels[levels_->face_at[i]];
        patchwork.set_own_label(static_cast<int>(i), label);
        if (label >= 0) {
            patchwork.load[label] += patchwork.cells[i].weight;
        }
    }
    patchwork.tell_neighbors();
}

} // namespace spheroseg
