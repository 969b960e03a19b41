// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "progress.h"
#include "schedules.h"

#include <cstdint>

namespace spheroseg {

/// The ways from annealed sub-meshes of unit weights to exact balance, for one start of `fast`. All
/// leave the sub-meshes connected and free of bowties, and return whether the loads differ by at
/// most one then. Searches end when `deadline` has expired; deterministic but for that. They throw
/// Cancelled when the progress callback asks for it. All that is referred to must outlive it.
class BalanceSearch {
public:
    /// `start`: 0 for the first one; later ones may make fewer recuts.
    BalanceSearch(Patchwork& patchwork,
                  const Schedules& schedules,
                  std::uint64_t seed,
                  int start,
                  const Deadline& deadline,
                  const Progress& progress);

    /// Passes faces, where the loads are near to balance: for what was cut short.
    bool pass_faces();
    /// In the first starts: passes whole branches where annealing is stuck, and sub-meshes are so
    /// large that the boundaries of recuts would be long. It takes long; ends early when `limit`
    /// has expired.
    void pass_branches(const Deadline& limit);
    /// As far as another start would not take less time.
    bool balance_initial_labels();
    /// Passes faces and cuts regions anew; to try both again, in the first starts passes whole
    /// branches of large sub-meshes in every other try, and else shakes the boundaries.
    bool search();
    /// Did `search` leave so much off that only another kind of start is worth a try?
    bool is_hopeless() const { return is_hopeless_; }

private:
    bool may_pass_branches() const;
    void pass_branches_until(const Deadline& limit, std::uint64_t seed);
    void shake(std::uint64_t seed);
    bool pass_or_recut();
    bool recut();

    Patchwork& patchwork_;
    const Schedules& schedules_;
    const std::uint64_t seed_;
    const int start_;
    const Deadline& deadline_;
    const Progress& progress_;
    std::int64_t cuts_left_;
    bool is_hopeless_ = false;
};

} // namespace spheroseg
