// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// How the refinement sees a face, and walks from face to face around a vertex. `Patches` is a
// labelled mesh: a Patchwork, or what a GPU holds of one.
// It has `label(face)`, `weight(face)`, `neighbor(face, corner)`, `label_across(face, corner)`,
// `step_from(step)` and `may_close_rings`, as Patchwork has.

#include "host_device.h"

#include <initializer_list>

namespace spheroseg {

/// The label across a side on an open border.
constexpr int kOpenBorder = -2;

/// A side of a neighbour, where two faces meet: face << 3 | corner << 1 | turned, if the side runs
/// from `corner` of `face` to its next corner; turned: both faces run over the edge in the same
/// direction, as on a Moebius strip. Negative on an open border. There is room for kMaxFaces.
using NeighborSide = int;

SPHEROSEG_INNER int face_of(NeighborSide side) {
    return side >> 3;
}
SPHEROSEG_INNER int corner_of(NeighborSide side) {
    return side >> 1 & 3;
}
SPHEROSEG_INNER bool is_turned(NeighborSide side) {
    return (side & 1) != 0;
}
inline NeighborSide make_side(int face, int corner, bool turned) {
    return face << 3 | corner << 1 | static_cast<int>(turned);
}

/// A face with its label and what lies across its sides, as the refinement sees it. Side c runs
/// from corner c to corner (c + 1) % 3. Half a cache line.
struct alignas(32) Cell {
    NeighborSide side[3];
    /// Labels across the sides, kOpenBorder where there is none: they are read far more often than
    /// written.
    int across[3];
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

/// The step across `step.exit` to the face there, which must be one; `side` is what lies there.
SPHEROSEG_INNER Step step_across(const Step& step, NeighborSide side) {
    const int corner = corner_of(side);
    const int next = next_corner(corner);
    // The vertex lies at the begin of the side that is left, or at its end; the face beyond has
    // the side the other way round, unless it is turned.
    const bool at_end = (step.exit == step.at) != is_turned(side);
    return {face_of(side), at_end ? next : corner, at_end ? next : previous_corner(corner)};
}

/// Calls `visit(face, label)` for the faces around the vertex at `corner` of `face`, without `face`
/// itself, until it answers false. Returns false when it did, or when `stop_at_border` and the
/// vertex lies on an open border.
template <typename Patches, typename Visit>
SPHEROSEG_HOST_DEVICE bool
walk_around(const Patches& patches, int face, int corner, bool stop_at_border, Visit visit) {
    for (int side = 0; side < 2; ++side) {
        Step step{face, corner, side == 0 ? corner : previous_corner(corner)};
        for (;;) {
            const int next = patches.neighbor(step.face, step.exit);
            if (next == face) {
                return true;
            }
            if (next < 0) {
                break;
            }
            if (!visit(next, patches.label_across(step.face, step.exit))) {
                return false;
            }
            step = patches.step_from(step);
        }
        if (stop_at_border) {
            return false;
        }
    }
    return true;
}

/// Calls `visit(face, corner)` for all corners at the vertex at `corner` of `face`, itself
/// included. `Links` is a mesh that need not be labelled.
template <typename Links, typename Visit>
void for_each_around(const Links& mesh, int face, int corner, Visit visit) {
    visit(face, corner);
    for (int exit : {corner, previous_corner(corner)}) {
        Step step{face, corner, exit};
        while (mesh.neighbor(step.face, step.exit) >= 0) {
            step = mesh.step_from(step);
            if (step.face == face) {
                return;
            }
            visit(step.face, step.at);
        }
    }
}

/// No face around the vertex, other than `face`, has `label`.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
no_label_around(const Patches& patches, int face, int corner, int label) {
    return walk_around(
        patches, face, corner, false, [&](int, int around) { return around != label; });
}

/// The vertex is not on an open border and all faces around it have `label`.
template <typename Patches>
SPHEROSEG_HOST_DEVICE bool
all_label_around(const Patches& patches, int face, int corner, int label) {
    return walk_around(
        patches, face, corner, true, [&](int, int around) { return around == label; });
}

} // namespace spheroseg
