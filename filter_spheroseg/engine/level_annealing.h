// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "multilevel.h"
#include "schedules.h"

#include <algorithm>

namespace spheroseg {

/// Turns a patchwork into that of the next finer level, if there is one, and repairs it where holes
/// open, or where it could not be repaired before.
void uncoarsen(Patchwork& patchwork, const Multilevel& multilevel, int thread_count);

/// Anneals a patchwork on its level by `schedule`, and then on all finer ones up to the first with
/// at least `face_count` cells, where the balance weighs `last_balance` in the end (10 on the
/// finest one). `control_of(begin, end)` gives the control on a level that takes this part of the
/// time, where levels of up to `done_faces` cells were annealed before. Returns the last schedule.
template <typename ControlOf>
AnnealSchedule anneal_levels(Patchwork& patchwork,
                             const Multilevel& multilevel,
                             const Schedules& schedules,
                             AnnealSchedule schedule,
                             int face_count,
                             const ControlOf& control_of,
                             int done_faces = 0,
                             double last_balance = 1.5) {
    const auto work_up_to = [&](int cells) {
        return schedules.level_work(cells, patchwork.submesh_count());
    };
    const double done = work_up_to(done_faces);
    const double all = work_up_to(std::min(face_count, multilevel.face_count()));
    double begin = 0.0;
    for (;;) {
        const bool is_finest = patchwork.face_count() == multilevel.face_count();
        const bool is_last = is_finest || patchwork.face_count() >= face_count;
        const double end =
            is_last ? 1.0 : (work_up_to(patchwork.face_count()) - done) / (all - done);
        if (is_finest) {
            schedule.temperature_end = 0.1;
        }
        set_balance(schedule, patchwork, 0.5, is_finest ? 10.0 : is_last ? last_balance : 1.5);
        anneal(patchwork, schedule, control_of(begin, end));
        if (is_last) {
            return schedule;
        }
        begin = end;
        uncoarsen(patchwork, multilevel, schedules.thread_count);
        schedule = schedules.next(schedule, patchwork);
    }
}

/// The same from the next finer level on, or once more on the finest, after an annealing by
/// `schedule`.
template <typename ControlOf>
AnnealSchedule anneal_further_levels(Patchwork& patchwork,
                                     const Multilevel& multilevel,
                                     const Schedules& schedules,
                                     const AnnealSchedule& schedule,
                                     int face_count,
                                     const ControlOf& control_of,
                                     double last_balance = 1.5) {
    const int done_faces = patchwork.face_count();
    uncoarsen(patchwork, multilevel, schedules.thread_count);
    return anneal_levels(patchwork,
                         multilevel,
                         schedules,
                         schedules.next(schedule, patchwork),
                         face_count,
                         control_of,
                         done_faces,
                         last_balance);
}

} // namespace spheroseg
