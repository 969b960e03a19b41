// SPDX-License-Identifier: GPL-3.0-or-later
#include "chord_swaps.h"

// The same source for every instruction set; the loader picks the widest that the machine has.
// Every operation is rounded as IEEE 754 says, so that all of them give the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) &&                             \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SPHEROSEG_WIDEST_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define SPHEROSEG_WIDEST_VECTORS
#endif

namespace spheroseg {

namespace {

constexpr int kBlockSize = 128;

inline float chord(float ax, float ay, float az, float bx, float by, float bz) {
    const float dx = ax - bx;
    const float dy = ay - by;
    const float dz = az - bz;
    return std::sqrt(dx * dx + dy * dy + dz * dz);
}

/// wants_swap[i]: the pair (first + i, second - i) swaps. Returns whether any does.
SPHEROSEG_WIDEST_VECTORS
bool compare_block(
    const ChordSwapState& state, int first, int second, int count, int* __restrict wants_swap) {
    const float* __restrict ax = state.face.x.data() + first;
    const float* __restrict ay = state.face.y.data() + first;
    const float* __restrict az = state.face.z.data() + first;
    const float* __restrict asx = state.own.x.data() + first;
    const float* __restrict asy = state.own.y.data() + first;
    const float* __restrict asz = state.own.z.data() + first;
    const float* __restrict d1 = state.distance.data() + first;
    const float* __restrict bx = state.face.x.data() + second;
    const float* __restrict by = state.face.y.data() + second;
    const float* __restrict bz = state.face.z.data() + second;
    const float* __restrict bsx = state.own.x.data() + second;
    const float* __restrict bsy = state.own.y.data() + second;
    const float* __restrict bsz = state.own.z.data() + second;
    const float* __restrict d2 = state.distance.data() + second;
    int any = 0;
    for (int i = 0; i < count; ++i) {
        const float d3 = chord(ax[i], ay[i], az[i], bsx[-i], bsy[-i], bsz[-i]);
        const float d4 = chord(bx[-i], by[-i], bz[-i], asx[i], asy[i], asz[i]);
        const int wants = d1[i] + d2[-i] > d3 + d4 ? 1 : 0;
        wants_swap[i] = wants;
        any |= wants;
    }
    return any != 0;
}

void swap_pair(ChordSwapState& state, int a, int b) {
    state.own.exchange(a, b);
    std::swap(state.label[a], state.label[b]);
    for (int f : {a, b}) {
        state.distance[f] = chord(state.face.x[f],
                                  state.face.y[f],
                                  state.face.z[f],
                                  state.own.x[f],
                                  state.own.y[f],
                                  state.own.z[f]);
    }
}

} // namespace

SPHEROSEG_WIDEST_VECTORS
void measure_distances(ChordSwapState& state) {
    const PointArrays& face = state.face;
    const PointArrays& own = state.own;
    for (int f = 0; f < state.face_count(); ++f) {
        state.distance[f] = chord(face.x[f], face.y[f], face.z[f], own.x[f], own.y[f], own.z[f]);
    }
}

int swap_run(ChordSwapState& state, const PairRun& run) {
    int wants_swap[kBlockSize];
    int swap_count = 0;
    for (int begin = 0; begin < run.count; begin += kBlockSize) {
        const int first = run.first + begin;
        const int second = run.second - begin;
        const int count = std::min(kBlockSize, run.count - begin);
        if (!compare_block(state, first, second, count, wants_swap)) {
            continue;
        }
        for (int i = 0; i < count; ++i) {
            if (wants_swap[i]) {
                swap_pair(state, first + i, second - i);
                ++swap_count;
            }
        }
    }
    return swap_count;
}

} // namespace spheroseg
