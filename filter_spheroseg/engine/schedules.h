// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"
#include "budget.h"
#include "multilevel.h"

namespace spheroseg {

/// The annealings of `fast`.
struct Schedules {
    Budget budget;
    /// Are sub-meshes so small that fewer proposals per boundary face suffice?
    bool are_small = false;
    int thread_count = 0;
    /// The part of the proposals that is made.
    double share = 1.0;

    double first_proposals() const;
    /// Exchanges where there are so many boundary edges.
    double exchange_count(double boundary_edges) const;

    /// On the first level.
    AnnealSchedule first(std::uint64_t seed) const;
    /// On a further level.
    AnnealSchedule next(const AnnealSchedule& schedule) const;
    /// At exact balance, or below a limit.
    AnnealSchedule exchanges(const Patchwork& patchwork, std::uint64_t seed) const;
    /// Shakes boundaries with a strong pull towards balance.
    AnnealSchedule shaking(std::uint64_t seed) const;

private:
    double exchange_proposals() const;
};

/// Weights of the imbalance fall with the size of the sub-meshes, so that the part by which a
/// load may be off stays the same; a strength of 0.5 to 10 lets loads differ by some per cent.
void set_balance(AnnealSchedule& schedule, const Patchwork& patchwork, double begin, double end);

/// Anneals a patchwork on its level by `schedule`, and then on all finer ones up to the first with
/// at least `face_count` cells. `control_of(patchwork)` gives the control on each level. Returns
/// the last schedule.
template <typename ControlOf>
AnnealSchedule anneal_levels(Patchwork& patchwork,
                             const Multilevel& multilevel,
                             const Schedules& schedules,
                             AnnealSchedule schedule,
                             int face_count,
                             const ControlOf& control_of) {
    for (;;) {
        const bool is_finest = patchwork.face_count() == multilevel.face_count();
        if (is_finest) {
            schedule.temperature_end = 0.1;
        }
        set_balance(schedule, patchwork, 0.5, is_finest ? 10.0 : 1.5);
        anneal(patchwork, schedule, control_of(patchwork));
        if (is_finest || patchwork.face_count() >= face_count) {
            return schedule;
        }
        schedule = schedules.next(schedule);
        multilevel.uncoarsen(patchwork, schedule.thread_count);
    }
}

} // namespace spheroseg
