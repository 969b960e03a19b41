// SPDX-License-Identifier: GPL-3.0-or-later
#include "patchwork.h"

#include "threads.h"

#include <algorithm>
#include <cmath>
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
    if (hubs) {
        count_at_hubs();
    }
}

void Patchwork::pass_at_hubs(int face, int new_label) {
    const int old_label = label(face);
    for (int c = 0; c < 3; ++c) {
        const int hub = hubs->at[face][c];
        if (hub == Hubs::kNone) {
            continue;
        }
        // A side between two faces of a label is no end, and becomes one when one of them leaves.
        HubShare left{hub, -1, 0};
        HubShare joined{hub, 1, 0};
        for (int side : {c, previous_corner(c)}) {
            left.ends += label_across(face, side) == old_label ? 1 : -1;
            joined.ends += label_across(face, side) == new_label ? -1 : 1;
        }
        hub_shares.add(old_label, left);
        hub_shares.add(new_label, joined);
    }
}

void Patchwork::count_at_hubs() {
    hub_shares.begin(submesh_count());
    for (int f = 0; f < face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (const int hub = hubs->at[f][c]; hub != Hubs::kNone) {
                hub_shares.add(label(f), {hub, 1, fan_ends(*this, f, c)});
            }
        }
    }
}

bool no_label_around_hub(const Patchwork& patchwork, int face, int corner, int label) {
    const int own = patchwork.label(face) == label;
    return share_at(patchwork, face, corner, label).faces == own;
}

bool all_label_around_hub(const Patchwork& patchwork, int face, int corner, int label) {
    const Hubs::Hub& hub = patchwork.hubs->hubs[patchwork.hubs->at[face][corner]];
    const int others = hub.face_count - (patchwork.label(face) != label);
    return hub.is_closed && share_at(patchwork, face, corner, label).faces == others;
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

double excess_share(const Patchwork& patchwork) {
    const double ceiling = std::ceil(mean_load(patchwork));
    double excess = 0.0;
    for (int load : patchwork.load) {
        excess += std::max(0.0, load - ceiling);
    }
    return excess / total_load(patchwork);
}

LoadRange even_loads(const Patchwork& patchwork) {
    const int floor = patchwork.face_count() / patchwork.submesh_count();
    return {floor, floor + (patchwork.face_count() % patchwork.submesh_count() != 0)};
}

std::int64_t misplaced(const Patchwork& patchwork) {
    const LoadRange even = even_loads(patchwork);
    std::int64_t sum = 0;
    for (int load : patchwork.load) {
        sum += even.deviation(load);
    }
    return sum;
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
