// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace spheroseg::test {

/// Of long sweeps of like runs a build with sanitizers, where each takes several times as long,
/// makes one in `kThinning`; all other builds make all of them.
#ifdef SPHEROSEG_SANITIZE
inline constexpr int kThinning = 3;
#else
inline constexpr int kThinning = 1;
#endif

} // namespace spheroseg::test
