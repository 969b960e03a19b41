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
    /// Are holes closed here that the next finer level has?
    bool closes_holes = false;
    /// Null without any.
    std::shared_ptr<const Hubs> hubs;

    int cell_count() const { return static_cast<int>(sides.size()); }
    int begin_of(int cell) const { return begin.empty() ? cell : begin[cell]; }
    /// The first cell that stands for none before cell `finest` of the finest level.
    int first_cell_from(int finest) const;
};

/// Versions of a mesh from fine to coarse. Cells that lie side by side have numbers near each
/// other, so that caches hold what is worked on together, and the cells that one of a coarser level
/// stands for follow one another, in the order of the cells there.
struct MeshLevels {
    /// Each level has at least this share of the cells of the next finer one, and few more, as far
    /// as single rounds of the hierarchy allow; the coarsest one may have nearly as many. But where
    /// a subdivision is undone it has a quarter.
    static constexpr double kLeastShare = 0.4;

    /// The face of the mesh that each cell of the finest level is.
    std::vector<int> face_at;
    /// The finest one first.
    std::vector<Level> levels;
    /// How many of these, after the finest one, are what undone subdivisions leave.
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
