// SPDX-License-Identifier: GPL-3.0-or-later
#include "best_result.h"

#include "boundary.h"
#include "weight_balance.h"

#include <algorithm>
#include <tuple>

namespace spheroseg {

bool BestResult::Cost::operator<(const Cost& other) const {
    return std::tie(is_unsound, misplaced, excess, boundary_edges) <
        std::tie(other.is_unsound, other.misplaced, other.excess, other.boundary_edges);
}

bool BestResult::keep_if_better(const Patchwork& patchwork, bool sound, const History& history) {
    const Cost cost = cost_of(patchwork, sound);
    if (!least_cost_ || cost < *least_cost_) {
        least_cost_ = cost;
        labels_ = multilevel_.labels(patchwork);
        history_ = history;
    }
    return cost.is_valid();
}

BestResult::Cost BestResult::cost_of(const Patchwork& patchwork, bool sound) const {
    Cost cost = {!sound, 0, 0, count_boundary_edges(patchwork, thread_count_)};
    if (!task_.weights.empty()) {
        const int excess = std::max(0, heaviest_load(patchwork) - near_enough(patchwork));
        const int unit = std::max(1, multilevel_.total_weight() / task_.submesh_count / 1000);
        cost.excess = (std::int64_t{excess} + unit - 1) / unit;
    } else {
        for (int load : patchwork.load) {
            cost.misplaced += task_.counts.deviation(load);
        }
    }
    return cost;
}

} // namespace spheroseg
