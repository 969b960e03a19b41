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
        : patchwork_(patchwork), seen_(patchwork.cells.size(), 0) {}

    /// The face, which has an edge to sub-mesh `to`, and the fewest faces of its sub-mesh that were
    /// found to have to go with it so that both stay connected and free of bowties. Empty when
    /// that would be more than `max_faces`. O(faces of the sub-mesh).
    const std::vector<int>& find(int face, int to, int max_faces);

    /// Faces looked at so far.
    std::int64_t work() const { return work_; }

private:
    bool close_fans(int from, int to, std::size_t max_faces);
    bool close_vertex(int face, int corner, int from, int to);
    bool close_parts(int from, int to, std::size_t max_faces);
    void add(int face, int to);
    void list_part(int start, int from, std::vector<int>& part);

    Patchwork& patchwork_;
    std::vector<std::uint8_t> seen_;
    std::vector<int> branch_;
    std::vector<int> around_;
    std::vector<int> part_;
    std::vector<int> largest_part_;
    std::int64_t work_ = 0;
};

} // namespace spheroseg
