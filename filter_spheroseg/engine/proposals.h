// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Which moves are proposed to a group of sub-meshes that is annealed. `Patches` is a labelled mesh,
// as in cell.h.

#include "metropolis.h"
#include "moves.h"
#include "random.h"

#include <cstdint>

namespace spheroseg {

/// Single moves that cost one edge are not even tried with an allowance below this.
constexpr double kLikelyCost = 0.5;

/// The settings of one phase of an annealing.
struct Phase {
    double temperature;
    double proposals_per_face;
    std::uint64_t seed;
};

/// What the proposals of a group depend on in one phase.
struct GroupRules {
    const int* group_of_label;
    /// The table exponential_quantiles() of metropolis.h.
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
    // A face with two edges to its own sub-mesh adds a boundary edge when it leaves.
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

} // namespace spheroseg
