// SPDX-License-Identifier: GPL-3.0-or-later
#include "planned_chains.h"

#include <utility>

namespace spheroseg {

void PlannedChains::follow(bool outward, Random& random, const Report& report) {
    turn_ = random.next();
    std::vector<int> labels;
    for (int l = 0; l < patchwork_.submesh_count(); ++l) {
        if (even_.room(patchwork_.load[l], outward) < 0) {
            labels.push_back(l);
        }
    }
    find(labels, outward, report);
    for (int end : ends_) {
        make(end);
    }
}

void PlannedChains::find(const std::vector<int>& labels, bool outward, const Report& report) {
    passes_.clear();
    ends_.clear();
    work_ = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
        plan_from(labels[i], outward, -1, static_cast<int>(i));
    }
    std::vector<std::uint8_t> is_found(labels.size(), 0);
    const auto end_of = [outward](const Pass& pass) { return outward ? pass.to : pass.from; };
    for (std::size_t head = 0;
         head < passes_.size() && ends_.size() < labels.size() && report(std::exchange(work_, 0));
         ++head) {
        const Pass pass = passes_[head];
        const int at = end_of(pass);
        if (is_found[pass.begin]) {
            continue;
        }
        if (even_.room(patchwork_.load[at], outward) > promised_[at]) {
            ++promised_[at];
            is_found[pass.begin] = 1;
            ends_.push_back(static_cast<int>(head));
        } else {
            boundaries_.pass(pass.side.face, pass.from, pass.to);
            plan_from(at, outward, static_cast<int>(head), pass.begin);
            boundaries_.pass(pass.side.face, pass.to, pass.from);
        }
    }
    forget();
}

/// Leaves no marks of the search, but its result.
void PlannedChains::forget() {
    for (const Pass& pass : passes_) {
        is_planned_[3 * pass.side.face + pass.side.corner] = 0;
        promised_[pass.from] = 0;
        promised_[pass.to] = 0;
    }
}

/// Plans every allowed pass out of (or into) a sub-mesh that is not planned yet; not of the face of
/// the pass before it, which is made only while this is planned.
void PlannedChains::plan_from(int label, bool outward, int previous, int begin) {
    work_ += boundaries_.listed_count(label);
    sides_.clear();
    boundaries_.for_each_side(label, [&](int face, int c, int) {
        sides_.push_back(passing_side(patchwork_, face, c, outward));
    });
    const int last_face = previous < 0 ? -1 : passes_[previous].side.face;
    const std::size_t count = sides_.size();
    for (std::size_t i = 0; i < count; ++i) {
        const SubmeshSide& side = sides_[(i + turn_) % count];
        std::uint8_t& is_planned = is_planned_[3 * side.face + side.corner];
        Move move;
        if (!is_planned && side.face != last_face && is_allowed_pass(patchwork_, side, move)) {
            is_planned = 1;
            passes_.push_back({side, move.from, move.to, previous, begin});
        }
    }
}

/// Makes the passes of the chain that ends with this one, as far as they are still allowed.
void PlannedChains::make(int last) {
    std::vector<int> chain;
    for (int i = last; i >= 0; i = passes_[i].previous) {
        chain.push_back(i);
    }
    for (auto i = chain.rbegin(); i != chain.rend(); ++i) {
        const Pass& pass = passes_[*i];
        Move move;
        if (!is_allowed_pass(patchwork_, pass.side, move) || move.from != pass.from ||
            move.to != pass.to) {
            return;
        }
        boundaries_.commit(move);
    }
}

} // namespace spheroseg
