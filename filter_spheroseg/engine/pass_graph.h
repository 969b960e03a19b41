// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "random.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// Which sub-meshes lie side by side, and between which of them no face can pass as they are.
/// Whether one can depends on the faces of these two sub-meshes only, so what was found out about a
/// pair holds until one of them changes.
class PassGraph {
public:
    explicit PassGraph(int submesh_count)
        : arcs_(submesh_count), changed_at_(submesh_count, 0), parent_(submesh_count, -1) {}

    /// The two sub-meshes share a side. They may stay linked when they do not any more.
    void link(int a, int b);

    /// The two have exchanged faces.
    void change(int a, int b) { changed_at_[a] = changed_at_[b] = ++clock_; }

    /// Calls is_open(other) for each linked sub-mesh, and takes down those to which no face can
    /// pass.
    template <typename IsOpen> void block_from(int label, IsOpen is_open);

    /// The labels along a shortest path of passes from `label` (`outward`) or to it, in the order
    /// in which faces pass; its other end is a sub-mesh for which `is_end` answers true. Empty when
    /// there is none. Ties are broken by `random`. O(k).
    template <typename IsEnd>
    const std::vector<int>& find_path(int label, bool outward, IsEnd is_end, Random& random);

    /// Sub-meshes that the last search met.
    int met_count() const { return static_cast<int>(queue_.size()); }

private:
    struct Arc {
        int label;
        /// When no face could pass from it, and to it.
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
