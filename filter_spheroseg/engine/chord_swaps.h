// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "round_robin.h"
#include "types.h"

namespace spheroseg {

/// Three coordinates in arrays of their own, in single precision.
struct PointArrays {
    std::vector<float> x;
    std::vector<float> y;
    std::vector<float> z;

    void resize(std::size_t count) {
        x.resize(count);
        y.resize(count);
        z.resize(count);
    }
    void set(int i, const Vec3& p) {
        x[i] = static_cast<float>(p.x);
        y[i] = static_cast<float>(p.y);
        z[i] = static_cast<float>(p.z);
    }
    void copy(int i, const PointArrays& from, int j) {
        x[i] = from.x[j];
        y[i] = from.y[j];
        z[i] = from.z[j];
    }
    void exchange(int i, int j) {
        std::swap(x[i], x[j]);
        std::swap(y[i], y[j]);
        std::swap(z[i], z[j]);
    }
};

/// Distance in single precision, the same bits wherever it is used.
inline float chord(float ax, float ay, float az, float bx, float by, float bz) {
    const float dx = ax - bx;
    const float dy = ay - by;
    const float dz = az - bz;
    return std::sqrt(dx * dx + dy * dy + dz * dz);
}

/// State of the pair swaps of cohesion. Each face carries the centroid of its sub-mesh and its
/// distance to it, so that a run of pairs reads nothing but neighbouring numbers: 14 floats and 21
/// operations per pair, no look-up by label. Faces with the same label need no test: their
/// distances are equal before and after, so the strict comparison fails.
struct ChordSwapState {
    PointArrays face;            // centroids of the faces
    PointArrays own;             // centroids of the sub-meshes that the faces belong to
    std::vector<float> distance; // |face - own|
    std::vector<int> label;

    int face_count() const { return static_cast<int>(label.size()); }
};

/// Recomputes every `distance`.
void measure_distances(ChordSwapState& state);

/// Algorithm 1 on each pair of a run, whose faces are all different. Returns the number of swaps.
int swap_run(ChordSwapState& state, const PairRun& run);

/// Faces that stay in one tile of `swap_column`.
constexpr int kColumnFaces = 16;

/// Plays `step_count` rounds of 16 slots: step i meets (first - 2 i + j, second - j) for j in
/// [0, 16), so that the second faces stay and the first ones slide down. Returns the number of
/// swaps. Same result as `swap_run` on each step in turn.
int swap_column(ChordSwapState& state, int first, int second, int step_count);

} // namespace spheroseg
