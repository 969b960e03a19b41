// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "group_moves.h"

namespace spheroseg::cuda {

/// What the kernels of the annealing read and write. All pointers are those of the device.
struct AnnealArrays {
    const Cell* cells; // the labels in them are not used
    int* labels;
    unsigned char* listed; // per face
    int* loads;            // per label
    int* cell_counts;      // faces of each label
    const int* group_of_label;
    const float* quantiles;
    const int* order; // groups, those with the most faces first
    /// The boundary faces of group g: face_counts[g] of them from face_begin[g] on, with room for
    /// all faces of the group.
    int* faces;
    const int* face_begin;
    int* face_counts;
    /// Partners of label l: partner_counts[l] of them from partner_begin[l] on, with room up to
    /// partner_begin[l + 1]. Null without.
    int* partners;
    const long long* partner_begin;
    int* partner_counts;
    /// Sum of the changes of the number of boundary edges, modulo 2^64.
    unsigned long long* change;
    int group_count;
    bool may_close_rings;
};

/// Threads of a block, which anneals one group.
constexpr int kAnnealThreads = 32;

} // namespace spheroseg::cuda
