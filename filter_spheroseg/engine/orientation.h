// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

namespace spheroseg {

/// Sign (-1, 0, 1) of the determinant of the rows a, b, c: 1 when the triangle a, b, c on a sphere
/// around the origin is counter-clockwise seen from outside. Exact for finite coordinates that are
/// zero or between 2^-250 and 2^250 in size: a filtered product in double precision first, then
/// expansions (Shewchuk: Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates, 1997).
int orientation(const Vec3& a, const Vec3& b, const Vec3& c);

} // namespace spheroseg
