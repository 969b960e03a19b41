// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <utility>
#include <vector>

namespace spheroseg {

/// A cell with all that tells what lies around it: half a cache line. `side[c]` is the side of a
/// neighbour that lies along the side from corner c to the next one.
struct alignas(32) LinkedCell {
    /// face << 3 | corner << 1 | turned, where the faces meet from `corner` of `face` to its next
    /// one; turned: both run over the edge in the same direction, as on a Moebius strip. Negative
    /// on an open border.
    int side[3];
    /// Labels across the sides, or kOpenBorder.
    int across[3];
    int label;
    int weight;
};

/// A patchwork for the annealing, which reads labels far more often than it writes them: every
/// cell holds those of its neighbours too, and a walk around a vertex compares no vertices. The
/// `Patches` of moves.h; threads may share it as they do a Patchwork.
class LinkedPatchwork {
public:
    const bool may_close_rings;

    /// O(F), parallel. `cells` is memory to use, its contents are not. Throws InvalidInput for more
    /// faces than `side` can name, 2^28.
    LinkedPatchwork(const Patchwork& patchwork,
                    int thread_count,
                    std::vector<LinkedCell> cells = {});

    int face_count() const { return static_cast<int>(cells_.size()); }
    int submesh_count() const { return submesh_count_; }
    int label(int face) const { return read(cells_[face].label); }
    int label_across(int face, int corner) const { return read(cells_[face].across[corner]); }
    int neighbor(int face, int corner) const { return cells_[face].side[corner] >> 3; }
    int weight(int face) const { return cells_[face].weight; }

    Step step_from(const Step& step) const {
        const int side = cells_[step.face].side[step.exit];
        const int corner = side >> 1 & 3;
        const int next = next_corner(corner);
        // The vertex lies at the begin of the side that is left, or at its end; the face beyond
        // has the side the other way round, unless it is turned.
        const bool at_end = (step.exit == step.at) != ((side & 1) != 0);
        return {side >> 3, at_end ? next : corner, at_end ? next : previous_corner(corner)};
    }

    void set_label(int face, int new_label) {
        LinkedCell& cell = cells_[face];
        write(cell.label, new_label);
        for (int side : cell.side) {
            if (side >= 0) {
                write(cells_[side >> 3].across[side >> 1 & 3], new_label);
            }
        }
    }

    /// Gives the labels back.
    void give_labels(Patchwork& patchwork) const;
    /// Gives the memory back; ends the use of the object.
    std::vector<LinkedCell> take_cells() { return std::move(cells_); }

private:
    static int read(const int& label) { return __atomic_load_n(&label, __ATOMIC_RELAXED); }
    static void write(int& label, int value) { __atomic_store_n(&label, value, __ATOMIC_RELAXED); }

    std::vector<LinkedCell> cells_;
    const int submesh_count_;
};

} // namespace spheroseg
