// SPDX-License-Identifier: GPL-3.0-or-later
#include "balance_search.h"

#include "balance.h"
#include "branch_annealing.h"
#include "bridge_bound.h"
#include "narrow_cut.h"
#include "recut.h"
#include "seeds.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// The greatest excess_share from which passing faces alone may balance.
constexpr double kNear = 0.1;
/// Times that it is tried again from where it got stuck.
constexpr int kTries = 6;
/// Starts in which branches pass, and the faces of a sub-mesh that is large enough for it.
constexpr int kStartsWithBranches = 2;
constexpr int kLargeSubmesh = 100;
/// Regions that are cut anew in all tries of the first start, per sub-mesh; in the n-th one an n-th
/// of that. Where that found a balance it rarely took more. Without any left there are no further
/// tries.
constexpr std::int64_t kMostCuts = 250;
/// Pairs of ways that are looked at where regions are cut as a whole, per face of the mesh, in all
/// tries.
constexpr std::int64_t kMostNarrowWork = 3000;
/// Faces that are looked at to balance initial labels, per face of the mesh. Where they were near
/// to it 4 sufficed; from random labels of 300,000 faces it took 40 to 600, more time than another
/// start, whose boundaries were 4 to 5 % shorter.
constexpr std::int64_t kWorkOnInitialLabels = 20;

} // namespace

BalanceSearch::BalanceSearch(Patchwork& patchwork,
                             const Schedules& schedules,
                             std::uint64_t seed,
                             int start,
                             const Deadline& deadline,
                             const Progress& progress)
    : patchwork_(patchwork), schedules_(schedules), seed_(seed), start_(start), deadline_(deadline),
      progress_(progress), cuts_left_(kMostCuts * patchwork.submesh_count() / (start + 1)),
      narrow_work_left_(kMostNarrowWork * patchwork.face_count() / (start + 1)) {}

bool BalanceSearch::pass_faces() {
    return excess_share(patchwork_) <= kNear && balance_exactly(patchwork_, &deadline_, progress_);
}

void BalanceSearch::pass_branches(const Deadline& limit) {
    if (are_large() && start_ < kStartsWithBranches && is_stuck(patchwork_)) {
        anneal_branches(patchwork_,
                        schedules_.branches(patchwork_, seed_ + seed_offset::kBranches),
                        &limit,
                        progress_);
    }
}

bool BalanceSearch::balance_initial_labels() {
    const std::int64_t most_work = kWorkOnInitialLabels * patchwork_.face_count();
    return excess_share(patchwork_) <= kNear &&
        (balance_exactly(patchwork_, &deadline_, progress_, most_work) ||
         (!spheroseg::is_hopeless(patchwork_) && recut(TreeTurns::random)));
}

bool BalanceSearch::search() {
    // Trees along walls would make the boundaries of large sub-meshes long: they are the second
    // resort, with half of the cuts.
    const std::int64_t cuts_kept = are_large() ? cuts_left_ / 2 : 0;
    cuts_left_ -= cuts_kept;
    bool balanced = pass_or_recut(TreeTurns::random);
    cuts_left_ = std::max<std::int64_t>(cuts_left_, 0) + cuts_kept;
    is_hopeless_ = spheroseg::is_hopeless(patchwork_);
    for (int i = 0; i < kTries && !balanced && !is_least() && !is_hopeless_ && cuts_left_ > 0 &&
         !deadline_.expired();
         ++i) {
        // With a strong pull towards balance, whatever the time limit.
        const AnnealSchedule schedule =
            schedules_.shaking(seed_ + seed_offset::kShaking + static_cast<std::uint64_t>(i));
        AnnealControl control;
        control.progress = progress_;
        anneal(patchwork_, schedule, control);
        balanced = pass_or_recut(TreeTurns::often_along_walls) ||
            (!is_least() && !spheroseg::is_hopeless(patchwork_) &&
             cut_narrow_regions(patchwork_, narrow_work_left_, &deadline_, progress_));
    }
    return balanced;
}

bool BalanceSearch::are_large() const {
    return mean_load(patchwork_) >= kLargeSubmesh;
}

bool BalanceSearch::pass_or_recut(TreeTurns turns) {
    if (balance_exactly(patchwork_, &deadline_, progress_)) {
        return true;
    }
    if (!least_misplaced_) {
        least_misplaced_ = least_misplaced(patchwork_, even_loads(patchwork_));
    }
    return recut(turns);
}

bool BalanceSearch::is_least() const {
    return !is_possible() && misplaced(patchwork_) <= *least_misplaced_;
}

bool BalanceSearch::recut(TreeTurns turns) {
    return recut_to_balance(
        patchwork_, cuts_left_, turns, &deadline_, progress_, least_misplaced_.value_or(0));
}

} // namespace spheroseg
