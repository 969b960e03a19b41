// SPDX-License-Identifier: GPL-3.0-or-later
#include "planned_chain.h"

#include <algorithm>
#include <utility>

namespace spheroseg {

bool PlannedChain::find(int label, bool outward, std::int64_t max_work) {
    passes_.clear();
    searches_ = 0;
    work_ = 0;
    goal_ = -1;
    plan_from(label, outward, -1);
    for (std::size_t head = 0; head < passes_.size() && work_ < max_work; ++head) {
        const Move move = passes_[head].move;
        const int at = outward ? move.to : move.from;
        if (even_.room(patchwork_.load[at], outward) > 0) {
            goal_ = static_cast<int>(head);
            break;
        }
        Move back = move;
        std::swap(back.from, back.to);
        boundaries_.commit(move);
        plan_from(at, outward, static_cast<int>(head));
        boundaries_.commit(back);
    }
    for (const Pass& pass : passes_) {
        is_planned_[3 * pass.move.faces[0] + pass.corner] = 0;
    }
    return goal_ >= 0;
}

/// Plans every allowed pass out of (or into) a sub-mesh that is not planned yet.
void PlannedChain::plan_from(int label, bool outward, int previous) {
    ++searches_;
    work_ += boundaries_.listed_count(label);
    sides_.clear();
    boundaries_.for_each_side(label, [&](int face, int c, int) {
        sides_.push_back(passing_side(patchwork_, face, c, outward));
    });
    const std::size_t count = sides_.size();
    for (std::size_t i = 0; i < count; ++i) {
        const Side& side = sides_[(i + turn_) % count];
        std::uint8_t& is_planned = is_planned_[3 * side.face + side.corner];
        Move move;
        if (!is_planned && is_allowed(side, move) &&
            !is_on_chain(outward ? move.to : move.from, side.face, previous)) {
            is_planned = 1;
            passes_.push_back({move, side.corner, previous});
        }
    }
}

/// A chain that ends with the pass `last` has met the sub-mesh or moved the face already.
bool PlannedChain::is_on_chain(int label, int face, int last) const {
    for (int i = last; i >= 0; i = passes_[i].previous) {
        const Move& move = passes_[i].move;
        if (move.faces[0] == face || move.from == label || move.to == label) {
            return true;
        }
    }
    return false;
}

bool PlannedChain::make() {
    std::vector<int> chain;
    for (int i = goal_; i >= 0; i = passes_[i].previous) {
        chain.push_back(i);
    }
    for (auto i = chain.rbegin(); i != chain.rend(); ++i) {
        const Pass& pass = passes_[*i];
        Move move;
        if (!is_allowed({pass.move.faces[0], pass.corner}, move) || move.from != pass.move.from ||
            move.to != pass.move.to) {
            return i != chain.rbegin();
        }
        boundaries_.commit(move);
    }
    return true;
}

} // namespace spheroseg
