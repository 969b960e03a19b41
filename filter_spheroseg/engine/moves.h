// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The moves of the refinement and the tests which of them keep sub-meshes connected and free of
// bowties. `Patches` is a labelled mesh, as in cell.h.

#include "cell.h"

namespace spheroseg {

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

/// Describes the move of `face` across its edge at `corner`. False when there is nothing to move:
/// the same label or none on the other side, or the last face of its sub-mesh.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
describe_single(const Patches& patches, int face, int corner, Move& move) {
    const int from = patches.label(face);
    const int to = patches.label_across(face, corner);
    if (to < 0 || to == from) {
        return false;
    }
    const int other[2] = {patches.label_across(face, next_corner(corner)),
                          patches.label_across(face, previous_corner(corner))};
    const int from_edges = (other[0] == from) + (other[1] == from);
    const int to_edges = 1 + (other[0] == to) + (other[1] == to);
    if (from_edges == 0) {
        return false;
    }
    move.faces[0] = face;
    move.face_count = 1;
    move.from = from;
    move.to = to;
    move.boundary_change = from_edges - to_edges;
    move.weight = patches.weight(face);
    return true;
}

/// True when a move from describe_single keeps both sub-meshes connected and free of bowties.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
single_is_allowed(const Patches& patches, int face, int corner, const Move& move) {
    // from_edges - to_edges: (1, 2) always keeps both; (2, 1) needs the opposite vertex inside
    // `from`, which then has no face of `to`; (1, 1) only needs no face of `to` there.
    if (move.boundary_change < 0) {
        return true;
    }
    const int opposite = previous_corner(corner);
    return move.boundary_change == 0 ? no_label_around(patches, face, opposite, move.to)
                                     : all_label_around(patches, face, opposite, move.from);
}

/// The faces that a fan move takes, and how a walk that begins at the edge meets them.
struct Fan {
    Move move;
    Step steps[Move::kMaxFaces];
};

/// Where a walk around one end of the edge of `face` at `corner` begins on the side of `face`: at
/// the end of the edge if `forward`, else at its begin, away from the edge.
SPHEROSEG_INNER Step begin_fan(int face, int corner, bool forward) {
    return forward ? Step{face, next_corner(corner), next_corner(corner)}
                   : Step{face, corner, previous_corner(corner)};
}

/// Fills in `fan.move` for the first `face_count` steps of the fan. `beyond` is the label across
/// the exit of the last one.
template <typename Patches>
SPHEROSEG_HOST_DEVICE void
finish_fan(const Patches& patches, int face_count, int from, int to, int beyond, Fan& fan) {
    Move& move = fan.move;
    move.from = from;
    move.to = to;
    move.face_count = face_count;
    move.weight = 0;
    int change = -1 - (beyond == to);
    for (int i = 0; i < face_count; ++i) {
        const Step& step = fan.steps[i];
        const int outside = patches.label_across(step.face, next_corner(step.at));
        change += (outside == from) - (outside == to);
        move.faces[i] = step.face;
        move.weight += patches.weight(step.face);
    }
    move.boundary_change = change;
}

/// Describes the move of all faces with the label of `face` around one end of its edge at `corner`
/// (the end of the edge if `forward`, else its begin) to the label across that edge. False when
/// there is the same label or none, or too many faces.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
describe_fan(const Patches& patches, int face, int corner, bool forward, Fan& fan) {
    const int from = patches.label(face);
    const int to = patches.label_across(face, corner);
    if (to < 0 || to == from) {
        return false;
    }
    Step step = begin_fan(face, corner, forward);
    for (int i = 0; i < Move::kMaxFaces; ++i) {
        fan.steps[i] = step;
        const int beyond = patches.label_across(step.face, step.exit);
        if (beyond != from) {
            finish_fan(patches, i + 1, from, to, beyond, fan);
            return true;
        }
        step = patches.step_from(step);
    }
    return false;
}

/// Describes the move of the shorter one of two fans that face each other: all faces with the
/// label of `face` around that end of its edge at `corner`, or all with the label across the edge,
/// to the other label. Of equally long ones it is that of `face`: the drawn one. The longer one
/// rarely pays, since every face of a fan but two adds a boundary edge.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
describe_shorter_fan(const Patches& patches, int face, int corner, bool forward, Fan& fan) {
    const int label = patches.label(face);
    const int other = patches.label_across(face, corner);
    if (other < 0 || other == label) {
        return false;
    }
    Step across[Move::kMaxFaces];
    Step step = begin_fan(face, corner, forward);
    Step step_across = patches.step_from({face, step.at, corner});
    for (int i = 0; i < Move::kMaxFaces; ++i) {
        fan.steps[i] = step;
        across[i] = step_across;
        const int beyond = patches.label_across(step.face, step.exit);
        if (beyond != label) {
            finish_fan(patches, i + 1, label, other, beyond, fan);
            return true;
        }
        const int beyond_across = patches.label_across(step_across.face, step_across.exit);
        if (beyond_across != other) {
            for (int j = 0; j <= i; ++j) {
                fan.steps[j] = across[j];
            }
            finish_fan(patches, i + 1, other, label, beyond_across, fan);
            return true;
        }
        step = patches.step_from(step);
        step_across = patches.step_from(step_across);
    }
    return false;
}

/// True when such a move of a fan keeps both sub-meshes connected and free of bowties.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool fan_is_allowed(const Patches& patches, const Fan& fan) {
    const Move& move = fan.move;
    // What is left of `from` must touch the fan in one run of edges, whose inner vertices lie
    // inside `from`; `to` may touch a vertex of the ring only next to the fan. Where `to` touches
    // the fan in two runs it closes to a ring.
    int runs = 0;
    bool previous_from = false;
    bool previous_to = true;
    int to_runs = 1;
    for (int i = 0; i < move.face_count; ++i) {
        const Step& step = fan.steps[i];
        const int outside = patches.label_across(step.face, next_corner(step.at));
        const bool touches_from = outside == move.from;
        const bool touches_to = outside == move.to;
        if (touches_from && !previous_from && ++runs > 1) {
            return false;
        }
        if (touches_from && previous_from &&
            !all_label_around(patches, step.face, step.from(), move.from)) {
            return false;
        }
        if (!touches_to && !previous_to && !(touches_from && previous_from) &&
            !no_label_around(patches, step.face, step.from(), move.to)) {
            return false;
        }
        to_runs += touches_to && !previous_to;
        previous_from = touches_from;
        previous_to = touches_to;
    }
    const Step& last = fan.steps[move.face_count - 1];
    const bool ends_at_to = patches.label_across(last.face, last.exit) == move.to;
    if (!previous_to && !ends_at_to && !no_label_around(patches, last.face, last.to(), move.to)) {
        return false;
    }
    // All around the centre of the fan, the last run goes over into the first one.
    to_runs -= ends_at_to && previous_to;
    return runs == 1 && (to_runs == 1 || patches.may_close_rings);
}

} // namespace spheroseg
