// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "random.h"
#include "submesh_boundaries.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// A side of a sub-mesh: the edge of `face` at `corner`.
struct Side {
    int face;
    int corner;
};

/// The side across which a face would pass out of the sub-mesh of `face` beyond its edge at
/// `corner`, or, not `outward`, into it.
inline Side passing_side(const Patchwork& patchwork, int face, int corner, bool outward) {
    if (outward) {
        return {face, corner};
    }
    const NeighborSide across = patchwork.cells[face].side[corner];
    return {face_of(across), corner_of(across)};
}

/// Chains of passes, each of one face from a sub-mesh to a neighbour, from a sub-mesh with too many
/// faces to one with room, or to one with too few from one that can spare one. Each pass is planned
/// on the sub-mesh as the pass before it leaves it: which faces a sub-mesh of two or three can give
/// depends on the face that it gets. A sub-mesh has too many faces above `even.ceiling`, too few
/// below `even.floor`.
class PlannedChain {
public:
    PlannedChain(Patchwork& patchwork, SubmeshBoundaries& boundaries, EvenLoads even)
        : patchwork_(patchwork), boundaries_(boundaries), even_(even),
          is_planned_(3 * patchwork.cells.size(), 0) {}

    /// Makes a shortest chain from a sub-mesh with too many faces (`outward`) or to one with too
    /// few, found breadth first over the sides of the mesh; ties are broken by `random`. All
    /// sub-meshes stay connected and free of bowties. Returns false when there is none, or none is
    /// found in about `max_work`.
    bool follow(int label, bool outward, Random& random, std::int64_t max_work) {
        turn_ = random.next();
        return find(label, outward, max_work) && make();
    }

    /// Sub-meshes looked at by the last search. One that found nothing has met every side that can
    /// be reached.
    std::int64_t searches() const { return searches_; }
    /// Faces looked at by it.
    std::int64_t work() const { return work_; }

private:
    struct Pass {
        Move move;
        int corner;
        int previous; // -1: none
    };

    bool find(int label, bool outward, std::int64_t max_work);
    void plan_from(int label, bool outward, int previous);
    bool is_on_chain(int label, int face, int last) const;
    bool make();
    bool is_allowed(const Side& side, Move& move) const {
        return describe_single(patchwork_, side.face, side.corner, move) &&
            single_is_allowed(patchwork_, side.face, side.corner, move);
    }

    Patchwork& patchwork_;
    SubmeshBoundaries& boundaries_;
    const EvenLoads even_;
    std::uint64_t turn_ = 0;
    std::int64_t searches_ = 0;
    std::int64_t work_ = 0;
    int goal_ = -1;
    std::vector<Pass> passes_;
    std::vector<Side> sides_;
    std::vector<std::uint8_t> is_planned_;
};

} // namespace spheroseg
