// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The acceptance rules of annealing a group of sub-meshes, shared by CPU and GPU: which proposed
// moves are wanted, and how they are made. The CPU takes one proposal after the other; the GPU
// judges many proposals of a group at once and makes the first one that is wanted, so that the
// result is the same.
//
// `Group` holds the state of the group: it has `patches()` (see cell.h), `load(label)`,
// `apply(move)`, `undo(move)` and `list(move)`, which adds the faces of a move to the candidates of
// later proposals. `BoundedLoads` needs `random()` and partner lists as well.

#include "proposals.h"

namespace spheroseg {

/// Faces of the other sub-mesh that are tried as the second half of an exchange.
constexpr int kPartnerTries = 16;

/// Loads may differ, at a cost.
struct FreeLoads {
    /// Per squared unit of load.
    double balance_weight;

    /// Whether the move is allowed and costs no more than it may; of a fan that costs too much,
    /// whether the one at the other end of its edge is. Fills `fan`.
    template <typename Group>
    SPHEROSEG_HOST_DEVICE bool wants(const Group& group, Proposal proposal, Fan& fan) const {
        const auto& patches = group.patches();
        for (int end = 0; end < (proposal.kind == MoveKind::single ? 1 : 2); ++end) {
            if (describe(patches, proposal, fan) && cost(group, fan.move) <= proposal.allowance) {
                return is_allowed(patches, proposal, fan);
            }
            proposal.forward = !proposal.forward;
        }
        return false;
    }

    /// Returns the change of the number of boundary edges.
    template <typename Group>
    SPHEROSEG_HOST_DEVICE int make(Group& group, const Proposal&, const Fan& fan) const {
        group.apply(fan.move);
        group.list(fan.move);
        return fan.move.boundary_change;
    }

private:
    template <typename Group>
    SPHEROSEG_HOST_DEVICE double cost(const Group& group, const Move& move) const {
        // Change of the sum of squared loads of the two sub-meshes.
        const double change =
            2.0 * move.weight * (group.load(move.to) - group.load(move.from) + move.weight);
        return move.boundary_change + balance_weight * change;
    }
};

/// Loads stay in a range: a move that leaves it is made together with a move back. The group keeps
/// a list of partners per label, faces that may lie beside another sub-mesh, of limited length.
struct BoundedLoads {
    int floor;
    int ceiling;

    /// Whether the move is allowed and costs no more than it may. Fills `fan`.
    template <typename Group>
    SPHEROSEG_HOST_DEVICE bool wants(const Group& group, const Proposal& proposal, Fan& fan) const {
        const auto& patches = group.patches();
        return describe(patches, proposal, fan) && fan.move.boundary_change <= proposal.allowance &&
            is_allowed(patches, proposal, fan);
    }

    /// Makes the move if the range is kept or can be regained. Returns the change of the number of
    /// boundary edges.
    template <typename Group>
    SPHEROSEG_HOST_DEVICE int make(Group& group, const Proposal& proposal, const Fan& fan) const {
        const Move& move = fan.move;
        int change = move.boundary_change;
        const bool alone = keeps_range(group, move);
        group.apply(move);
        if (!alone) {
            Fan back;
            if (!find_move_back(group, move, proposal.allowance - change, back)) {
                group.undo(move);
                return 0;
            }
            group.apply(back.move);
            list(group, back.move);
            change += back.move.boundary_change;
        }
        list(group, move);
        return change;
    }

private:
    template <typename Group>
    SPHEROSEG_HOST_DEVICE bool keeps_range(const Group& group, const Move& move) const {
        const int from_load = group.load(move.from) - move.weight;
        const int to_load = group.load(move.to) + move.weight;
        return from_load >= floor && from_load <= ceiling && to_load >= floor && to_load <= ceiling;
    }

    /// Looks for a move from `first.to` back to `first.from` that restores the range.
    template <typename Group>
    SPHEROSEG_HOST_DEVICE bool
    find_move_back(Group& group, const Move& first, double allowance, Fan& back) const {
        const auto& patches = group.patches();
        for (int i = 0; i < kPartnerTries && group.partner_count(first.to) > 0; ++i) {
            const std::uint64_t bits = group.random().next();
            const int index = index_of(bits, group.partner_count(first.to));
            const int face = group.partner(first.to, index);
            if (patches.label(face) != first.to) {
                group.drop_partner(first.to, index);
                continue;
            }
            // Branch-free search for the first side that touches the other sub-mesh.
            const int misses = patches.label_across(face, 0) != first.from;
            const int more = misses & (patches.label_across(face, 1) != first.from);
            const int all = more & (patches.label_across(face, 2) != first.from);
            if (all) {
                continue;
            }
            const int corner = misses + more;
            const Proposal partner{face,
                                   corner,
                                   first.face_count > 1 ? MoveKind::fan : MoveKind::single,
                                   ((bits >> 1) & 1) != 0,
                                   allowance};
            if (describe(patches, partner, back) && back.move.boundary_change <= allowance &&
                keeps_range(group, back.move) && is_allowed(patches, partner, back)) {
                return true;
            }
        }
        return false;
    }

    template <typename Group>
    SPHEROSEG_HOST_DEVICE void list(Group& group, const Move& move) const {
        const auto& patches = group.patches();
        for (int i = 0; i < move.face_count; ++i) {
            const int face = move.faces[i];
            group.add_partner(move.to, face);
            for (int c = 0; c < 3; ++c) {
                if (patches.label_across(face, c) == move.from) {
                    group.add_partner(move.from, patches.neighbor(face, c));
                }
            }
        }
        group.list(move);
    }
};

} // namespace spheroseg
