// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "progress.h"

#include <algorithm>
#include <optional>

namespace spheroseg {

/// Until when the steps of `fast` may work on a component. The time limit cuts the annealing short;
/// what would make the result worthless without it gets time of its own.
class FastDeadlines {
public:
    /// `limit`: the time limit; must outlive this object.
    explicit FastDeadlines(const Deadline& limit) : limit_(limit), search_(limit.for_searches()) {}

    /// Is the time up?
    bool expired() const { return limit_.expired(); }

    /// Lifts the limit: starts are made as `draft` makes them from now on, because the time is up
    /// and there is no valid result. What is cut short can not be balanced.
    void hurry() {
        is_hurried_ = true;
        hurry_watch_.emplace();
    }
    bool is_hurried() const { return is_hurried_; }

    /// Of the steps of a start.
    const Deadline& of_start() const { return is_hurried_ ? unlimited_ : limit_; }

    /// Of searches for a balance.
    const Deadline& of_search() const { return search_; }

    /// To be called before a search. In a hurry it leaves time for it, whatever the limit is: as
    /// much as goes with the time that it took so far, for that and all later searches.
    void extend_search() {
        if (hurry_watch_) {
            search_ = Deadline(
                std::max(search_.left_seconds(), kOverDraft * hurry_watch_->elapsed_seconds()));
            hurry_watch_.reset();
        }
    }

    /// Of the first step of a balance by weight, after a start of so many seconds.
    Deadline of_lowering(double start_seconds) const {
        return Deadline(is_hurried_
                            ? kOverDraft * start_seconds
                            : std::max(limit_.left_seconds(), kLoweringOverStart * start_seconds));
    }

private:
    /// Seconds for the search for a balance, whatever the time limit is, per second of a start that
    /// is made in a hurry.
    static constexpr double kOverDraft = 10.0;
    /// The same for the first step of a balance by weight after any other start. On ordinary meshes
    /// it takes up to 1.6 times all that went before it, levels included.
    static constexpr double kLoweringOverStart = 2.0;

    const Deadline& limit_;
    const Deadline unlimited_;
    Deadline search_;
    bool is_hurried_ = false;
    /// Since then, until a balance is searched for.
    std::optional<StopWatch> hurry_watch_;
};

} // namespace spheroseg
