// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "byte_reader.h"
#include "segment.h"

namespace spheroseg::fuzz {

/// Sets the balance and the weights: none in a third of the cases, and of the others some that must
/// be refused.
void read_weights(ByteReader& bytes, int face_count, SegmentOptions& options);

/// Sets initial labels in two thirds of the cases, some of which must be refused. The number of
/// different labels follows the number of sub-meshes that the options ask for.
void read_labels(ByteReader& bytes, const TriangleMesh& mesh, SegmentOptions& options);

} // namespace spheroseg::fuzz
