// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

#include <gtest/gtest.h>

namespace spheroseg::test {

/// Segments and expects a progress that rises from 0 to 1 in steps of at most 0.15.
inline void expect_small_steps(PreparedMesh& prepared, const SegmentOptions& options) {
    double last = 0.0;
    segment(prepared, options, [&](double fraction, const char*) {
        EXPECT_GE(fraction, last) << options.submesh_count;
        EXPECT_LE(fraction, last + 0.15) << options.submesh_count;
        last = fraction;
        return true;
    });
    EXPECT_EQ(last, 1.0) << options.submesh_count;
}

} // namespace spheroseg::test
