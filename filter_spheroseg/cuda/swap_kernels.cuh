// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// The kernels' source. The tests compile it for the host too, with an emulation of the execution
// model (tests/cuda), so it uses no more of CUDA than blocks, threads, shared memory, barriers,
// integer atomics and the rounding intrinsics.

#include "round_tiles.h"
#include "swap_arrays.h"

namespace spheroseg::cuda {

namespace { // the tests' emulation has kernels of the same names

// ---- Cohesion: Algorithm 1

/// Rounds that are tested ahead, on the labels before the first of them. When no pair of the tile
/// wants to swap in any of them, they are done; else they are played one by one.
constexpr int kQuietRounds = 8;
/// The least that exact distances can be of approximate ones: more than ten times as far below 1 as
/// the approximate root and the contracted sum of squares can be off (2^-22 each).
constexpr float kSurelyLess = 1.0f - 0x1.0p-18f;

/// Faces of a tile in shared memory.
struct HeldFaces {
    float* x;
    float* y;
    float* z;
    float* own_x; // centroid of the sub-mesh of the face
    float* own_y;
    float* own_z;
    float* distance; // |face - own|
    int* label;
};

__device__ inline HeldFaces held_faces(float* words, int capacity) {
    return {words,
            words + capacity,
            words + 2 * capacity,
            words + 3 * capacity,
            words + 4 * capacity,
            words + 5 * capacity,
            words + 6 * capacity,
            reinterpret_cast<int*>(words + 7 * capacity)};
}

/// `chord` of the engine, bit for bit: every operation rounded, none contracted.
__device__ inline float chord(float ax, float ay, float az, float bx, float by, float bz) {
    const float dx = __fsub_rn(ax, bx);
    const float dy = __fsub_rn(ay, by);
    const float dz = __fsub_rn(az, bz);
    return __fsqrt_rn(
        __fadd_rn(__fadd_rn(__fmul_rn(dx, dx), __fmul_rn(dy, dy)), __fmul_rn(dz, dz)));
}

/// Fills the tile's array. A place without a face gets coordinates that compare as false.
__device__ inline void
load_tile(const CohesionArrays& arrays, const Tile& tile, int face_count, const HeldFaces& held) {
    const int held_count = tile.held_count();
    for (int place = threadIdx.x; place < held_count; place += blockDim.x) {
        const int face = tile.element_at(place);
        if (face >= face_count) {
            const float nothing = __int_as_float(0x7fffffff);
            held.x[place] = held.y[place] = held.z[place] = nothing;
            held.own_x[place] = held.own_y[place] = held.own_z[place] = nothing;
            held.distance[place] = nothing;
            held.label[place] = -1;
            continue;
        }
        const int label = arrays.labels[face];
        held.x[place] = arrays.face_x[face];
        held.y[place] = arrays.face_y[face];
        held.z[place] = arrays.face_z[face];
        held.own_x[place] = arrays.submesh_x[label];
        held.own_y[place] = arrays.submesh_y[label];
        held.own_z[place] = arrays.submesh_z[label];
        held.label[place] = label;
        held.distance[place] = chord(held.x[place],
                                     held.y[place],
                                     held.z[place],
                                     held.own_x[place],
                                     held.own_y[place],
                                     held.own_z[place]);
    }
}

__device__ inline void
store_tile(const CohesionArrays& arrays, const Tile& tile, int face_count, const HeldFaces& held) {
    const int held_count = tile.held_count();
    for (int place = threadIdx.x; place < held_count; place += blockDim.x) {
        const int face = tile.element_at(place);
        if (face < face_count) {
            arrays.labels[face] = held.label[place];
        }
    }
}

/// A face in registers.
struct Face {
    float x;
    float y;
    float z;
    float own_x;
    float own_y;
    float own_z;
    float distance;
};

__device__ inline Face face_at(const HeldFaces& held, int place) {
    return {held.x[place],
            held.y[place],
            held.z[place],
            held.own_x[place],
            held.own_y[place],
            held.own_z[place],
            held.distance[place]};
}

/// A `chord` that may be off by 2^-21 of itself, or 0 where it is less than 2^-63.
__device__ inline float rough_chord(float ax, float ay, float az, float bx, float by, float bz) {
    const float dx = ax - bx;
    const float dy = ay - by;
    const float dz = az - bz;
    return SPHEROSEG_ROUGH_ROOT(__fmaf_rn(dx, dx, __fmaf_rn(dy, dy, dz * dz)));
}

/// False only where the pair does not want to swap: an exact root takes several times as long as
/// all the rest, and nearly all pairs are far from wanting to.
__device__ inline bool may_want_swap(const Face& a, const Face& b) {
    const float d3 = rough_chord(a.x, a.y, a.z, b.own_x, b.own_y, b.own_z);
    const float d4 = rough_chord(b.x, b.y, b.z, a.own_x, a.own_y, a.own_z);
    return a.distance + b.distance > (d3 + d4) * kSurelyLess;
}

/// Algorithm 1. Faces with the same label do not swap: their distances are equal before and after.
__device__ inline bool
wants_swap(const HeldFaces& held, const Face& a, int a_place, const Face& b, int b_place) {
    if (!may_want_swap(a, b) || held.label[a_place] == held.label[b_place]) {
        return false;
    }
    const float d3 = chord(a.x, a.y, a.z, b.own_x, b.own_y, b.own_z);
    const float d4 = chord(b.x, b.y, b.z, a.own_x, a.own_y, a.own_z);
    return __fadd_rn(a.distance, b.distance) > __fadd_rn(d3, d4);
}

template <typename T> __device__ inline void exchange(T& a, T& b) {
    const T kept = a;
    a = b;
    b = kept;
}

__device__ inline void swap_pair(const HeldFaces& held, int a, int b) {
    exchange(held.own_x[a], held.own_x[b]);
    exchange(held.own_y[a], held.own_y[b]);
    exchange(held.own_z[a], held.own_z[b]);
    exchange(held.label[a], held.label[b]);
    held.distance[a] =
        chord(held.x[a], held.y[a], held.z[a], held.own_x[a], held.own_y[a], held.own_z[a]);
    held.distance[b] =
        chord(held.x[b], held.y[b], held.z[b], held.own_x[b], held.own_y[b], held.own_z[b]);
}

/// Whether the second face of a diagonal (a slot plus its round, which stays) may want to swap in
/// any of kQuietRounds rounds from `round_begin` on, in all of which it meets a face. No branches
/// and no index but one: the rounds' loads and roots overlap.
__device__ inline bool whole_diagonal_may_swap(
    const Tile& tile, const HeldFaces& held, int diagonal, int round_begin, const Face& b) {
    const int first_place = tile.first_place(round_begin, diagonal - round_begin);
    bool may = false;
    SPHEROSEG_UNROLL
    for (int i = 0; i < kQuietRounds; ++i) {
        may |= may_want_swap(face_at(held, first_place - 2 * i), b);
    }
    return may;
}

__device__ inline bool meets_in_round(const Tile& tile, int diagonal, int t) {
    return diagonal - t >= tile.first_slot(t) && diagonal - t < tile.end_slot(t);
}

/// Whether the second face of a diagonal wants to swap in the rounds [round_begin, round_end).
__device__ inline bool face_wants_swap(
    const Tile& tile, const HeldFaces& held, int diagonal, int round_begin, int round_end) {
    const int b_place = tile.second_place(0, diagonal);
    const Face b = face_at(held, b_place);
    const int last = round_end - 1;
    // In slot 0 the first face is not the next one of the diagonal.
    const bool whole = round_end - round_begin == kQuietRounds && diagonal - last >= 1 &&
        meets_in_round(tile, diagonal, round_begin) && meets_in_round(tile, diagonal, last);
    if (whole && !whole_diagonal_may_swap(tile, held, diagonal, round_begin, b)) {
        return false;
    }
    for (int t = round_begin; t < round_end; ++t) {
        if (meets_in_round(tile, diagonal, t)) {
            const int a_place = tile.first_place(t, diagonal - t);
            if (wants_swap(held, face_at(held, a_place), a_place, b, b_place)) {
                return true;
            }
        }
    }
    return false;
}

/// Whether any of this thread's pairs in the rounds [round_begin, round_end) want to swap. A thread
/// takes the pairs of a second face, which stays in registers.
__device__ inline bool
rounds_want_swap(const Tile& tile, const HeldFaces& held, int round_begin, int round_end) {
    const int last = round_end - 1;
    const int first_low = tile.first_slot(round_begin) + round_begin;
    const int last_low = tile.first_slot(last) + last;
    const int first_high = tile.end_slot(round_begin) + round_begin;
    const int last_high = tile.end_slot(last) + last;
    const int high = first_high > last_high ? first_high : last_high;
    int diagonal = (first_low < last_low ? first_low : last_low) + static_cast<int>(threadIdx.x);
    for (; diagonal < high; diagonal += static_cast<int>(blockDim.x)) {
        if (face_wants_swap(tile, held, diagonal, round_begin, round_end)) {
            return true;
        }
    }
    return false;
}

/// Swaps this thread's pairs in round t of the tile that want it.
__device__ inline int play_round(const Tile& tile, const HeldFaces& held, int t) {
    int swap_count = 0;
    const int slot_end = tile.end_slot(t);
    for (int slot = tile.first_slot(t) + static_cast<int>(threadIdx.x); slot < slot_end;
         slot += blockDim.x) {
        const int a = tile.first_place(t, slot);
        const int b = tile.second_place(t, slot);
        if (wants_swap(held, face_at(held, a), a, face_at(held, b), b)) {
            swap_pair(held, a, b);
            ++swap_count;
        }
    }
    return swap_count;
}

/// One tile per block. Dynamic shared memory: kTileWords words for each of `capacity` elements.
__global__ void __launch_bounds__(kCohesionThreads)
    play_cohesion_tiles(CohesionArrays arrays, TilePhase phase, int capacity) {
    SPHEROSEG_DYNAMIC_SHARED(float, words);
    const HeldFaces held = held_faces(words, capacity);
    const Tile tile = tile_of(phase, static_cast<int>(blockIdx.x));
    load_tile(arrays, tile, phase.element_count, held);
    __syncthreads();
    int swap_count = 0;
    for (int begin = 0; begin < tile.round_count; begin += kQuietRounds) {
        const int ahead = tile.round_count - begin;
        const int end = begin + (ahead < kQuietRounds ? ahead : kQuietRounds);
        if (__syncthreads_or(rounds_want_swap(tile, held, begin, end)) == 0) {
            continue;
        }
        for (int t = begin; t < end; ++t) {
            swap_count += play_round(tile, held, t);
            __syncthreads();
        }
    }
    store_tile(arrays, tile, phase.element_count, held);
    if (swap_count > 0) {
        atomicAdd(arrays.swap_count, static_cast<unsigned long long>(swap_count));
    }
}

// ---- Refinement: Algorithms 3 and 4

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
