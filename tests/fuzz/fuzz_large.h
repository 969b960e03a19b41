// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "byte_reader.h"
#include "types.h"

namespace spheroseg::fuzz {

/// No large mesh gets more faces than this.
constexpr int kMaxLargeFaces = 2000;

/// Builds a surface of some hundred faces or more, large enough to be coarsened, and damages it in
/// a few ways at many random places.
TriangleMesh read_large_mesh(ByteReader& bytes);

} // namespace spheroseg::fuzz
