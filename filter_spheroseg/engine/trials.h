// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "history.h"
#include "schedules.h"

namespace spheroseg {

/// A start with few sub-meshes: their layout decides how long the boundaries will be, and to try
/// another one costs little.
struct Trial {
    Patchwork patchwork;
    /// Its last annealing.
    AnnealSchedule schedule;
    History history;
};

/// What trials are to be made.
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
    /// Making all of them, and going on with the best.
    double making;
    double finishing;
    /// The cells of the level that the best one reaches.
    int face_count;

    double proposals() const { return making + finishing; }
};

/// On a mesh with so many faces.
TrialWork trial_work(const TrialPlan& plan, int face_count);

/// Makes `plan.count` trials on the coarsest level with at least `plan.first_face_count` cells and
/// anneals them up to a level where edges are about equally long; those with the shortest
/// boundaries go on for some levels, or to the end of a small mesh. Returns the best one, annealed
/// on its level. Of every four trials one is annealed without a care for connectedness first, so
/// that boundaries can begin to pass through holes and handles, and one is cut in two again and
/// again with an annealing after each cut, which finds rings. They are worked on side by side; the
/// result does not depend on the number of threads. When the time is up, fewer are made. Throws
/// Cancelled.
Trial best_of_trials(const Multilevel& multilevel,
                     const TrialPlan& plan,
                     std::uint64_t seed,
                     const Deadline& deadline,
                     const Progress& progress);

} // namespace spheroseg
