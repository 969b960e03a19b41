// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// Finds which other faces must move with a face that may not move to another sub-mesh alone: where
/// sub-meshes are narrow, as between holes, some of their parts are connected by single faces only.
class Branches {
public:
    explicit Branches(Patchwork& patchwork)
        : patchwork_(patchwork), search_of_(patchwork.cells.size(), kNone) {}

    /// A small set of faces of the sub-mesh of `face`, with `face` first, that can move to sub-mesh
    /// `to` such that both stay connected and free of bowties. `face` must have an edge to `to`.
    /// Empty when no set of up to `max_faces` faces was found; the search looks at no more than
    /// some times as many. The result is valid until the next call.
    const std::vector<int>& find(int face, int to, int max_faces);

    /// Faces looked at so far.
    std::int64_t work() const { return work_; }

private:
    bool close_fans(int from, int to, std::size_t max_faces);
    bool close_vertex(int face, int corner, int from, int to);
    bool close_parts(int from, int to, std::size_t max_faces);
    void add(int face, int to);
    void begin_searches(int from);
    void go_on(int number, int from);
    int root_of(int search) const;

    static constexpr int kNone = -1;

    /// A breadth-first search of one connected part of what the branch leaves of its sub-mesh.
    struct Search {
        std::vector<int> faces;
        /// The queue: from `head` on, the faces whose neighbours were not looked at yet. Empty when
        /// the whole part is found.
        std::vector<int> open;
        std::size_t head;
        /// The search that this one was merged into, as of a union-find forest; itself if none.
        int into;

        void clear_into(int number) {
            faces.clear();
            open.clear();
            head = 0;
            into = number;
        }
    };

    Patchwork& patchwork_;
    std::vector<int> search_of_;
    /// The first search_count_ are in use; the others keep their memory for later.
    std::vector<Search> searches_;
    int search_count_ = 0;
    std::vector<int> branch_;
    std::vector<Corner> around_;
    std::vector<int> part_;
    std::int64_t work_ = 0;
};

} // namespace spheroseg
