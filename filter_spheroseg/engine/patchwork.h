// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"
#include "moves.h"

#include <vector>

namespace spheroseg {

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
    int weight(int face) const { return cells[face].weight; }
    /// The face across an edge; -1 on an open border.
    int neighbor(int face, int corner) const { return cells[face].neighbor[corner]; }
    /// Its label; kOpenBorder if there is none.
    int label_across(int face, int corner) const {
        const int other = neighbor(face, corner);
        return other < 0 ? kOpenBorder : label(other);
    }
    Step step_from(const Step& step) const { return step_between(cells.data(), step); }
    void set_label(int face, int new_label) {
        __atomic_store_n(&cells[face].label, new_label, __ATOMIC_RELAXED);
    }
};

/// Does a face that is in no sub-mesh touch sub-mesh `to` by an edge, and would it join it without
/// a bowtie?
bool may_join(const Patchwork& patchwork, int face, int to);

// One copy for all that work on the cores.
extern template bool no_label_around(const Patchwork&, int face, int corner, int label);
extern template bool all_label_around(const Patchwork&, int face, int corner, int label);
extern template bool describe_single(const Patchwork&, int face, int corner, Move&);
extern template bool single_is_allowed(const Patchwork&, int face, int corner, const Move&);
extern template bool describe_fan(const Patchwork&, int face, int corner, bool forward, Fan&);
extern template bool fan_is_allowed(const Patchwork&, const Fan&);

/// Relabels the faces of the move and keeps `load` up to date.
void apply(Patchwork& patchwork, const Move& move);

/// The load that all sub-meshes would have if they were balanced.
double mean_load(const Patchwork& patchwork);

double mean_face_weight(const Patchwork& patchwork);

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
