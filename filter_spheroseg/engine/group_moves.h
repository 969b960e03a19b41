// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// How a group of sub-meshes is annealed: which moves are proposed, which are wanted, and how they
// are made. The cores take one proposal after the other; a GPU judges many of a group at once and
// makes the first one that is wanted, so that the result is the same.
//
// `Group` is what does the work: it has `patches()` (see moves.h), `load(label)`, `apply(move)`,
// `undo(move)` and `list(move)`. `BoundedLoads` needs `random()` and partner lists as well.

#include "metropolis.h"
#include "moves.h"
#include "random.h"

#include <cstdint>

namespace spheroseg {

/// Single moves that cost one edge are not even tried with an allowance below this.
constexpr double kLikelyCost = 0.5;
/// Faces of the other sub-mesh that are tried as the second half of an exchange.
constexpr int kPartnerTries = 16;

/// The settings of one phase of an annealing.
struct Phase {
    double temperature;
    double proposals_per_face;
    std::uint64_t seed;
};

/// What the proposals of a group depend on in one phase.
struct GroupRules {
    const int* group_of_label;
    /// The table of `ExponentialQuantiles`.
    const float* quantiles;
    int group;
    double temperature;
};

/// A face, the fan of its label, or the shorter one of that and the fan across the edge.
enum class MoveKind { single, fan, shorter_fan };

struct Proposal {
    int face;
    int corner;
    MoveKind kind;
    bool forward;
    /// The most that the move may cost.
    double allowance;
};

enum class Drawn {
    proposal,
    /// The move would lead to another group.
    nothing,
    /// The face touches no other sub-mesh any more.
    stale,
};

/// Proposals of a group with so many boundary faces in one phase.
SPHEROSEG_HOST_DEVICE inline std::int64_t proposal_count(double per_face, int face_count) {
    return static_cast<std::int64_t>(per_face * static_cast<double>(face_count));
}

/// A number in [0, count) from the upper half of 64 random bits.
SPHEROSEG_HOST_DEVICE inline int index_of(std::uint64_t bits, int count) {
    return static_cast<int>(((bits >> 32) * static_cast<std::uint64_t>(count)) >> 32);
}

/// The first corner from `first` on, of those whose side (bit c of `sides`: the one at corner c)
/// touches another sub-mesh.
SPHEROSEG_HOST_DEVICE inline int corner_from(unsigned sides, unsigned first) {
    // A table of two bits per entry: no branch, and no memory on a GPU.
    constexpr std::uint64_t kCorners = 0x925A2A115000;
    return static_cast<int>(kCorners >> (2 * (3 * sides + first)) & 3);
}

/// Proposes a move of `face`, a listed face of the group, from random bits.
template <typename Patches>
SPHEROSEG_INNER Drawn draw_proposal(const Patches& patches,
                                    const GroupRules& rules,
                                    int face,
                                    std::uint64_t bits,
                                    Proposal& proposal) {
    const int label = patches.label(face);
    const int across[3] = {patches.label_across(face, 0),
                           patches.label_across(face, 1),
                           patches.label_across(face, 2)};
    const auto differs = [&](int c) {
        return static_cast<unsigned>(across[c] >= 0 && across[c] != label);
    };
    const unsigned sides = differs(0) | differs(1) << 1 | differs(2) << 2;
    if (sides == 0) {
        return Drawn::stale;
    }
    proposal.face = face;
    proposal.allowance = rules.temperature * rules.quantiles[(bits >> 8) & (kQuantileCount - 1)];
    proposal.forward = (bits >> 25) & 1;
    proposal.corner = corner_from(sides, (bits & 0xFF) * 3 >> 8);
    if (rules.group_of_label[across[proposal.corner]] != rules.group) {
        return Drawn::nothing;
    }
    // A face that touches its own sub-mesh by two edges adds a boundary edge when it leaves.
    const bool sits_deep = (sides & (sides - 1)) == 0;
    const bool as_fan = ((bits >> 24) & 1) || (sits_deep && proposal.allowance < kLikelyCost);
    // One of eight is any fan: a heavy face may be able to leave by the longer one only.
    const MoveKind kind_of_fan = ((bits >> 26) & 7) == 0 ? MoveKind::fan : MoveKind::shorter_fan;
    proposal.kind = as_fan ? kind_of_fan : MoveKind::single;
    return Drawn::proposal;
}

template <typename Patches>
SPHEROSEG_HOST_DEVICE bool describe(const Patches& patches, const Proposal& proposal, Fan& fan) {
    switch (proposal.kind) {
    case MoveKind::single:
        return describe_single(patches, proposal.face, proposal.corner, fan.move);
    case MoveKind::fan:
        return describe_fan(patches, proposal.face, proposal.corner, proposal.forward, fan);
    case MoveKind::shorter_fan:
        break;
    }
    return describe_shorter_fan(patches, proposal.face, proposal.corner, proposal.forward, fan);
}

template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
is_allowed(const Patches& patches, const Proposal& proposal, const Fan& fan) {
    return proposal.kind == MoveKind::single
        ? single_is_allowed(patches, proposal.face, proposal.corner, fan.move)
        : fan_is_allowed(patches, fan);
}

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
            // The first side that touches the other sub-mesh, counted without branches.
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
