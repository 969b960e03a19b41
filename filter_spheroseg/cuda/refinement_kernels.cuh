// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Refinement: Algorithms 3 and 4. As in cohesion_kernels.cuh, the tests compile this source for the
// host too.

#include "round_tiles.h"
#include "swap_arrays.h"

namespace spheroseg::cuda {

namespace { // the tests' emulation has kernels of the same names

/// Eq. 1 of a face with a label that none of its three neighbours has, which is the most.
constexpr int kStrangerCost = 9;
/// Of faces that take no part.
constexpr signed char kNoCandidate = -64;

/// Labels as they would be if the faces a and b exchanged theirs; with a == b, as they are.
struct ExchangedLabels {
    const int* labels;
    int a;
    int b;
    __device__ int operator()(int face) const {
        return labels[face == a ? b : face == b ? a : face];
    }
};

__device__ inline int
boundary_sides(const int* neighbors, const ExchangedLabels& label_of, int face, int submesh) {
    int count = 0;
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbors[3 * face + side];
        count += neighbor >= 0 && label_of(neighbor) != submesh;
    }
    return count;
}

/// Eq. 1. With `face_joins`, of the face if it alone had the label `submesh`, not its own.
__device__ inline int face_cost(const int* neighbors,
                                const ExchangedLabels& label_of,
                                int face,
                                int submesh,
                                bool face_joins = false) {
    const int own = boundary_sides(neighbors, label_of, face, submesh);
    int cost = own * own;
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbors[3 * face + side];
        if (neighbor >= 0 && label_of(neighbor) == submesh) {
            const int sides =
                boundary_sides(neighbors, label_of, neighbor, submesh) - (face_joins ? 1 : 0);
            cost += sides * sides;
        }
    }
    return cost;
}

/// The most by which Eq. 1 of a face can fall in any swap (see the engine's refinement).
__device__ inline signed char gain_bound(const int* neighbors, const int* labels, int face) {
    const int label = labels[face];
    const ExchangedLabels as_they_are{labels, face, face};
    if (boundary_sides(neighbors, as_they_are, face, label) == 0) {
        return kNoCandidate;
    }
    int least = kStrangerCost;
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbors[3 * face + side];
        if (neighbor < 0 || labels[neighbor] == label) {
            continue;
        }
        const int other = labels[neighbor];
        const int joined = face_cost(neighbors, as_they_are, face, other, true);
        const int exchanged = face_cost(neighbors, {labels, face, neighbor}, face, other);
        least = joined < least ? joined : least;
        least = exchanged < least ? exchanged : least;
    }
    return static_cast<signed char>(face_cost(neighbors, as_they_are, face, label) - least);
}

__device__ inline bool touches(const int* neighbors, const int* labels, int face, int submesh) {
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbors[3 * face + side];
        if (neighbor >= 0 && labels[neighbor] == submesh) {
            return true;
        }
    }
    return false;
}

/// Algorithm 3, with e3 and e4 on the labels after the swap.
__device__ inline bool refining_swap(const int* neighbors, const int* labels, int a, int b) {
    const int label_a = labels[a];
    const int label_b = labels[b];
    if (label_a == label_b ||
        !(touches(neighbors, labels, a, label_b) || touches(neighbors, labels, b, label_a))) {
        return false;
    }
    const ExchangedLabels before{labels, a, a};
    const ExchangedLabels after{labels, a, b};
    return face_cost(neighbors, before, a, label_a) + face_cost(neighbors, before, b, label_b) >
        face_cost(neighbors, after, a, label_b) + face_cost(neighbors, after, b, label_a);
}

__device__ inline bool slot_wants_swap(const RefinementArrays& arrays, int round, int slot) {
    const ElementPair pair = slot_pair(arrays.face_count, round, slot);
    return pair.second >= 0 && arrays.bounds[pair.first] + arrays.bounds[pair.second] > 0 &&
        refining_swap(arrays.neighbors, arrays.labels, pair.first, pair.second);
}

/// visit(f) for the face and all faces within two steps of it, some more than once.
template <typename Visit>
__device__ inline void visit_within_two_steps(const int* neighbors, int face, const Visit& visit) {
    visit(face);
    for (int side = 0; side < 3; ++side) {
        const int neighbor = neighbors[3 * face + side];
        if (neighbor < 0) {
            continue;
        }
        visit(neighbor);
        for (int next_side = 0; next_side < 3; ++next_side) {
            const int next = neighbors[3 * neighbor + next_side];
            if (next >= 0) {
                visit(next);
            }
        }
    }
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
