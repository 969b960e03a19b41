// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"
#include "schedules.h"
#include "tree_cut.h"

#include <cstdint>
#include <optional>

namespace spheroseg {

/// The ways from annealed sub-meshes of unit weights to exact balance, for one start of `fast`. All
/// leave the sub-meshes connected and free of bowties; those that return a bool return whether the
/// loads differ by at most one. They end when `deadline` has expired, and are deterministic but for
/// that. Throws Cancelled when the progress callback asks for it. The arguments of the constructor
/// must outlive the object.
class BalanceSearch {
public:
    /// `start`: which start of `fast` this is, from 0 on; later ones make fewer cuts.
    BalanceSearch(Patchwork& patchwork,
                  const Schedules& schedules,
                  std::uint64_t seed,
                  int start,
                  const Deadline& deadline,
                  const Progress& progress);

    /// balance_exactly alone, and only where the loads are near to balance: for a start that the
    /// time limit has cut short.
    bool pass_faces();
    /// anneal_branches where annealing is stuck, in the first starts and where sub-meshes are
    /// large: there the boundaries that recuts make would be long. Slow; ends early when `limit`
    /// has expired.
    void pass_branches(const Deadline& limit);
    /// balance_exactly and recut_to_balance, with limits: beyond them another start takes less
    /// time.
    bool balance_initial_labels();
    /// balance_exactly and recut_to_balance, several times; in between, boundaries are annealed
    /// with a strong pull towards balance. From the second time on recuts also follow walls, and
    /// cut_narrow_regions comes after them.
    bool search();
    /// False where `search` found that no cut of these faces is balanced (least_misplaced).
    bool is_possible() const { return least_misplaced_.value_or(0) == 0; }
    /// Did it find that, and a cut with as few faces too many or too few as can be?
    bool is_least() const;
    /// Did `search` leave so many sub-meshes out of balance that only another kind of start is
    /// worth a try?
    bool is_hopeless() const { return is_hopeless_; }

private:
    bool are_large() const;
    bool pass_or_recut(TreeTurns turns);
    bool recut(TreeTurns turns);

    Patchwork& patchwork_;
    const Schedules& schedules_;
    const std::uint64_t seed_;
    const int start_;
    const Deadline& deadline_;
    const Progress& progress_;
    std::int64_t cuts_left_;
    std::int64_t narrow_work_left_;
    /// Once it is needed.
    std::optional<std::int64_t> least_misplaced_;
    bool is_hopeless_ = false;
};

} // namespace spheroseg
