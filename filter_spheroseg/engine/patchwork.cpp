// SPDX-License-Identifier: GPL-3.0-or-later
#include "patchwork.h"

#include "threads.h"

#include <algorithm>
#include <numeric>

namespace spheroseg {

void Patchwork::tell_neighbors(int thread_count) {
    const int threads = threads_for(thread_count, face_count(), kFacesPerThread);
    for_each_share(face_count(), threads, [this](int begin, int end) {
        for (int f = begin; f < end; ++f) {
            for (int c = 0; c < 3; ++c) {
                const int other = neighbor(f, c);
                cells[f].across[c] = other < 0 ? kOpenBorder : cells[other].label;
            }
        }
    });
}

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

bool list_corners(const Patchwork& patchwork, int face, int corner, std::vector<Corner>& corners) {
    corners.assign(1, {face, corner});
    const auto follow = [&](int exit) {
        Step step{face, corner, exit};
        while (patchwork.neighbor(step.face, step.exit) >= 0) {
            step = patchwork.step_from(step);
            if (step.face == face) {
                return true;
            }
            corners.push_back({step.face, step.at});
        }
        return false;
    };
    if (follow(corner)) {
        return true;
    }
    std::reverse(corners.begin(), corners.end());
    return follow(previous_corner(corner));
}

void sum_loads(Patchwork& patchwork) {
    std::fill(patchwork.load.begin(), patchwork.load.end(), 0);
    for (const Cell& cell : patchwork.cells) {
        if (cell.label >= 0) {
            patchwork.load[cell.label] += cell.weight;
        }
    }
}

namespace {

double total_load(const Patchwork& patchwork) {
    return std::accumulate(patchwork.load.begin(), patchwork.load.end(), 0.0);
}

} // namespace

double mean_cell_count(const Patchwork& patchwork) {
    return static_cast<double>(patchwork.face_count()) / patchwork.submesh_count();
}

double mean_load(const Patchwork& patchwork) {
    return total_load(patchwork) / patchwork.submesh_count();
}

double mean_face_weight(const Patchwork& patchwork) {
    return total_load(patchwork) / patchwork.face_count();
}

EvenLoads even_loads(const Patchwork& patchwork) {
    const int floor = patchwork.face_count() / patchwork.submesh_count();
    return {floor, floor + (patchwork.face_count() % patchwork.submesh_count() != 0)};
}

std::vector<std::array<int, 3>> neighbor_table(const Patchwork& patchwork, int thread_count) {
    const int face_count = patchwork.face_count();
    std::vector<std::array<int, 3>> table(face_count);
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
    for_each_share(face_count, threads, [&](int begin, int end) {
        for (int f = begin; f < end; ++f) {
            for (int c = 0; c < 3; ++c) {
                const int neighbor = patchwork.neighbor(f, c);
                table[f][c] = neighbor < 0 ? f : neighbor;
            }
        }
    });
    return table;
}

FacesByLabel sort_by_label(const Patchwork& patchwork, const std::vector<int>& faces) {
    FacesByLabel sorted;
    sorted.begin.assign(patchwork.submesh_count() + 1, 0);
    const auto count = static_cast<int>(faces.size());
    for (int i = 0; i < count; ++i) {
        fetch_ahead(patchwork, faces, i);
        ++sorted.begin[patchwork.label(faces[i]) + 1];
    }
    std::partial_sum(sorted.begin.begin(), sorted.begin.end(), sorted.begin.begin());
    std::vector<int> next = sorted.begin;
    sorted.faces.resize(faces.size());
    for (int i = 0; i < count; ++i) {
        fetch_ahead(patchwork, faces, i);
        sorted.faces[next[patchwork.label(faces[i])]++] = faces[i];
    }
    return sorted;
}

FacesByLabel sort_by_label(const Patchwork& patchwork) {
    std::vector<int> faces(patchwork.face_count());
    std::iota(faces.begin(), faces.end(), 0);
    return sort_by_label(patchwork, faces);
}

std::vector<int> cell_labels(const Patchwork& patchwork) {
    std::vector<int> labels(patchwork.cells.size());
    for (std::size_t f = 0; f < labels.size(); ++f) {
        labels[f] = patchwork.cells[f].label;
    }
    return labels;
}

} // namespace spheroseg
