// SPDX-License-Identifier: GPL-3.0-or-later
#include "pass_graph.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// Sub-meshes that a search visits in the time that one face takes.
constexpr std::int64_t kLabelsPerFace = 4;

} // namespace

const std::vector<PassGraph::Arc>& PassGraph::arcs(int label, bool outward) {
    if (!still_hold(label, outward)) {
        find_ways(label, outward);
    }
    return ways_[outward][label].arcs;
}

/// Is what is known of a sub-mesh still so? Where only sub-meshes beside it have changed, mostly
/// the faces can pass that could before. Their labels are as they were (see `pass`).
bool PassGraph::still_hold(int label, bool outward) {
    Ways& ways = ways_[outward][label];
    const auto changed = [&](int l) { return submeshes_[l].changed_at > ways.known_at; };
    Move move;
    const auto still_holds = [&](const Arc& arc) {
        return !changed(arc.label) ||
            (arc.side.face >= 0 && is_allowed_pass(patchwork_, arc.side, move));
    };
    if (changed(label) || !std::all_of(ways.arcs.begin(), ways.arcs.end(), still_holds)) {
        return false;
    }
    ways.known_at = clock_;
    return true;
}

void PassGraph::find_ways(int label, bool outward) {
    work_ += 1 + boundaries_.listed_count(label);
    Ways& ways = ways_[outward][label];
    ways.known_at = clock_;
    ways.arcs.clear();
    boundaries_.for_each_side(label, [&](int face, int c, int across) {
        int& at = arc_of_[across];
        if (at < 0) {
            at = static_cast<int>(ways.arcs.size());
            ways.arcs.push_back({across, {-1, -1}});
        }
        const SubmeshSide side = passing_side(patchwork_, face, c, outward);
        Move move;
        if (ways.arcs[at].side.face < 0 && is_allowed_pass(patchwork_, side, move)) {
            ways.arcs[at].side = side;
        }
    });
    for (const Arc& arc : ways.arcs) {
        arc_of_[arc.label] = -1;
    }
}

void PassGraph::pass(const Move& move) {
    boundaries_.commit(move);
    submeshes_[move.from].changed_at = submeshes_[move.to].changed_at = ++clock_;
    // Sides of these have another label beyond them now.
    for (int c = 0; c < 3; ++c) {
        const int across = patchwork_.label_across(move.faces[0], c);
        if (across >= 0) {
            ways_[0][across].known_at = ways_[1][across].known_at = -1;
        }
    }
}

/// Leaves no marks of the search.
void PassGraph::trace_path(int end, bool outward) {
    work_ += static_cast<std::int64_t>(queue_.size()) / kLabelsPerFace;
    path_.clear();
    for (int l = end; l >= 0; l = submeshes_[l].parent == l ? -1 : submeshes_[l].parent) {
        path_.push_back(l);
    }
    if (outward) {
        std::reverse(path_.begin(), path_.end());
    }
    for (int l : queue_) {
        submeshes_[l].parent = -1;
    }
}

} // namespace spheroseg
