// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "random.h"

#include <array>
#include <vector>

namespace spheroseg {

/// Connected faces of a region, by their numbers in it.
struct FaceBlock {
    struct Edge {
        int inside;
        int outside;
    };
    struct Origin {
        int side;
        int edge;
    };
    /// The two blocks that it is made of; -1 for a single face.
    std::array<int, 2> of = {-1, -1};
    int face_count = 1;
    /// The edges to other faces of the region.
    std::vector<Edge> outer;
    /// Of which of the two blocks an outer edge is, and which of its outer edges.
    std::vector<Origin> origin;
    /// The edges between the two: which outer edges of theirs.
    std::vector<std::array<int, 2>> inner;

    bool is_face() const { return of[0] < 0; }
};

/// Joins faces to blocks, two at a time, such that blocks have few outer edges: a branch
/// decomposition of the dual graph. Always those two are joined that have the fewest outer edges
/// together; of these the two with the most edges to blocks that touch both, which can be joined to
/// them next; then those with the fewest faces; then by chance. O(faces log faces).
///
/// Returns the blocks: [0, faces) are the single faces, in the order of `faces`, each later one is
/// made of two earlier ones, and the last one is all faces. Empty when a block would have more than
/// `most_edges` outer edges, or the faces are not connected.
std::vector<FaceBlock> branch_decomposition(const Patchwork& patchwork,
                                            const std::vector<int>& faces,
                                            int most_edges,
                                            Random& random);

} // namespace spheroseg
