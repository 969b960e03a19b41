// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

/// How much work an effort is worth: proposals per boundary face and phases of each annealing.
struct Budget {
    int relaxations;
    /// On the first level, and instead where sub-meshes are small.
    double first_proposals;
    double small_first_proposals;
    double level_proposals;
    /// The part of these that is made in each trial of the first start, and how many cells all
    /// trials together may have on the first level.
    double trial_share;
    int trial_faces;
    double exchange_proposals;
    double small_exchange_proposals; // the same
    int first_phases;
    int level_phases;
};

inline Budget budget_of(Effort effort) {
    switch (effort) {
    case Effort::draft:
        return {20, 38.0, 30.0, 25.0, 0.5, 4000, 20.0, 15.0, 12, 6};
    case Effort::high:
        return {60, 4000.0, 2500.0, 1500.0, 0.1, 6000, 1000.0, 2000.0, 48, 48};
    case Effort::standard:
        break;
    }
    return {24, 90.0, 62.0, 52.0, 0.5, 6000, 35.0, 24.0, 24, 12};
}

} // namespace spheroseg
