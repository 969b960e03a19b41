// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "random.h"
#include "submesh_boundaries.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace spheroseg {

/// The graph of sub-meshes with an arc from one to each adjacent one to which a face can pass. Each
/// search brings up to date what it visits of it: whether a face can pass depends on the faces of
/// the two sub-meshes only.
class PassGraph {
public:
    /// Both must outlive the graph. While it is in use, faces move by `pass` only.
    PassGraph(const Patchwork& patchwork, SubmeshBoundaries& boundaries)
        : patchwork_(patchwork), boundaries_(boundaries), submeshes_(patchwork.submesh_count()),
          arc_of_(patchwork.submesh_count(), -1) {
        for (std::vector<Ways>& ways : ways_) {
            ways.resize(patchwork.submesh_count());
        }
    }

    /// The labels along a shortest path of passes from `label` (`outward`) or to it, in the order
    /// in which faces pass; its other end is a sub-mesh for which `is_end` answers true. Empty when
    /// there is none. A pass of the path may close a later one. Ties are broken by `random`. O(F).
    template <typename IsEnd>
    const std::vector<int>& find_path(int label, bool outward, IsEnd is_end, Random& random);

    /// Makes the move of a single face.
    void pass(const Move& move);

    /// Work since the last call: the faces that were looked at; four visited sub-meshes count as
    /// one.
    std::int64_t take_work() { return std::exchange(work_, 0); }

private:
    struct Arc {
        int label;
        SubmeshSide side; // across which a face can pass; its face is -1 where there is none
    };

    /// Between a sub-mesh and each adjacent one.
    struct Ways {
        std::vector<Arc> arcs;
        std::int64_t known_at = -1; // by the clock; -1: not found yet
    };

    struct Submesh {
        std::int64_t changed_at = 0;
        int parent = -1; // during a search
    };

    const std::vector<Arc>& arcs(int label, bool outward);
    bool still_hold(int label, bool outward);
    void find_ways(int label, bool outward);
    void trace_path(int end, bool outward);

    const Patchwork& patchwork_;
    SubmeshBoundaries& boundaries_;
    std::vector<Ways> ways_[2]; // the index is `outward`
    std::int64_t clock_ = 0;
    std::vector<Submesh> submeshes_;
    std::vector<int> arc_of_;
    std::int64_t work_ = 0;
    std::vector<int> queue_;
    std::vector<int> path_;
};

template <typename IsEnd>
const std::vector<int>&
PassGraph::find_path(int label, bool outward, IsEnd is_end, Random& random) {
    queue_.assign(1, label);
    submeshes_[label].parent = label;
    int end = -1;
    for (std::size_t head = 0; head < queue_.size() && end < 0; ++head) {
        const int at = queue_[head];
        const std::vector<Arc>& arcs = this->arcs(at, outward);
        const auto count = static_cast<std::uint32_t>(arcs.size());
        const std::uint32_t first = count > 1 ? random.below(count) : 0;
        for (std::uint32_t i = 0; i < count && end < 0; ++i) {
            const Arc& arc = arcs[i + first < count ? i + first : i + first - count];
            if (arc.side.face >= 0 && submeshes_[arc.label].parent < 0) {
                submeshes_[arc.label].parent = at;
                queue_.push_back(arc.label);
                end = is_end(arc.label) ? arc.label : -1;
            }
        }
    }
    trace_path(end, outward);
    return path_;
}

} // namespace spheroseg
