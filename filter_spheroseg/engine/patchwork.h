// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hubs.h"
#include "moves.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace spheroseg {

/// A labelled mesh whose labels change by moves that keep every sub-mesh edge-connected and free
/// of bowties. `load[l]` is the sum of the weights of sub-mesh l.
///
/// Threads may move faces between disjoint groups of labels at the same time: whether a move
/// between labels A and B is allowed depends only on which faces are in A or in B, so that the
/// result does not depend on what other threads do. Labels are read and written as relaxed atomics.
struct Patchwork {
    /// Each cell holds a copy of the labels across its sides (Cell::across), so labels must not be
    /// written directly: use set_label, or set_own_label for many faces and then tell_neighbors.
    std::vector<Cell> cells;
    std::vector<int> load;
    /// May a sub-mesh become a ring, as around a limb or a hole? Rings have short boundaries, but
    /// no move opens one again, so that a mesh with narrow limbs may then not be balanced.
    bool may_close_rings = true;
    /// Did the last repair leave sub-meshes that are not edge-connected, or have a bowtie?
    bool may_be_unsound = false;
    /// Vertices with very many faces; null where there are none, as on most meshes.
    std::shared_ptr<const Hubs> hubs;
    /// What each sub-mesh has at them; kept in step with the labels.
    HubShares hub_shares;

    int face_count() const { return static_cast<int>(cells.size()); }
    int submesh_count() const { return static_cast<int>(load.size()); }

    int label(int face) const { return read(cells[face].label); }
    int weight(int face) const { return cells[face].weight; }
    /// The face across an edge; -1 on an open border.
    int neighbor(int face, int corner) const { return face_of(cells[face].side[corner]); }
    std::array<int, 3> neighbors(int face) const {
        return {neighbor(face, 0), neighbor(face, 1), neighbor(face, 2)};
    }
    /// The label of that face; kOpenBorder if there is none.
    int label_across(int face, int corner) const { return read(cells[face].across[corner]); }
    Step step_from(const Step& step) const {
        return step_across(step, cells[step.face].side[step.exit]);
    }

    void set_label(int face, int new_label) {
        if (hubs) {
            pass_at_hubs(face, new_label);
        }
        Cell& cell = cells[face];
        write(cell.label, new_label);
        for (NeighborSide side : cell.side) {
            if (side >= 0) {
                write(cells[face_of(side)].across[corner_of(side)], new_label);
            }
        }
    }

    /// To label many faces at once: set_own_label leaves the copies in the neighbouring cells as
    /// they are, and tell_neighbors updates the copies in all cells. O(F), parallel.
    void set_own_label(int face, int new_label) { write(cells[face].label, new_label); }
    void tell_neighbors(int thread_count = 1);

private:
    /// Keeps the shares in step with a label that is about to be set.
    void pass_at_hubs(int face, int new_label);
    void count_at_hubs();

    static int read(const int& label) { return __atomic_load_n(&label, __ATOMIC_RELAXED); }
    static void write(int& label, int value) { __atomic_store_n(&label, value, __ATOMIC_RELAXED); }
};

/// Is the vertex at `corner` of `face` a hub, and `label` one whose shares are counted?
inline bool is_counted(const Patchwork& patchwork, int face, int corner, int label) {
    return patchwork.hubs && patchwork.hubs->at[face][corner] != Hubs::kNone &&
        patchwork.hub_shares.counts(label);
}

/// What `label` has at that hub; is_counted must hold.
inline HubShare share_at(const Patchwork& patchwork, int face, int corner, int label) {
    return patchwork.hub_shares.find(label, patchwork.hubs->at[face][corner]);
}
bool no_label_around_hub(const Patchwork& patchwork, int face, int corner, int label);
bool all_label_around_hub(const Patchwork& patchwork, int face, int corner, int label);

/// The tests of cell.h without a walk around hubs. Overload resolution picks these wherever moves.h
/// works on a Patchwork.
inline bool no_label_around(const Patchwork& patchwork, int face, int corner, int label) {
    return is_counted(patchwork, face, corner, label)
        ? no_label_around_hub(patchwork, face, corner, label)
        : no_label_around<Patchwork>(patchwork, face, corner, label);
}
inline bool all_label_around(const Patchwork& patchwork, int face, int corner, int label) {
    return is_counted(patchwork, face, corner, label)
        ? all_label_around_hub(patchwork, face, corner, label)
        : all_label_around<Patchwork>(patchwork, face, corner, label);
}

/// A corner of a face.
struct Corner {
    int face;
    int at;
};

/// Lists the corners at the vertex at `corner` of `face` in order around it. True when they close
/// to a ring: the first follows the last.
bool list_corners(const Patchwork& patchwork, int face, int corner, std::vector<Corner>& corners);

/// How many of the two sides of a face at the vertex at `corner` have another label or an open
/// border beyond them. Each fan of a sub-mesh that does not go all around the vertex has two such
/// sides, so a sub-mesh with more than two of them around one vertex has a bowtie there.
inline int fan_ends(const Patchwork& patchwork, int face, int corner) {
    const int label = patchwork.label(face);
    return (patchwork.label_across(face, corner) != label) +
        (patchwork.label_across(face, previous_corner(corner)) != label);
}

/// Does another label or an open border lie across an edge of a face?
inline bool is_at_rim(const Patchwork& patchwork, int face) {
    const int label = patchwork.label(face);
    return patchwork.label_across(face, 0) != label || patchwork.label_across(face, 1) != label ||
        patchwork.label_across(face, 2) != label;
}

/// May an unassigned face be added to sub-mesh `to`: do they share an edge, and does no bowtie
/// arise?
bool may_join(const Patchwork& patchwork, int face, int to);

/// Relabels the faces of the move and keeps `load` up to date.
void apply(Patchwork& patchwork, const Move& move);

/// Recomputes `load` from the labels; unassigned faces count for nothing.
void sum_loads(Patchwork& patchwork);

/// The load that all sub-meshes would have if they were balanced.
double mean_load(const Patchwork& patchwork);

/// Cells per sub-mesh.
double mean_cell_count(const Patchwork& patchwork);

double mean_face_weight(const Patchwork& patchwork);
/// What sub-meshes have above the mean load, rounded up, over the load of all.
double excess_share(const Patchwork& patchwork);

/// The loads that sub-meshes of unit weights may have.
struct LoadRange {
    int floor;
    int ceiling;

    /// Faces that a sub-mesh with this load has too many or too few.
    int deviation(int load) const { return std::max({0, load - ceiling, floor - load}); }
    /// Faces that it can take (`outward`) or spare; below 0 where it has too many or too few.
    int room(int load, bool outward) const { return outward ? ceiling - load : load - floor; }
};

/// Those that differ by at most one.
LoadRange even_loads(const Patchwork& patchwork);
/// Faces that all sub-meshes together have too many and too few, measured at those.
std::int64_t misplaced(const Patchwork& patchwork);

/// The neighbours of each face; the face itself beyond open borders. What only walks over the faces
/// reads less than half as much memory here as in the cells.
std::vector<std::array<int, 3>> neighbor_table(const Patchwork& patchwork, int thread_count);

/// Fetches the cell of a face that a loop over `faces` comes to soon after the i-th one: the cells
/// of boundary faces lie anywhere in memory.
inline void fetch_ahead(const Patchwork& patchwork, const std::vector<int>& faces, int i) {
    constexpr int kAhead = 12;
    const int ahead = std::min(i + kAhead, static_cast<int>(faces.size()) - 1);
    __builtin_prefetch(&patchwork.cells[faces[ahead]]);
}

/// Faces sorted by label, in the order of the list within each: those of sub-mesh l are
/// faces[begin[l] .. begin[l + 1]).
struct FacesByLabel {
    std::vector<int> begin;
    std::vector<int> faces;
};

/// Of a list of faces, or of all.
FacesByLabel sort_by_label(const Patchwork& patchwork, const std::vector<int>& faces);
FacesByLabel sort_by_label(const Patchwork& patchwork);

/// Some sub-meshes of a patchwork, and all their faces in any order.
struct Region {
    std::vector<int> faces;
    std::vector<int> labels;
};

/// The label of each cell, in the order of the cells, on any level.
std::vector<int> cell_labels(const Patchwork& patchwork);

} // namespace spheroseg
