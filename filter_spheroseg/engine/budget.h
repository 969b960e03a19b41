// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg {

/// How much work an effort is worth: proposals per boundary face and phases of each annealing.
struct Budget {
    int relaxations;
    double coarse_proposals;
    /// Instead of the former, where there is no coarse mesh.
    double only_level_proposals;
    double level_proposals;
    double exchange_proposals;
    double only_level_exchanges; // the same
    int coarse_phases;
    int level_phases;
    /// Number of faces of a level over that of the next coarser one.
    double growth;
};

inline Budget budget_of(Effort effort) {
    switch (effort) {
    case Effort::draft:
        return {20, 38.0, 30.0, 25.0, 20.0, 15.0, 12, 6, 2.0};
    case Effort::high:
        return {60, 4000.0, 2500.0, 1000.0, 1000.0, 2000.0, 48, 48, 1.5};
    case Effort::standard:
        break;
    }
    return {24, 90.0, 62.0, 52.0, 35.0, 24.0, 24, 12, 2.0};
}

} // namespace spheroseg
