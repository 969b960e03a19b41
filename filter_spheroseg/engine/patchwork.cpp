// SPDX-License-Identifier: GPL-3.0-or-later
#include "patchwork.h"

#include "threads.h"

#include <numeric>

namespace spheroseg {

template bool no_label_around(const Patchwork&, int, int, int);
template bool all_label_around(const Patchwork&, int, int, int);
template bool describe_single(const Patchwork&, int, int, Move&);
template bool single_is_allowed(const Patchwork&, int, int, const Move&);
template bool describe_fan(const Patchwork&, int, int, bool, Fan&);
template bool fan_is_allowed(const Patchwork&, const Fan&);

bool may_join(const Patchwork& patchwork, int face, int to) {
    int edges = 0;
    int corner = 0;
    for (int c = 0; c < 3; ++c) {
        if (patchwork.label_across(face, c) == to) {
            ++edges;
            corner = c;
        }
    }
    return edges >= 2 ||
        (edges == 1 && no_label_around(patchwork, face, previous_corner(corner), to));
}

void apply(Patchwork& patchwork, const Move& move) {
    for (int i = 0; i < move.face_count; ++i) {
        patchwork.set_label(move.faces[i], move.to);
    }
    patchwork.load[move.from] -= move.weight;
    patchwork.load[move.to] += move.weight;
}

namespace {

double total_load(const Patchwork& patchwork) {
    return std::accumulate(patchwork.load.begin(), patchwork.load.end(), 0.0);
}

} // namespace

double mean_load(const Patchwork& patchwork) {
    return total_load(patchwork) / patchwork.submesh_count();
}

double mean_face_weight(const Patchwork& patchwork) {
    return total_load(patchwork) / patchwork.face_count();
}

std::vector<int> labels_of(const Patchwork& patchwork) {
    std::vector<int> labels(patchwork.cells.size());
    for (std::size_t f = 0; f < labels.size(); ++f) {
        labels[f] = patchwork.cells[f].label;
    }
    return labels;
}

SortedPatchwork sort_by_label(const Patchwork& patchwork, int thread_count) {
    const int face_count = patchwork.face_count();
    std::vector<int> begin(patchwork.submesh_count() + 1, 0);
    for (const Cell& cell : patchwork.cells) {
        ++begin[cell.label + 1];
    }
    for (std::size_t l = 1; l < begin.size(); ++l) {
        begin[l] += begin[l - 1];
    }
    SortedPatchwork sorted;
    sorted.order.resize(face_count);
    std::vector<int> place(face_count);
    for (int f = 0; f < face_count; ++f) {
        place[f] = begin[patchwork.cells[f].label]++;
        sorted.order[place[f]] = f;
    }
    sorted.patchwork.load = patchwork.load;
    sorted.patchwork.may_close_rings = patchwork.may_close_rings;
    sorted.patchwork.cells.resize(face_count);
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int i = 0; i < face_count; ++i) {
        Cell cell = patchwork.cells[sorted.order[i]];
        for (int& neighbor : cell.neighbor) {
            neighbor = neighbor < 0 ? neighbor : place[neighbor];
        }
        sorted.patchwork.cells[i] = cell;
    }
    return sorted;
}

void take_labels(Patchwork& patchwork, const SortedPatchwork& sorted) {
    patchwork.load = sorted.patchwork.load;
    for (std::size_t i = 0; i < sorted.order.size(); ++i) {
        patchwork.cells[sorted.order[i]].label = sorted.patchwork.cells[i].label;
    }
}

} // namespace spheroseg
