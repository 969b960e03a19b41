// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

#include <vector>

namespace spheroseg {

/// A face with its label, as the refinement sees it. `neighbor[c]` lies across the edge from
/// corner c to corner (c + 1) % 3; -1 on an open border. Half a cache line.
struct Cell {
    int vertex[3];
    int neighbor[3];
    /// Sub-mesh, or -1 while unassigned.
    int label;
    /// Faces of the input mesh that this face stands for.
    int weight;
};

/// A labelled mesh whose labels change by moves that keep every sub-mesh edge-connected and free
/// of bowties. `load[l]` is the sum of the weights of sub-mesh l.
///
/// Threads may move faces between disjoint groups of labels at the same time: whether a move
/// between labels A and B is allowed depends only on which faces are in A or in B, so that the
/// result does not depend on what other threads do. Labels are read and written as relaxed atomics.
struct Patchwork {
    std::vector<Cell> cells;
    std::vector<int> load;
    /// Sub-meshes may close around a limb. That makes short boundaries, but no move opens a ring
    /// again, so that a mesh with narrow limbs may then not be balanced.
    bool may_close_rings = true;

    int face_count() const { return static_cast<int>(cells.size()); }
    int submesh_count() const { return static_cast<int>(load.size()); }

    int label(int face) const { return __atomic_load_n(&cells[face].label, __ATOMIC_RELAXED); }
    /// The label of the face across an edge; -2 on an open border.
    int label_across(const Cell& cell, int corner) const {
        const int face = cell.neighbor[corner];
        return face < 0 ? -2 : label(face);
    }
    void set_label(int face, int new_label) {
        __atomic_store_n(&cells[face].label, new_label, __ATOMIC_RELAXED);
    }
};

constexpr int kNext[3] = {1, 2, 0};
constexpr int kPrevious[3] = {2, 0, 1};

inline int corner_of(const Cell& cell, int vertex) {
    return (cell.vertex[1] == vertex) + 2 * (cell.vertex[2] == vertex);
}

/// A face around a vertex, as a walk from face to face meets it: the corner of the vertex, and the
/// side across which the walk goes on, one of the two at that corner. Needs no common orientation
/// of the faces.
struct Step {
    int face;
    int at;
    int exit;

    /// The corners at the far ends of the sides across which the walk came and goes on.
    int from() const { return exit == at ? kPrevious[at] : kNext[at]; }
    int to() const { return exit == at ? kNext[at] : exit; }
};

/// The step across `step.exit` to `next`, the face there.
inline Step step_to(const Patchwork& patchwork, const Step& step, int next) {
    const Cell& left = patchwork.cells[step.face];
    const Cell& entered = patchwork.cells[next];
    const int at = corner_of(entered, left.vertex[step.at]);
    const bool along = entered.vertex[kNext[at]] != left.vertex[step.to()];
    return {next, at, along ? at : kPrevious[at]};
}

/// Calls `visit(face)` for the faces around the vertex at `corner` of `face`, without `face`
/// itself, until it answers false. Returns false when it did, or when `stop_at_border` and the
/// vertex lies on an open border.
template <typename Visit>
bool walk_around(
    const Patchwork& patchwork, int face, int corner, bool stop_at_border, Visit visit) {
    for (int exit : {corner, kPrevious[corner]}) {
        Step step{face, corner, exit};
        for (;;) {
            const int next = patchwork.cells[step.face].neighbor[step.exit];
            if (next == face) {
                return true;
            }
            if (next < 0) {
                break;
            }
            if (!visit(next)) {
                return false;
            }
            step = step_to(patchwork, step, next);
        }
        if (stop_at_border) {
            return false;
        }
    }
    return true;
}

/// No face around the vertex, other than `face`, has `label`.
inline bool no_label_around(const Patchwork& patchwork, int face, int corner, int label) {
    return walk_around(
        patchwork, face, corner, false, [&](int f) { return patchwork.label(f) != label; });
}

/// The vertex is not on an open border and all faces around it have `label`.
inline bool all_label_around(const Patchwork& patchwork, int face, int corner, int label) {
    return walk_around(
        patchwork, face, corner, true, [&](int f) { return patchwork.label(f) == label; });
}

/// A set of faces of one label around one vertex that may pass to another label.
struct Move {
    static constexpr int kMaxFaces = 12;
    int faces[kMaxFaces];
    int face_count = 0;
    int from = -1;
    int to = -1;
    /// Change of the number of boundary edges.
    int boundary_change = 0;
    int weight = 0;
};

/// Does a face that is in no sub-mesh touch sub-mesh `to` by an edge, and would it join it without
/// a bowtie?
bool may_join(const Patchwork& patchwork, int face, int to);

/// Describes the move of `face` across its edge at `corner`. False when there is nothing to move:
/// the same label or none on the other side, or the last face of its sub-mesh.
bool describe_single(const Patchwork& patchwork, int face, int corner, Move& move);

/// True when a move from describe_single keeps both sub-meshes connected and free of bowties.
bool single_is_allowed(const Patchwork& patchwork, int face, int corner, const Move& move);

/// Describes the move of all faces with the label of `face` around one end of its edge at `corner`
/// (the end of the edge if `forward`, else its begin) to the label across that edge. False when
/// there is the same label or none, or too many faces.
struct Fan {
    Move move;
    /// How a walk that begins at the edge meets the faces.
    Step steps[Move::kMaxFaces];
};
bool describe_fan(const Patchwork& patchwork, int face, int corner, bool forward, Fan& fan);
bool fan_is_allowed(const Patchwork& patchwork, const Fan& fan);

/// Relabels the faces of the move and keeps `load` up to date.
void apply(Patchwork& patchwork, const Move& move);

/// The load that all sub-meshes would have if they were balanced.
double mean_load(const Patchwork& patchwork);

/// Labels of a finished patchwork, in face order.
std::vector<int> labels_of(const Patchwork& patchwork);

/// A copy whose cells are sorted by label, so that what is worked on together lies together in
/// memory: cell i is cell order[i] of the original. O(F), parallel.
struct SortedPatchwork {
    Patchwork patchwork;
    std::vector<int> order;
};
SortedPatchwork sort_by_label(const Patchwork& patchwork, int thread_count);

/// Takes the labels and loads of the sorted copy back.
void take_labels(Patchwork& patchwork, const SortedPatchwork& sorted);

} // namespace spheroseg
