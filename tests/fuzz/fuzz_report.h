// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fuzz_case.h"
#include "recount.h"

namespace spheroseg::fuzz {

enum class Outcome {
    /// Valid and as balanced as can be.
    segmented,
    /// Not all of that, and there is none: all were tried.
    impossible,
    /// Not all of that, but there is one.
    missed,
    /// Not all of that; there are too many to try.
    not_reached,
    /// Not all of that, and the time limit was hit.
    out_of_time,
    /// An error with a message.
    refused,
    cancelled,
    outcome_count
};

/// Counted over the process; with SPHEROSEG_FUZZ_STATISTICS=FILE appended to FILE at its end.
void count(Outcome outcome);
int counted(Outcome outcome);

/// With SPHEROSEG_FUZZ_MISSED=FILE the case is described there.
void note_missed(const char* how,
                 const FuzzCase& one,
                 const Recount& recount,
                 int least_difference);

/// Prints the mesh and the options so that they can be put into a test, and aborts.
[[noreturn]] void report_failure(const char* what, const FuzzCase& one);

} // namespace spheroseg::fuzz
