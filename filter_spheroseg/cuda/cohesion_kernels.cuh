// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Cohesion: Algorithm 1. The kernels' source: the tests compile it for the host too, with an
// emulation of the execution model (tests/cuda), so it uses no more of CUDA than blocks, threads,
// shared memory, barriers, integer atomics and the rounding intrinsics.

#include "round_tiles.h"
#include "swap_arrays.h"

namespace spheroseg::cuda {

namespace { // the tests' emulation has kernels of the same names

/// Rounds in which a thread tests a face at once, on the labels before the first of them.
constexpr int kRoundsPerThread = 4;
/// Rounds that a block tests at once: as many as one thread, then twice as many after each test in
/// which no pair wants to swap.
constexpr int kMostRoundsAhead = 32;
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
    int label;
};

__device__ inline Face face_at(const HeldFaces& held, int place) {
    return {held.x[place],
            held.y[place],
            held.z[place],
            held.own_x[place],
            held.own_y[place],
            held.own_z[place],
            held.distance[place],
            held.label[place]};
}

/// A `chord` that may be off by 2^-21 of itself, or 0 where it is less than 2^-63.
__device__ inline float rough_chord(float ax, float ay, float az, float bx, float by, float bz) {
    const float dx = ax - bx;
    const float dy = ay - by;
    const float dz = az - bz;
    return SPHEROSEG_ROUGH_ROOT(__fmaf_rn(dx, dx, __fmaf_rn(dy, dy, dz * dz)));
}

/// False only where the pair does not want to swap: an exact root takes several times as long as
/// all the rest, and nearly all pairs are far from wanting to. Faces with the same label do not:
/// their distances are equal before and after, which the rough ones can not tell.
__device__ inline bool may_want_swap(const Face& a, const Face& b) {
    const float d3 = rough_chord(a.x, a.y, a.z, b.own_x, b.own_y, b.own_z);
    const float d4 = rough_chord(b.x, b.y, b.z, a.own_x, a.own_y, a.own_z);
    return (a.label != b.label) & (a.distance + b.distance > (d3 + d4) * kSurelyLess);
}

/// Algorithm 1.
__device__ inline bool wants_swap(const Face& a, const Face& b) {
    if (!may_want_swap(a, b)) {
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

__device__ inline bool meets_in_round(const Tile& tile, int diagonal, int t) {
    return diagonal - t >= tile.first_slot(t) && diagonal - t < tile.end_slot(t);
}

/// False only where the second face of a diagonal (a slot plus its round, which stays) wants to
/// swap in none of kRoundsPerThread rounds from `round_begin` on. In rounds in which it meets
/// nobody in this tile it is tested with any face: then a few more may swap than do. The loop has
/// no branches, so that loads and roots of its rounds overlap.
__device__ inline bool diagonal_may_swap(
    const Tile& tile, const HeldFaces& held, int diagonal, int round_begin, const Face& b) {
    const int slot = diagonal - round_begin;
    const int first_place = tile.rising_place(round_begin, slot);
    const int last_held = tile.held_count() - 1;
    bool may = false;
    SPHEROSEG_UNROLL
    for (int i = 0; i < kRoundsPerThread; ++i) {
        const int place = first_place - 2 * i;
        const int held_place = place < 0 ? 0 : (place > last_held ? last_held : place);
        may |= may_want_swap(face_at(held, held_place), b);
    }
    if (tile.has_zero && slot >= 0 && slot < kRoundsPerThread) {
        may |= may_want_swap(face_at(held, tile.first_place(diagonal, 0)), b);
    }
    return may;
}

/// The first of the rounds [round_begin, round_end), at most kRoundsPerThread, in which the second
/// face of a diagonal wants to swap; `round_end`: none.
__device__ inline int first_swap_of(
    const Tile& tile, const HeldFaces& held, int diagonal, int round_begin, int round_end) {
    const Face b = face_at(held, tile.second_place(0, diagonal));
    if (!diagonal_may_swap(tile, held, diagonal, round_begin, b)) {
        return round_end;
    }
    for (int t = round_begin; t < round_end; ++t) {
        if (meets_in_round(tile, diagonal, t) &&
            wants_swap(face_at(held, tile.first_place(t, diagonal - t)), b)) {
            return t;
        }
    }
    return round_end;
}

/// The first of the rounds [round_begin, round_end) in which a pair of this thread wants to swap;
/// `round_end`: none. At a time a thread takes the pairs of a second face, which stays in
/// registers, in kRoundsPerThread rounds.
__device__ inline int
first_swap(const Tile& tile, const HeldFaces& held, int round_begin, int round_end) {
    const int last = round_end - 1;
    const int first_low = tile.first_slot(round_begin) + round_begin;
    const int last_low = tile.first_slot(last) + last;
    const int first_high = tile.end_slot(round_begin) + round_begin;
    const int last_high = tile.end_slot(last) + last;
    const int low = first_low < last_low ? first_low : last_low;
    const int width = (first_high > last_high ? first_high : last_high) - low;
    int first = round_end;
    int begin = round_begin;
    for (int at = threadIdx.x;; at += static_cast<int>(blockDim.x)) {
        for (; at >= width && begin < first; at -= width) {
            begin += kRoundsPerThread;
        }
        if (begin >= first) {
            return first;
        }
        const int ahead = round_end - begin;
        const int end = begin + (ahead < kRoundsPerThread ? ahead : kRoundsPerThread);
        const int wanted = first_swap_of(tile, held, low + at, begin, end);
        if (wanted < end && wanted < first) {
            first = wanted;
        }
    }
}

/// Swaps this thread's pairs in round t of the tile that want it.
__device__ inline int play_round(const Tile& tile, const HeldFaces& held, int t) {
    int swap_count = 0;
    const int slot_end = tile.end_slot(t);
    for (int slot = tile.first_slot(t) + static_cast<int>(threadIdx.x); slot < slot_end;
         slot += blockDim.x) {
        const int a = tile.first_place(t, slot);
        const int b = tile.second_place(t, slot);
        if (wants_swap(face_at(held, a), face_at(held, b))) {
            swap_pair(held, a, b);
            ++swap_count;
        }
    }
    return swap_count;
}

/// One tile per block. Dynamic shared memory: tile_bytes(capacity).
__global__ void __launch_bounds__(kCohesionThreads)
    play_cohesion_tiles(CohesionArrays arrays, TilePhase phase, int capacity) {
    SPHEROSEG_DYNAMIC_SHARED(float, words);
    const HeldFaces held = held_faces(words, capacity);
    // Three in turn: one is read while the next is written and the one after it may be cleared.
    int* const found = reinterpret_cast<int*>(words + kTileWords * capacity);
    const Tile tile = tile_of(phase, static_cast<int>(blockIdx.x));
    load_tile(arrays, tile, phase.element_count, held);
    if (threadIdx.x == 0) {
        found[0] = kNoRound;
    }
    __syncthreads();
    int swap_count = 0;
    int round = 0;
    int ahead = kRoundsPerThread;
    for (int test = 0; round < tile.round_count; test = (test + 1) % kFoundRounds) {
        const int left = tile.round_count - round;
        const int end = round + (left < ahead ? left : ahead);
        const int wanted = first_swap(tile, held, round, end);
        if (wanted < end) {
            atomicMin(&found[test], wanted);
        }
        if (threadIdx.x == 0) {
            found[(test + 1) % kFoundRounds] = kNoRound;
        }
        __syncthreads();
        const int first = found[test];
        if (first == kNoRound) {
            round = end;
            ahead = 2 * ahead < kMostRoundsAhead ? 2 * ahead : kMostRoundsAhead;
            continue;
        }
        // Where one round has swaps, the next ones often have.
        round = first;
        for (bool swapped = true; swapped && round < tile.round_count; ++round) {
            const int swaps = play_round(tile, held, round);
            swap_count += swaps;
            swapped = __syncthreads_or(swaps > 0) != 0;
        }
        ahead = kRoundsPerThread;
    }
    store_tile(arrays, tile, phase.element_count, held);
    if (swap_count > 0) {
        atomicAdd(arrays.swap_count, static_cast<unsigned long long>(swap_count));
    }
}

} // namespace

} // namespace spheroseg::cuda
