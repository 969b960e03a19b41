// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace spheroseg {

/// Makes OpenMP's threads sleep soon while they wait for each other, where OMP_WAIT_POLICY and
/// GOMP_SPINCOUNT were not set when this library was loaded. GNU's OpenMP has them spin for
/// milliseconds then, which beside other work takes many times as long as the work itself; and it
/// reads the variables when it is loaded, which a host may have done long before. But where it
/// knows of more threads than cores it spins for a moment only. So this starts two that do nothing,
/// once per process.
///
/// For what is about to use several threads. With other OpenMP libraries nothing is done; nothing
/// throws.
void keep_waiting_threads_calm();

} // namespace spheroseg
