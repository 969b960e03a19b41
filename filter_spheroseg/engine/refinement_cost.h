// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

namespace spheroseg {

/// Labels as they would be if two faces exchanged theirs.
class SwappedLabels {
public:
    /// `labels` must outlive this. With a == b nothing is exchanged.
    SwappedLabels(const std::vector<int>& labels, int a, int b) : labels_(labels), a_(a), b_(b) {}

    int operator[](int face) const { return labels_[face == a_ ? b_ : face == b_ ? a_ : face]; }

private:
    const std::vector<int>& labels_;
    int a_;
    int b_;
};

/// Algorithm 4: neighbours of `face` that are not in sub-mesh `submesh`.
template <typename Labels>
int boundary_side_count(const DualGraph& dual_graph, const Labels& labels, int face, int submesh) {
    int count = 0;
    for (int neighbor : dual_graph.neighbors[face]) {
        count += neighbor >= 0 && labels[neighbor] != submesh;
    }
    return count;
}

/// Eq. 1: the square of the sides of `face` on the boundary of `submesh`, plus that of each of its
/// neighbours in `submesh`.
template <typename Labels>
int refinement_cost(const DualGraph& dual_graph, const Labels& labels, int face, int submesh) {
    const int own = boundary_side_count(dual_graph, labels, face, submesh);
    int cost = own * own;
    for (int neighbor : dual_graph.neighbors[face]) {
        if (neighbor >= 0 && labels[neighbor] == submesh) {
            const int sides = boundary_side_count(dual_graph, labels, neighbor, submesh);
            cost += sides * sides;
        }
    }
    return cost;
}

/// e1 + e2 - e3 - e4 of Algorithm 3 with e3 and e4 evaluated on the labels after the swap: by how
/// much the cost of Eq. 1 of the two faces falls when they exchange labels.
inline int swap_gain(const DualGraph& dual_graph, const std::vector<int>& labels, int a, int b) {
    const int label_a = labels[a];
    const int label_b = labels[b];
    const SwappedLabels swapped(labels, a, b);
    return refinement_cost(dual_graph, labels, a, label_a) +
        refinement_cost(dual_graph, labels, b, label_b) -
        refinement_cost(dual_graph, swapped, a, label_b) -
        refinement_cost(dual_graph, swapped, b, label_a);
}

} // namespace spheroseg
