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
/// Steps of a column between two looks at whether any pair wants to swap.
constexpr int kGroupSteps = 4;

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

/// The second faces of a column in the order of the pairs, next to each other.
struct alignas(64) Column {
    float x[kColumnFaces];
    float y[kColumnFaces];
    float z[kColumnFaces];
    float own_x[kColumnFaces];
    float own_y[kColumnFaces];
    float own_z[kColumnFaces];
    float distance[kColumnFaces];
};

Column load_column(const ChordSwapState& state, int second) {
    Column column;
    for (int j = 0; j < kColumnFaces; ++j) {
        const int f = second - j;
        column.x[j] = state.face.x[f];
        column.y[j] = state.face.y[f];
        column.z[j] = state.face.z[f];
        column.own_x[j] = state.own.x[f];
        column.own_y[j] = state.own.y[f];
        column.own_z[j] = state.own.z[f];
        column.distance[j] = state.distance[f];
    }
    return column;
}

/// Steps before the first group of `kGroupSteps` in which any pair wants to swap; all of them when
/// none does.
SPHEROSEG_WIDEST_VECTORS
int quiet_steps(const ChordSwapState& state, int first, const Column& column_in, int step_count) {
    const Column column = column_in;
    const float* const face_x = state.face.x.data();
    const float* const face_y = state.face.y.data();
    const float* const face_z = state.face.z.data();
    const float* const own_x = state.own.x.data();
    const float* const own_y = state.own.y.data();
    const float* const own_z = state.own.z.data();
    const float* const distance = state.distance.data();
    for (int step = 0; step + kGroupSteps <= step_count; step += kGroupSteps) {
        int wants_swap[kColumnFaces] = {};
        for (int i = step; i < step + kGroupSteps; ++i) {
            const int a = first - 2 * i;
            for (int j = 0; j < kColumnFaces; ++j) {
                const float d3 = chord(face_x[a + j],
                                       face_y[a + j],
                                       face_z[a + j],
                                       column.own_x[j],
                                       column.own_y[j],
                                       column.own_z[j]);
                const float d4 = chord(column.x[j],
                                       column.y[j],
                                       column.z[j],
                                       own_x[a + j],
                                       own_y[a + j],
                                       own_z[a + j]);
                wants_swap[j] |= distance[a + j] + column.distance[j] > d3 + d4 ? 1 : 0;
            }
        }
        int any = 0;
        for (int j = 0; j < kColumnFaces; ++j) {
            any |= wants_swap[j];
        }
        if (any != 0) {
            return step;
        }
    }
    return step_count - step_count % kGroupSteps;
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

int swap_column(ChordSwapState& state, int first, int second, int step_count) {
    int swap_count = 0;
    int step = 0;
    while (step < step_count) {
        const Column column = load_column(state, second);
        step += quiet_steps(state, first - 2 * step, column, step_count - step);
        const int group_end = std::min(step + kGroupSteps, step_count);
        for (; step < group_end; ++step) {
            swap_count += swap_run(state, {first - 2 * step, second, kColumnFaces});
        }
    }
    return swap_count;
}

} // namespace spheroseg
