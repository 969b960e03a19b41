// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstddef>
#include <vector>

namespace spheroseg {

/// Walks breadth first over faces of a patchwork, from those that lie in `queue` from `head` on,
/// and appends the faces that it comes to. `joins(face, neighbor)`: may the walk go on from a face
/// of the queue to its neighbour? It is asked for each of them, and must answer true only once for
/// each neighbour, and never for one that was in the queue before. O(faces walked over).
template <typename Joins>
void walk_faces(const Patchwork& patchwork,
                std::vector<int>& queue,
                const Joins& joins,
                std::size_t head = 0) {
    for (; head < queue.size(); ++head) {
        const int face = queue[head];
        for (int neighbor : patchwork.neighbors(face)) {
            if (neighbor >= 0 && joins(face, neighbor)) {
                queue.push_back(neighbor);
            }
        }
    }
}

} // namespace spheroseg
