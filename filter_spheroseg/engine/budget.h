// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "options.h"

namespace spheroseg {

/// How much work an effort is worth.
struct Budget {
    /// Starts of a component, of which the best result is kept.
    int starts;
    /// Iterations of Lloyd's relaxation.
    int relaxations;
    /// Proposals per boundary face on the first level, on the first level where sub-meshes are
    /// small (Schedules::are_small), and on each further level.
    double first_proposals;
    double small_first_proposals;
    double level_proposals;
    /// Cells per sub-mesh above which a further level gets more than level_proposals.
    int large_submesh;
    /// The part of these proposals that each trial of the first start makes, and how many cells all
    /// trials together may have on the first level (trial_count).
    double trial_share;
    int trial_faces;
    /// Proposals of branches per boundary face, where they are needed.
    double branch_proposals;
    /// Exchanges per boundary face at exact balance, and where sub-meshes are small. Where `rounds`
    /// is above 0 these are made in the balance by weight only.
    double exchange_proposals;
    double small_exchange_proposals;
    /// Rounds of exchanges in the best result, and how many are tried per boundary face in each.
    int rounds;
    double round_proposals;
    /// Temperatures of the annealing on the first level, and on each further one.
    int first_phases;
    int level_phases;
};

inline Budget budget_of(Effort effort) {
    Budget budget = {};
    switch (effort) {
    case Effort::draft:
        budget.starts = 1;
        budget.relaxations = 30;
        budget.first_proposals = 38.0;
        budget.small_first_proposals = 30.0;
        budget.level_proposals = 25.0;
        budget.large_submesh = 1024;
        budget.branch_proposals = 50.0;
        budget.trial_share = 0.5;
        budget.trial_faces = 4000;
        budget.exchange_proposals = 20.0;
        budget.small_exchange_proposals = 15.0;
        budget.first_phases = 12;
        budget.level_phases = 6;
        break;
    case Effort::standard:
        budget.starts = 1;
        budget.relaxations = 30;
        budget.first_proposals = 90.0;
        budget.small_first_proposals = 62.0;
        budget.level_proposals = 52.0;
        budget.large_submesh = 1024;
        budget.branch_proposals = 100.0;
        budget.trial_share = 0.5;
        budget.trial_faces = 6000;
        budget.exchange_proposals = 35.0;
        budget.small_exchange_proposals = 24.0;
        budget.first_phases = 24;
        budget.level_phases = 12;
        break;
    case Effort::high:
        budget.starts = 2;
        budget.relaxations = 60;
        budget.first_proposals = 4000.0;
        budget.small_first_proposals = 2500.0;
        budget.level_proposals = 1500.0;
        budget.large_submesh = 256;
        budget.branch_proposals = 400.0;
        budget.trial_share = 0.2;
        budget.trial_faces = 6000;
        budget.exchange_proposals = 1000.0;
        budget.small_exchange_proposals = 2000.0;
        budget.rounds = 45;
        budget.round_proposals = 100.0;
        budget.first_phases = 48;
        budget.level_phases = 48;
        break;
    }
    return budget;
}

} // namespace spheroseg
