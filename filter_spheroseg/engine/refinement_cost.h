// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// What refinement decides, written once for the cores and for a GPU. `Neighbors` is a DualGraph or
// its neighbours in one array, three per face; `Labels` is an array of labels, one per face, or
// ExchangedLabels. All is O(1).

#include "dual_graph.h"
#include "host_device.h"

namespace spheroseg {

inline int neighbor_of(const DualGraph& dual_graph, int face, int side) {
    return dual_graph.neighbors[face][side];
}
SPHEROSEG_HOST_DEVICE inline int neighbor_of(const int* neighbors, int face, int side) {
    return neighbors[3 * face + side];
}

/// Labels as they would be if the faces `a` and `b` exchanged theirs; `labels` must outlive this.
struct ExchangedLabels {
    const int* labels;
    int a;
    int b;

    SPHEROSEG_HOST_DEVICE int operator[](int face) const {
        return labels[face == a ? b : face == b ? a : face];
    }
};

/// Algorithm 4: neighbours of `face` that are not in sub-mesh `submesh`.
template <typename Neighbors, typename Labels>
SPHEROSEG_HOST_DEVICE int
boundary_side_count(const Neighbors& neighbors, const Labels& labels, int face, int submesh) {
    int count = 0;
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbor_of(neighbors, face, side);
        count += neighbor >= 0 && labels[neighbor] != submesh;
    }
    return count;
}

/// Eq. 1: the square of the sides of `face` on the boundary of `submesh`, plus that of each of its
/// neighbours in `submesh`. With `face_joins`, as if it alone had the label `submesh`, which is not
/// its own.
template <typename Neighbors, typename Labels>
SPHEROSEG_HOST_DEVICE int refinement_cost(const Neighbors& neighbors,
                                          const Labels& labels,
                                          int face,
                                          int submesh,
                                          bool face_joins = false) {
    const int own = boundary_side_count(neighbors, labels, face, submesh);
    int cost = own * own;
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbor_of(neighbors, face, side);
        if (neighbor >= 0 && labels[neighbor] == submesh) {
            const int sides =
                boundary_side_count(neighbors, labels, neighbor, submesh) - (face_joins ? 1 : 0);
            cost += sides * sides;
        }
    }
    return cost;
}

/// e1 + e2 - e3 - e4 of Algorithm 3 with e3 and e4 evaluated on the labels after the swap: by how
/// much the cost of Eq. 1 of the two faces falls when they exchange labels.
template <typename Neighbors>
SPHEROSEG_HOST_DEVICE int swap_gain(const Neighbors& neighbors, const int* labels, int a, int b) {
    const int label_a = labels[a];
    const int label_b = labels[b];
    const ExchangedLabels swapped{labels, a, b};
    return refinement_cost(neighbors, labels, a, label_a) +
        refinement_cost(neighbors, labels, b, label_b) -
        refinement_cost(neighbors, swapped, a, label_b) -
        refinement_cost(neighbors, swapped, b, label_a);
}

/// Is a neighbour of `face`, which has three, in sub-mesh `submesh`?
template <typename Neighbors>
SPHEROSEG_HOST_DEVICE bool
touches(const Neighbors& neighbors, const int* labels, int face, int submesh) {
    return labels[neighbor_of(neighbors, face, 0)] == submesh ||
        labels[neighbor_of(neighbors, face, 1)] == submesh ||
        labels[neighbor_of(neighbors, face, 2)] == submesh;
}

/// Algorithm 3: do the faces swap? Where neither has a neighbour with the other's label, both would
/// get the greatest cost that there is.
template <typename Neighbors>
SPHEROSEG_HOST_DEVICE bool swaps(const Neighbors& neighbors, const int* labels, int a, int b) {
    return labels[a] != labels[b] &&
        (touches(neighbors, labels, a, labels[b]) || touches(neighbors, labels, b, labels[a])) &&
        swap_gain(neighbors, labels, a, b) > 0;
}

using GainBound = signed char;
/// Eq. 1 of a face with a label that none of its three neighbours has. No face on a boundary can
/// have more: with one boundary side 1 + 4 + 4, with two 4 + 4, with three 9.
constexpr int kStrangerCost = 9;
/// Of faces that take no part: sums with any other bound stay negative, and within a byte.
constexpr GainBound kNoCandidate = -64;

/// The most by which Eq. 1 of a face can fall in any swap. Its partner brings the label of one of
/// its neighbours, or one that none of them has. A partner that is not itself a neighbour can only
/// take faces of that label away from around it, which raises the cost; a partner that is a
/// neighbour is tried as it is. Two faces whose bounds sum to 0 or less do not swap.
template <typename Neighbors>
SPHEROSEG_HOST_DEVICE GainBound gain_bound(const Neighbors& neighbors,
                                           const int* labels,
                                           int face) {
    const int label = labels[face];
    if (boundary_side_count(neighbors, labels, face, label) == 0) {
        return kNoCandidate;
    }
    int least = kStrangerCost;
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbor_of(neighbors, face, side);
        if (neighbor < 0 || labels[neighbor] == label) {
            continue;
        }
        const int other = labels[neighbor];
        const ExchangedLabels swapped{labels, face, neighbor};
        const int joined = refinement_cost(neighbors, labels, face, other, true);
        const int exchanged = refinement_cost(neighbors, swapped, face, other);
        least = joined < least ? joined : least;
        least = exchanged < least ? exchanged : least;
    }
    return static_cast<GainBound>(refinement_cost(neighbors, labels, face, label) - least);
}

/// Calls visit(f) for the face and all faces within two steps of it, for some more than once.
template <typename Neighbors, typename Visit>
SPHEROSEG_HOST_DEVICE void
visit_within_two_steps(const Neighbors& neighbors, int face, const Visit& visit) {
    visit(face);
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbor_of(neighbors, face, side);
        if (neighbor < 0) {
            continue;
        }
        visit(neighbor);
        for (int next_side = 0; next_side < 3; ++next_side) {
            const int next = neighbor_of(neighbors, neighbor, next_side);
            if (next >= 0) {
                visit(next);
            }
        }
    }
}

} // namespace spheroseg
