// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

namespace spheroseg::fuzz {

/// What a run does besides segmenting.
struct FuzzCase {
    TriangleMesh mesh;
    SegmentOptions options;
    /// The progress callback stops at this call; 0: never.
    int cancel_at_call = 0;
    /// Also makes the spherical map.
    bool parametrize = false;
    /// Also measures labels that have nothing to do with the segmentation.
    bool measure_any_labels = false;
    int label_seed = 0;
    /// Also looks at the coarse levels of the mesh.
    bool check_levels = false;
    /// Also starts again from the labels that came out, some of them changed.
    bool start_again = false;
};

/// The first kOptionBytes bytes choose options, the others the mesh; new options take over bytes
/// that were unused, so that a corpus stays of use.
constexpr int kOptionBytes = 20;
FuzzCase read_case(const std::uint8_t* bytes, std::size_t size);

} // namespace spheroseg::fuzz
