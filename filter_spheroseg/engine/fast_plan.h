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

/// What `fast` does with a component of `face_count` faces and k = `submesh_count`, in
/// [2, face_count]: on which level it starts, how many starts and trials it makes, and what they
/// cost. Set up with the faces alone, and made exact by `set_levels`.
class FastPlan {
public:
    /// `has_sphere`: can the mesh be mapped to the sphere?
    FastPlan(int face_count,
             int submesh_count,
             bool by_weight,
             bool has_sphere,
             Effort effort,
             int thread_count);

    /// Changes the effort of all that is still to be done.
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

    /// The least number of cells of the level on which a start begins, for Multilevel::coarsen; at
    /// most face_count.
    int coarse_face_count() const;
    /// Is the mesh large enough for its sub-meshes to be started on a coarser one?
    bool coarsens() const;

    /// Adapts the plan to the levels that the mesh really has.
    void set_levels(const Multilevel& multilevel);

    /// Iterations of Lloyd's relaxation in a start without trials; more where the first level is so
    /// coarse that they take a small part of the time.
    int relaxations() const;
    /// How many trials the first start should make (best_of_trials); 1: none, a single start.
    int trials() const;
    /// The plan for so many trials.
    TrialPlan trial_plan(int trials) const {
        return {trials, submesh_count_, first_face_count_, schedules_};
    }
    /// An upper bound of the number of phases of all annealings of a start.
    int most_phases() const;
    /// The cost of building what does not depend on k, in microseconds like all costs here.
    double cost_of_preparation() const;
    /// The cost of a start that makes so many trials (1: none).
    StartCost cost_of_start(int trials) const;
    /// The cost of the rounds of exchanges after all starts.
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
    /// The cells of the level on which starts begin, where an undone subdivision has left it; else
    /// 0.
    int quartered_face_count_ = 0;
    /// coarse_face_count(), or more where there is no level so coarse: the least number of cells
    /// that the first level may have, for the number of trials.
    int first_face_count_;
};

} // namespace spheroseg
