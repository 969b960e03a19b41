// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace spheroseg::test {

/// Of the allocations from now on, of any thread, the one with this number (from 0) is refused.
void refuse_allocation(long long number);

/// No allocation is refused from now on. Returns true when one was.
bool stop_refusing();

} // namespace spheroseg::test
