// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "trials.h"

namespace spheroseg {

/// How long the steps of a start take, roughly, in microseconds on two cores.
struct StartCost {
    /// The first labels.
    double start;
    /// The annealing of the levels.
    double levels;
    double exchanges;

    double sum() const { return start + levels + exchanges; }
    /// The part of the time after which a step has ended.
    double start_end() const { return start / sum(); }
    double levels_end() const { return (start + levels) / sum(); }
};

/// How `fast` goes about a component of `face_count` faces and k = `submesh_count`, in
/// [2, face_count]: where it starts, and how much it does.
class FastPlan {
public:
    /// `has_sphere`: can there be a map to the sphere?
    FastPlan(int face_count,
             int submesh_count,
             bool by_weight,
             bool has_sphere,
             Effort effort,
             int thread_count);

    /// For what is still to be done.
    void set_effort(Effort effort);
    const Schedules& schedules() const { return schedules_; }

    /// Do balanced sub-meshes have one or two faces? All such labels have as many boundary edges,
    /// so that every effort is a draft.
    bool are_single_or_pairs() const;

    /// How many starts are made, of which the best result is kept: several only where they differ
    /// in more than the seed, else a single one that takes as long is better; but by weight it is
    /// the balance that differs.
    int start_count() const { return start_count_; }
    /// Is the second start one on the sphere?
    bool starts_on_sphere() const { return start_count_ > 1 && !by_weight_; }

    /// The cells that the first level of a coarsened mesh has at least; the faces of another.
    int coarse_face_count() const;
    /// Is the mesh large enough for its sub-meshes to be started on a coarser one?
    bool coarsens() const;

    /// Takes note of the levels that there are in fact.
    void set_levels(const Multilevel& multilevel);

    /// Iterations of Lloyd's relaxation of a single start; more where the first level is so coarse
    /// that they take little of the time.
    int relaxations() const;
    /// How many starts are worth their time where the layout decides, at least 1.
    int trials() const;
    /// Of so many.
    TrialPlan trial_plan(int trials) const {
        return {trials, submesh_count_, first_face_count_, schedules_};
    }
    /// More than all annealings of a start have phases.
    int most_phases() const;
    /// Of a start that is the best of so many, or a single one.
    StartCost cost_of_start(int trials) const;
    /// Of the rounds after all starts, in microseconds too.
    double cost_of_rounds() const;

private:
    int coarse_face_count(std::int64_t faces_per_submesh) const;

    int face_count_;
    int submesh_count_;
    bool by_weight_;
    bool has_sphere_;
    int thread_count_;
    Schedules schedules_;
    int start_count_;
    /// 0 where there is only one level.
    int coarsest_face_count_ = 0;
    /// The faces of a level that undone subdivisions leave, where the start is on one; else 0.
    int quartered_face_count_ = 0;
    /// The least cells that the first level may have. As `coarse_face_count`; more where there is
    /// no level so coarse.
    int first_face_count_;
};

} // namespace spheroseg
