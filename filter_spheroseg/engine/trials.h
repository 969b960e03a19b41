// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "history.h"
#include "multilevel.h"
#include "schedules.h"

namespace spheroseg {

/// One of several starts that compete where there are few sub-meshes: then their layout decides how
/// long the boundaries will be, and another try costs little.
struct Trial {
    Patchwork patchwork;
    /// The schedule of its last annealing.
    AnnealSchedule schedule;
    History history;
};

/// How many trials to make, and of what.
struct TrialPlan {
    /// At least 1.
    int count;
    int submesh_count;
    /// The least cells of the level that they begin on.
    int first_face_count;
    Schedules schedules;
};

/// How many trials are worth their time, at least 1, where the first level has so many cells.
int trial_count(const Budget& budget, int first_face_count);

/// What trials cost, in proposals that one thread makes one after the other, roughly.
struct TrialWork {
    /// Of making all trials.
    double making;
    /// Of annealing the best ones further.
    double finishing;
    /// The cells of the level that the best one ends on.
    int face_count;

    double proposals() const { return making + finishing; }
};

/// The work of `plan` on a mesh with `face_count` faces.
TrialWork trial_work(const TrialPlan& plan, int face_count);

/// Makes `plan.count` trials on the coarsest level with at least `plan.first_face_count` cells, and
/// anneals them up to a level on which edges are about equally long, so that boundaries can be
/// compared. The best ones are annealed on some finer levels, or up to the finest of a small mesh.
/// Returns the one with the shortest boundary, annealed on its level.
///
/// Trials begin with bisection and relaxation, but for one of every four: that one is bisected step
/// by step with an annealing after each step, which finds rings. Another one of the four is
/// annealed without regard to connectedness first (anneal_freely), so that boundaries can get into
/// holes and handles. Trials run side by side; the result does not depend on the number of threads.
/// When `deadline` has expired, no further ones are begun. Throws Cancelled.
Trial best_of_trials(const Multilevel& multilevel,
                     const TrialPlan& plan,
                     std::uint64_t seed,
                     const Deadline& deadline,
                     const Progress& progress);

} // namespace spheroseg
