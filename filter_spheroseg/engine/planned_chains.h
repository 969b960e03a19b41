// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "random.h"
#include "submesh_boundaries.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace spheroseg {

/// Chains of passes, each of one face from a sub-mesh to a neighbour, from sub-meshes with too many
/// faces to ones with room, or to ones with too few from ones that can spare a face. Each pass is
/// planned on the sub-mesh as the pass before it leaves it: which faces a sub-mesh of two or three
/// can give depends on the face that it gets. A sub-mesh has too many faces above `even.ceiling`,
/// too few below `even.floor`.
class PlannedChains {
public:
    /// Receives the number of faces that were looked at since its previous call. False means that
    /// no more chains are searched for; those found so far are made.
    using Report = std::function<bool(std::int64_t)>;

    PlannedChains(Patchwork& patchwork, SubmeshBoundaries& boundaries, LoadRange even)
        : patchwork_(patchwork), boundaries_(boundaries), even_(even),
          is_planned_(3 * patchwork.cells.size(), 0), promised_(patchwork.submesh_count(), 0) {}

    /// Makes a short chain from each of the sub-meshes with too many faces (`outward`), or to each
    /// of those with too few. They are found breadth first over the sides of the mesh, from all of
    /// these at the same time, so that each side is met once; ties are broken by `random`. A chain
    /// may break where another one was made before it, or where it comes back to a sub-mesh; then
    /// its face stays on the way. All sub-meshes stay connected and free of bowties.
    void follow(bool outward, Random& random, const Report& report);

private:
    struct Pass {
        SubmeshSide side;
        int from;
        int to;
        int previous; // -1: none
        /// The index, in the list of sub-meshes that are off, of the one where the chain begins.
        int begin;
    };

    void find(const std::vector<int>& labels, bool outward, const Report& report);
    void plan_from(int label, bool outward, int previous, int begin);
    void forget();
    void make(int last);

    Patchwork& patchwork_;
    SubmeshBoundaries& boundaries_;
    const LoadRange even_;
    std::uint64_t turn_ = 0;
    std::int64_t work_ = 0;
    std::vector<Pass> passes_;
    /// The last passes of the chains that were found.
    std::vector<int> ends_;
    std::vector<SubmeshSide> sides_;
    std::vector<std::uint8_t> is_planned_;
    /// Per sub-mesh the chains found so far that end there: each takes one unit of its room.
    std::vector<int> promised_;
};

} // namespace spheroseg
