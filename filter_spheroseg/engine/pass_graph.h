// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "random.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// The graph of adjacent sub-meshes, with a note for each direction between two of them in which no
/// face can pass at present (an arc that is blocked). Whether a face can pass depends on the faces
/// of the two sub-meshes only, so a note holds until one of the two changes.
class PassGraph {
public:
    explicit PassGraph(int submesh_count)
        : arcs_(submesh_count), changed_at_(submesh_count, 0), parent_(submesh_count, -1) {}

    /// Adds the arcs between two sub-meshes that share an edge. They stay when that edge is gone.
    void link(int a, int b);

    /// Faces of the two have changed: unblocks all their arcs.
    void change(int a, int b) { changed_at_[a] = changed_at_[b] = ++clock_; }

    /// Calls is_open(other) for each linked sub-mesh, and blocks the arcs to those for which the
    /// answer is false.
    template <typename IsOpen> void block_from(int label, IsOpen is_open);

    /// The labels along a shortest path of passes from `label` (`outward`) or to it, in the order
    /// in which faces pass; its other end is a sub-mesh for which `is_end` answers true. Empty when
    /// there is none. Ties are broken by `random`. O(k).
    template <typename IsEnd>
    const std::vector<int>& find_path(int label, bool outward, IsEnd is_end, Random& random);

    /// Number of sub-meshes that the last search visited.
    int met_count() const { return static_cast<int>(queue_.size()); }

private:
    struct Arc {
        int label;
        /// The clock when the arc was last blocked, to the sub-mesh that lists it [0] and from that
        /// one [1], so that the index is `outward`; -1: never.
        std::int64_t blocked_at[2];
    };

    Arc* find_arc(int label, int other);
    void trace_path(int end, bool outward);

    std::vector<std::vector<Arc>> arcs_;
    std::int64_t clock_ = 0;
    std::vector<std::int64_t> changed_at_;
    std::vector<int> parent_;
    std::vector<int> queue_;
    std::vector<int> path_;
};

template <typename IsOpen> void PassGraph::block_from(int label, IsOpen is_open) {
    for (Arc& arc : arcs_[label]) {
        if (!is_open(arc.label)) {
            arc.blocked_at[1] = clock_;
            find_arc(arc.label, label)->blocked_at[0] = clock_;
        }
    }
}

template <typename IsEnd>
const std::vector<int>&
PassGraph::find_path(int label, bool outward, IsEnd is_end, Random& random) {
    queue_.assign(1, label);
    parent_[label] = label;
    int end = -1;
    for (std::size_t head = 0; head < queue_.size() && end < 0; ++head) {
        const int at = queue_[head];
        const std::vector<Arc>& arcs = arcs_[at];
        const auto count = static_cast<std::uint32_t>(arcs.size());
        const std::uint32_t first = count > 1 ? random.below(count) : 0;
        for (std::uint32_t i = 0; i < count && end < 0; ++i) {
            const Arc& arc = arcs[i + first < count ? i + first : i + first - count];
            const std::int64_t blocked_at = arc.blocked_at[outward];
            const bool is_open =
                blocked_at < changed_at_[at] || blocked_at < changed_at_[arc.label];
            if (parent_[arc.label] < 0 && is_open) {
                parent_[arc.label] = at;
                queue_.push_back(arc.label);
                end = is_end(arc.label) ? arc.label : -1;
            }
        }
    }
    trace_path(end, outward);
    return path_;
}

} // namespace spheroseg
