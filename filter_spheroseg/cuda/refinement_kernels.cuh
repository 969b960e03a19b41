// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Refinement: Algorithms 3 and 4. As in cohesion_kernels.cuh, the tests compile this source for the
// host too.

#include "refinement_cost.h"
#include "round_tiles.h"
#include "swap_arrays.h"

namespace spheroseg::cuda {

namespace { // the tests' emulation has kernels of the same names

__device__ inline bool slot_wants_swap(const RefinementArrays& arrays, int round, int slot) {
    const ElementPair pair = slot_pair(arrays.face_count, round, slot);
    return pair.second >= 0 && arrays.bounds[pair.first] + arrays.bounds[pair.second] > 0 &&
        swaps(arrays.neighbors, arrays.labels, pair.first, pair.second);
}

__global__ void __launch_bounds__(kScanThreads) measure_bounds(RefinementArrays arrays) {
    const int face = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
    if (face < arrays.face_count) {
        arrays.bounds[face] = gain_bound(arrays.neighbors, arrays.labels, face);
    }
}

/// Looks for the first round, of the `gridDim.y` from the cursor on, in which a pair swaps. Until
/// then nothing changes, so that all of them can be tested at once.
__global__ void __launch_bounds__(kScanThreads) find_round(RefinementArrays arrays) {
    RefinementCursor& cursor = *arrays.cursor;
    const int round = cursor.next_round + static_cast<int>(blockIdx.y);
    // A later block may see an earlier one's find, or not: only the time depends on it.
    if (round >= cursor.round_end || SPHEROSEG_VOLATILE_READ(cursor.found_round) < round) {
        return;
    }
    const int slots = slot_count_of(arrays.face_count);
    const int first = static_cast<int>(blockIdx.x * blockDim.x * kSlotsPerScanThread + threadIdx.x);
    bool any = false;
    for (int i = 0; i < kSlotsPerScanThread; ++i) {
        const int slot = first + i * static_cast<int>(blockDim.x);
        any = any || (slot < slots && slot_wants_swap(arrays, round, slot));
    }
    if (any) {
        atomicMin(&cursor.found_round, round);
    }
}

/// Lists the pairs of the found round that want to swap, on the labels at its start.
__global__ void __launch_bounds__(kScanThreads) decide_round(RefinementArrays arrays) {
    RefinementCursor& cursor = *arrays.cursor;
    if (cursor.found_round == kNoRound) {
        return;
    }
    const int slots = slot_count_of(arrays.face_count);
    const int slot = static_cast<int>(blockIdx.x * blockDim.x + threadIdx.x);
    if (slot < slots && slot_wants_swap(arrays, cursor.found_round, slot)) {
        arrays.decided[atomicAdd(&cursor.decided_count, 1)] = slot;
    }
}

/// Whether an earlier slot of this commit decided to swap a face within two steps of `face`.
__device__ inline bool
near_earlier_pair(const RefinementArrays& arrays, int face, unsigned long long stamp) {
    bool found = false;
    visit_within_two_steps(arrays.neighbors, face, [&](int f) {
        const unsigned long long other = arrays.stamps[f];
        found = found || (other >> 32 == stamp >> 32 && other < stamp);
    });
    return found;
}

/// Swaps the decided pairs that need not yield, and moves the cursor on. One block: whether a pair
/// yields depends on what was decided, not on what yielded, so that all are judged at once.
__global__ void __launch_bounds__(kCommitThreads)
    commit_round(RefinementArrays arrays, int batch_rounds) {
    RefinementCursor& cursor = *arrays.cursor;
    const int decided_count = cursor.decided_count;
    const int round = cursor.found_round;
    const unsigned long long commit = static_cast<unsigned long long>(cursor.commit_count + 1)
        << 32;
    const int first = static_cast<int>(threadIdx.x);
    const int stride = static_cast<int>(blockDim.x);
    for (int i = first; i < decided_count; i += stride) {
        const int slot = arrays.decided[i];
        const ElementPair pair = slot_pair(arrays.face_count, round, slot);
        arrays.stamps[pair.first] = arrays.stamps[pair.second] = commit | slot;
    }
    __syncthreads();
    for (int i = first; i < decided_count; i += stride) {
        const int slot = arrays.decided[i];
        const ElementPair pair = slot_pair(arrays.face_count, round, slot);
        if (near_earlier_pair(arrays, pair.first, commit | slot) ||
            near_earlier_pair(arrays, pair.second, commit | slot)) {
            arrays.decided[i] = -1;
        }
    }
    __syncthreads();
    unsigned long long swap_count = 0;
    for (int i = first; i < decided_count; i += stride) {
        if (arrays.decided[i] >= 0) {
            const ElementPair pair = slot_pair(arrays.face_count, round, arrays.decided[i]);
            exchange(arrays.labels[pair.first], arrays.labels[pair.second]);
            ++swap_count;
        }
    }
    __syncthreads();
    for (int i = first; i < decided_count; i += stride) {
        if (arrays.decided[i] >= 0) {
            const ElementPair pair = slot_pair(arrays.face_count, round, arrays.decided[i]);
            const auto update = [&](int f) {
                arrays.bounds[f] = gain_bound(arrays.neighbors, arrays.labels, f);
            };
            visit_within_two_steps(arrays.neighbors, pair.first, update);
            visit_within_two_steps(arrays.neighbors, pair.second, update);
        }
    }
    if (swap_count > 0) {
        atomicAdd(&cursor.swap_count, swap_count);
    }
    if (threadIdx.x == 0) {
        const int left = cursor.round_end - cursor.next_round;
        cursor.next_round = round != kNoRound
            ? round + 1
            : cursor.next_round + (left < batch_rounds ? left : batch_rounds);
        cursor.found_round = kNoRound;
        cursor.decided_count = 0;
        ++cursor.commit_count;
    }
}

} // namespace

} // namespace spheroseg::cuda
