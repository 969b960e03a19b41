// SPDX-License-Identifier: GPL-3.0-or-later
#include "patchwork.h"

#include "threads.h"

#include <numeric>

namespace spheroseg {

bool may_join(const Patchwork& patchwork, int face, int to) {
    int edges = 0;
    int corner = 0;
    for (int c = 0; c < 3; ++c) {
        if (patchwork.label_across(patchwork.cells[face], c) == to) {
            ++edges;
            corner = c;
        }
    }
    return edges >= 2 || (edges == 1 && no_label_around(patchwork, face, kPrevious[corner], to));
}

bool describe_single(const Patchwork& patchwork, int face, int corner, Move& move) {
    const Cell& cell = patchwork.cells[face];
    const int from = patchwork.label(face);
    const int to = patchwork.label_across(cell, corner);
    if (to < 0 || to == from) {
        return false;
    }
    const int other[2] = {patchwork.label_across(cell, kNext[corner]),
                          patchwork.label_across(cell, kPrevious[corner])};
    const int from_edges = (other[0] == from) + (other[1] == from);
    const int to_edges = 1 + (other[0] == to) + (other[1] == to);
    if (from_edges == 0) {
        return false;
    }
    move.faces[0] = face;
    move.face_count = 1;
    move.from = from;
    move.to = to;
    move.boundary_change = from_edges - to_edges;
    move.weight = cell.weight;
    return true;
}

bool single_is_allowed(const Patchwork& patchwork, int face, int corner, const Move& move) {
    // from_edges - to_edges: (1, 2) always keeps both; (2, 1) needs the opposite vertex inside
    // `from`, which then has no face of `to`; (1, 1) only needs no face of `to` there.
    if (move.boundary_change < 0) {
        return true;
    }
    const int opposite = kPrevious[corner];
    return move.boundary_change == 0 ? no_label_around(patchwork, face, opposite, move.to)
                                     : all_label_around(patchwork, face, opposite, move.from);
}

bool describe_fan(const Patchwork& patchwork, int face, int corner, bool forward, Fan& fan) {
    const int label = patchwork.label(face);
    Move& move = fan.move;
    move.from = label;
    move.to = patchwork.label_across(patchwork.cells[face], corner);
    if (move.to < 0 || move.to == label) {
        return false;
    }
    move.face_count = 0;
    move.weight = 0;
    int change = -1;
    Step step =
        forward ? Step{face, kNext[corner], kNext[corner]} : Step{face, corner, kPrevious[corner]};
    for (;;) {
        if (move.face_count == Move::kMaxFaces) {
            return false;
        }
        const Cell& cell = patchwork.cells[step.face];
        fan.steps[move.face_count] = step;
        move.faces[move.face_count++] = step.face;
        move.weight += cell.weight;
        const int outside = patchwork.label_across(cell, kNext[step.at]);
        change += (outside == label) - (outside == move.to);
        const int next = cell.neighbor[step.exit];
        const int next_label = next < 0 ? -2 : patchwork.label(next);
        if (next_label != label) {
            change -= next_label == move.to;
            break;
        }
        step = step_to(patchwork, step, next);
    }
    move.boundary_change = change;
    return true;
}

bool fan_is_allowed(const Patchwork& patchwork, const Fan& fan) {
    const Move& move = fan.move;
    // What is left of `from` must touch the fan in one run of edges, whose inner vertices lie
    // inside `from`; `to` may touch a vertex of the ring only next to the fan. Where `to` touches
    // the fan in two runs it closes to a ring.
    int runs = 0;
    bool previous_from = false;
    bool previous_to = true;
    int to_runs = 1;
    for (int i = 0; i < move.face_count; ++i) {
        const Step& step = fan.steps[i];
        const int outside = patchwork.label_across(patchwork.cells[step.face], kNext[step.at]);
        const bool touches_from = outside == move.from;
        const bool touches_to = outside == move.to;
        if (touches_from && !previous_from && ++runs > 1) {
            return false;
        }
        if (touches_from && previous_from &&
            !all_label_around(patchwork, step.face, step.from(), move.from)) {
            return false;
        }
        if (!touches_to && !previous_to && !(touches_from && previous_from) &&
            !no_label_around(patchwork, step.face, step.from(), move.to)) {
            return false;
        }
        to_runs += touches_to && !previous_to;
        previous_from = touches_from;
        previous_to = touches_to;
    }
    const Step& last = fan.steps[move.face_count - 1];
    const bool ends_at_to =
        patchwork.label_across(patchwork.cells[last.face], last.exit) == move.to;
    if (!previous_to && !ends_at_to && !no_label_around(patchwork, last.face, last.to(), move.to)) {
        return false;
    }
    // All around the centre of the fan, the last run goes over into the first one.
    to_runs -= ends_at_to && previous_to;
    return runs == 1 && (to_runs == 1 || patchwork.may_close_rings);
}

void apply(Patchwork& patchwork, const Move& move) {
    for (int i = 0; i < move.face_count; ++i) {
        patchwork.set_label(move.faces[i], move.to);
    }
    patchwork.load[move.from] -= move.weight;
    patchwork.load[move.to] += move.weight;
}

double mean_load(const Patchwork& patchwork) {
    const double total = std::accumulate(patchwork.load.begin(), patchwork.load.end(), 0.0);
    return total / patchwork.submesh_count();
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
    const int threads = resolve_thread_count(thread_count);
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
