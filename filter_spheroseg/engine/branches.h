// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// Finds what a face takes with it when it passes to another sub-mesh and may not pass alone: where
/// sub-meshes are narrow, as between holes, some parts hang together by single faces.
class Branches {
public:
    explicit Branches(Patchwork& patchwork)
        : patchwork_(patchwork), search_of_(patchwork.cells.size(), kNone) {}

    /// The face, which has an edge to sub-mesh `to`, and the fewest faces of its sub-mesh that were
    /// found to have to go with it so that both stay connected and free of bowties. Empty when
    /// that would be more than `max_faces`; looks at no more than some times as many.
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

    /// For a part of what is left of a sub-mesh.
    struct Search {
        std::vector<int> faces;
        /// From `head` on, those whose neighbours were not looked at; none are left once the part
        /// is known.
        std::vector<int> open;
        std::size_t head;
        /// The search that goes on with it; itself as long as it goes on.
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
    /// Of those the first so many are in use; the others keep their memory.
    std::vector<Search> searches_;
    int search_count_ = 0;
    std::vector<int> branch_;
    std::vector<Corner> around_;
    std::vector<int> part_;
    std::int64_t work_ = 0;
};

} // namespace spheroseg
