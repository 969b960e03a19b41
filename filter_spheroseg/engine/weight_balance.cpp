// SPDX-License-Identifier: GPL-3.0-or-later
#include "weight_balance.h"

#include "load_lowering.h"
#include "schedules.h"
#include "seeds.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// Steps above the mean, and tries to get below the last one that was missed.
constexpr double kSteps[] = {0.03, 0.01, 0.003, 0.001};
constexpr int kStepCount = 4;
constexpr int kHalvings = 2;

/// The descent of balance_by_weight.
class WeightBalance {
public:
    WeightBalance(Patchwork& patchwork,
                  const AnnealSchedule& exchanges,
                  const AnnealControl& control,
                  const Deadline* first_deadline)
        : patchwork_(patchwork), exchanges_(exchanges), control_(control),
          first_deadline_(first_deadline), mean_(mean_load(patchwork)), best_(patchwork),
          least_(patchwork) {
        exchanges_.proposals_per_face /= kStepCount;
        exchanges_.phase_count = std::max(1, exchanges_.phase_count / kStepCount);
    }

    void run() {
        double missed = -1.0;
        double reached = heaviest_load(patchwork_) / mean_ - 1.0;
        const auto note = [&](double above_mean, int step) {
            if (reach(above_mean, step)) {
                reached = above_mean;
            } else {
                missed = above_mean;
            }
        };
        for (int i = 0; i < kStepCount && missed < 0.0 && (i == 0 || !expired()); ++i) {
            note(kSteps[i], i);
        }
        for (int i = 0; i < kHalvings && missed >= 0.0 && reached > missed && !expired(); ++i) {
            note(0.5 * (reached + missed), kStepCount);
        }
        patchwork_ = best_;
        const int least = heaviest_load(least_);
        if (least < heaviest_load(best_) && heaviest_load(best_) > near_enough(best_)) {
            // Exchanges have raised the load again, up to a limit that was kept.
            patchwork_ = least_;
            is_exchanged_ = false;
        }
        // What lowering alone has reached has a long boundary.
        if (!is_exchanged_ && !expired()) {
            exchange_below(heaviest_load(patchwork_), kStepCount);
        }
    }

private:
    /// True when all loads came to at most so much above the mean.
    bool reach(double above_mean, int step) {
        const int limit = static_cast<int>(mean_ * (1.0 + above_mean));
        const Progress progress = sub_progress(control_.progress, begin_of(step), begin_of(step));
        const Deadline* const deadline = step == 0 ? first_deadline_ : control_.deadline;
        patchwork_ = best_;
        bool below = lower_loads(patchwork_, limit, deadline, progress);
        keep_best();
        if (!below && !expired()) {
            shake(progress);
            below = lower_loads(patchwork_, limit, control_.deadline, progress);
            keep_best();
        }
        if (below && !expired()) {
            exchange_below(limit, step);
        }
        return below;
    }

    /// What comes of it is the best.
    void exchange_below(int limit, int step) {
        AnnealControl control = control_;
        control.progress = sub_progress(control_.progress, begin_of(step), begin_of(step + 1));
        ++exchanges_.seed;
        anneal_below(patchwork_, limit, exchanges_, control);
        control_.max_phases = std::max(0, control_.max_phases - exchanges_.phase_count);
        best_ = patchwork_;
        is_exchanged_ = true;
    }

    /// The part of the progress after which a step begins.
    static double begin_of(int step) { return step / (kStepCount + 1.0); }

    /// Anneals with a pull towards the mean that is hundreds of boundary edges strong where a load
    /// is off by as much as the mean.
    void shake(const Progress& progress) {
        AnnealSchedule schedule = exchanges_;
        schedule.seed = exchanges_.seed + seed_offset::kShaking;
        schedule.temperature_begin = 0.5;
        schedule.temperature_end = 0.2;
        set_balance(schedule, patchwork_, 5.0, 100.0);
        schedule.proposals_per_face = 100.0;
        schedule.phase_count = 12;
        AnnealControl control;
        control.deadline = control_.deadline;
        control.progress = progress;
        control.device = control_.device;
        anneal(patchwork_, schedule, control);
    }

    void keep_best() {
        if (heaviest_load(patchwork_) < heaviest_load(best_)) {
            best_ = patchwork_;
            is_exchanged_ = false;
        }
        if (heaviest_load(patchwork_) < heaviest_load(least_)) {
            least_ = patchwork_;
        }
    }

    bool expired() const { return control_.deadline && control_.deadline->expired(); }

    Patchwork& patchwork_;
    AnnealSchedule exchanges_;
    /// With the phases that are left of those allowed.
    AnnealControl control_;
    /// Of the first step.
    const Deadline* const first_deadline_;
    const double mean_;
    /// What the next step begins with, and what has the least heaviest load so far.
    Patchwork best_;
    Patchwork least_;
    /// `best_` comes from exchanges.
    bool is_exchanged_ = true;
};

} // namespace

int heaviest_load(const Patchwork& patchwork) {
    return *std::max_element(patchwork.load.begin(), patchwork.load.end());
}

int near_enough(const Patchwork& patchwork) {
    return static_cast<int>(mean_load(patchwork) * (1.0 + kSteps[kStepCount - 1]));
}

void balance_by_weight(Patchwork& patchwork,
                       const AnnealSchedule& exchanges,
                       const AnnealControl& control,
                       const Deadline* first_deadline) {
    if (patchwork.submesh_count() > 1) {
        WeightBalance(patchwork, exchanges, control, first_deadline).run();
    }
}

} // namespace spheroseg
