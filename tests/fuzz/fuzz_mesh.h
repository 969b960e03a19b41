// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "byte_reader.h"
#include "types.h"

namespace spheroseg::fuzz {

/// No mesh gets more faces than this, unless it is a large one (fuzz_large.h).
constexpr int kMaxFaces = 400;

/// Builds a mesh as the bytes say: either a list of faces on few vertices, which is seldom a
/// surface, or simple surfaces, or a large one, that are then changed step by step, so that valid
/// meshes of every kind are frequent too.
TriangleMesh read_mesh(ByteReader& bytes, bool large);

} // namespace spheroseg::fuzz
