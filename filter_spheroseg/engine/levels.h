// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cell.h"
#include "hierarchy.h"
#include "hubs.h"

#include <array>
#include <vector>

namespace spheroseg {

/// A coarse version of a mesh, or the mesh itself: how its cells are linked. A cell stands for
/// faces of the mesh that are connected, if need be across holes that are closed.
struct Level {
    std::vector<std::array<NeighborSide, 3>> sides;
    /// Cell i stands for the cells [begin[i], begin[i + 1]) of the finest level; empty there.
    std::vector<int> begin;
    /// Does the next finer level have holes that are closed on this one?
    bool closes_holes = false;
    /// Null without any.
    std::shared_ptr<const Hubs> hubs;

    int cell_count() const { return static_cast<int>(sides.size()); }
    int begin_of(int cell) const { return begin.empty() ? cell : begin[cell]; }
    /// The first cell that begins at cell `finest` of the finest level or after it.
    int first_cell_from(int finest) const;
};

/// Versions of a mesh from fine to coarse. Cells are numbered so that neighbours mostly have near
/// numbers, for the caches, and that the cells which a cell of a coarser level stands for are
/// consecutive, in the order of the coarser cells.
struct MeshLevels {
    /// Each level has at least this share of the cells of the next finer one, and as few more as
    /// the rounds of the hierarchy allow. Exceptions: the coarsest level may have nearly as many
    /// cells as the next finer one, and a level that an undone subdivision leaves has a quarter.
    static constexpr double kLeastShare = 0.4;

    /// The face of the mesh that each cell of the finest level is.
    std::vector<int> face_at;
    /// The finest one first.
    std::vector<Level> levels;
    /// The levels 1 to quartered_count are those that undone subdivisions leave.
    int quartered_count = 0;
};

/// Undoes the collapses of a hierarchy of a mesh with `face_count` faces, and keeps some of the
/// meshes on the way. O(F), of which numbering is serial; the result does not depend on the number
/// of threads.
MeshLevels build_levels(const CollapseHierarchy& hierarchy, int face_count, int thread_count);

/// The finest level only.
MeshLevels
build_finest_level(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count);

} // namespace spheroseg
