// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The moves of the refinement and the tests which of them keep sub-meshes connected and free of
// bowties. `Patches` is a labelled mesh: Patchwork, or what a GPU holds of one. It has `cells`,
// `label(face)`, `label_across(cell, corner)` and `may_close_rings`, as Patchwork has.

#include "host_device.h"

namespace spheroseg {

/// A face with its label, as the refinement sees it. `neighbor[c]` lies across the edge from
/// corner c to corner (c + 1) % 3; -1 on an open border. Half a cache line.
struct alignas(32) Cell {
    int vertex[3];
    int neighbor[3];
    /// Sub-mesh, or -1 while unassigned.
    int label;
    /// Faces of the input mesh that this face stands for.
    int weight;
};

// A table on the cores; a GPU, which has none in its registers, shifts the same entries of two
// bits.
constexpr int kNextCorner[3] = {1, 2, 0};
constexpr int kPreviousCorner[3] = {2, 0, 1};

SPHEROSEG_INNER int next_corner(int corner) {
#if defined(__CUDA_ARCH__)
    return 0x09 >> 2 * corner & 3;
#else
    return kNextCorner[corner];
#endif
}
SPHEROSEG_INNER int previous_corner(int corner) {
#if defined(__CUDA_ARCH__)
    return 0x12 >> 2 * corner & 3;
#else
    return kPreviousCorner[corner];
#endif
}

SPHEROSEG_HOST_DEVICE inline int corner_of(const Cell& cell, int vertex) {
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
    SPHEROSEG_HOST_DEVICE int from() const {
        return exit == at ? previous_corner(at) : next_corner(at);
    }
    SPHEROSEG_HOST_DEVICE int to() const { return exit == at ? next_corner(at) : exit; }
};

/// The step across `step.exit` to `next`, the face there.
template <typename Patches>
SPHEROSEG_HOST_DEVICE Step step_to(const Patches& patches, const Step& step, int next) {
    const Cell& left = patches.cells[step.face];
    const Cell& entered = patches.cells[next];
    const int at = corner_of(entered, left.vertex[step.at]);
    const bool along = entered.vertex[next_corner(at)] != left.vertex[step.to()];
    return {next, at, along ? at : previous_corner(at)};
}

/// Calls `visit(face)` for the faces around the vertex at `corner` of `face`, without `face`
/// itself, until it answers false. Returns false when it did, or when `stop_at_border` and the
/// vertex lies on an open border.
template <typename Patches, typename Visit>
SPHEROSEG_HOST_DEVICE bool
walk_around(const Patches& patches, int face, int corner, bool stop_at_border, Visit visit) {
    for (int side = 0; side < 2; ++side) {
        Step step{face, corner, side == 0 ? corner : previous_corner(corner)};
        for (;;) {
            const int next = patches.cells[step.face].neighbor[step.exit];
            if (next == face) {
                return true;
            }
            if (next < 0) {
                break;
            }
            if (!visit(next)) {
                return false;
            }
            step = step_to(patches, step, next);
        }
        if (stop_at_border) {
            return false;
        }
    }
    return true;
}

/// No face around the vertex, other than `face`, has `label`.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
no_label_around(const Patches& patches, int face, int corner, int label) {
    return walk_around(
        patches, face, corner, false, [&](int f) { return patches.label(f) != label; });
}

/// The vertex is not on an open border and all faces around it have `label`.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
all_label_around(const Patches& patches, int face, int corner, int label) {
    return walk_around(
        patches, face, corner, true, [&](int f) { return patches.label(f) == label; });
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

/// Describes the move of `face` across its edge at `corner`. False when there is nothing to move:
/// the same label or none on the other side, or the last face of its sub-mesh.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
describe_single(const Patches& patches, int face, int corner, Move& move) {
    const Cell& cell = patches.cells[face];
    const int from = patches.label(face);
    const int to = patches.label_across(cell, corner);
    if (to < 0 || to == from) {
        return false;
    }
    const int other[2] = {patches.label_across(cell, next_corner(corner)),
                          patches.label_across(cell, previous_corner(corner))};
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
    move.weight = cell.weight;
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

/// Describes the move of all faces with the label of `face` around one end of its edge at `corner`
/// (the end of the edge if `forward`, else its begin) to the label across that edge. False when
/// there is the same label or none, or too many faces.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
describe_fan(const Patches& patches, int face, int corner, bool forward, Fan& fan) {
    const int label = patches.label(face);
    Move& move = fan.move;
    move.from = label;
    move.to = patches.label_across(patches.cells[face], corner);
    if (move.to < 0 || move.to == label) {
        return false;
    }
    move.face_count = 0;
    move.weight = 0;
    int change = -1;
    Step step = forward ? Step{face, next_corner(corner), next_corner(corner)}
                        : Step{face, corner, previous_corner(corner)};
    for (;;) {
        if (move.face_count == Move::kMaxFaces) {
            return false;
        }
        const Cell& cell = patches.cells[step.face];
        fan.steps[move.face_count] = step;
        move.faces[move.face_count++] = step.face;
        move.weight += cell.weight;
        const int outside = patches.label_across(cell, next_corner(step.at));
        change += (outside == label) - (outside == move.to);
        const int next = cell.neighbor[step.exit];
        const int next_label = next < 0 ? -2 : patches.label(next);
        if (next_label != label) {
            change -= next_label == move.to;
            break;
        }
        step = step_to(patches, step, next);
    }
    move.boundary_change = change;
    return true;
}

/// True when a move from describe_fan keeps both sub-meshes connected and free of bowties.
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
        const int outside = patches.label_across(patches.cells[step.face], next_corner(step.at));
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
    const bool ends_at_to = patches.label_across(patches.cells[last.face], last.exit) == move.to;
    if (!previous_to && !ends_at_to && !no_label_around(patches, last.face, last.to(), move.to)) {
        return false;
    }
    // All around the centre of the fan, the last run goes over into the first one.
    to_runs -= ends_at_to && previous_to;
    return runs == 1 && (to_runs == 1 || patches.may_close_rings);
}

} // namespace spheroseg
