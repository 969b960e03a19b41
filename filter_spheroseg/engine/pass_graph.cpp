// SPDX-License-Identifier: GPL-3.0-or-later
#include "pass_graph.h"

#include <algorithm>

namespace spheroseg {

PassGraph::Arc* PassGraph::find_arc(int label, int other) {
    std::vector<Arc>& arcs = arcs_[label];
    const auto found = std::find_if(
        arcs.begin(), arcs.end(), [other](const Arc& arc) { return arc.label == other; });
    return found == arcs.end() ? nullptr : &*found;
}

void PassGraph::link(int a, int b) {
    if (!find_arc(a, b)) {
        arcs_[a].push_back({b, {-1, -1}});
        arcs_[b].push_back({a, {-1, -1}});
    }
}

/// Leaves no marks of the search.
void PassGraph::trace_path(int end, bool outward) {
    path_.clear();
    for (int l = end; l >= 0; l = parent_[l] == l ? -1 : parent_[l]) {
        path_.push_back(l);
    }
    if (outward) {
        std::reverse(path_.begin(), path_.end());
    }
    for (int l : queue_) {
        parent_[l] = -1;
    }
}

} // namespace spheroseg
