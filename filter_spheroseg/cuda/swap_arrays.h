// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

/// What the kernels read and write. All pointers are those of the device.
namespace spheroseg::cuda {

struct CohesionArrays {
    const float* face_x; // centroids of the faces
    const float* face_y;
    const float* face_z;
    const float* submesh_x; // centroids of the sub-meshes
    const float* submesh_y;
    const float* submesh_z;
    int* labels;
    unsigned long long* swap_count;
};

/// Where the refinement is. The kernels move it on, so that the host need not wait for each swap.
struct RefinementCursor {
    int next_round;
    int round_end;
    int found_round;   // first round of the batch in which a pair swaps; kNoRound: none so far
    int decided_count; // pairs of `found_round` that want to swap
    unsigned int commit_count;
    int reserved;
    unsigned long long swap_count;
};

constexpr int kNoRound = 0x7fffffff;

struct RefinementArrays {
    const int* neighbors; // three per face, -1 on an open border
    int* labels;
    signed char* bounds;
    /// Commit in which a pair of this face was decided last, and its slot: commit << 32 | slot.
    unsigned long long* stamps;
    int* decided; // slots, in any order
    RefinementCursor* cursor;
    int face_count;
};

/// Threads of a block. Fixed, since the compiler bounds registers by it.
constexpr int kCohesionThreads = 512;
constexpr int kScanThreads = 256;
constexpr int kCommitThreads = 512;
/// Slots that a thread of the scanning kernels looks at.
constexpr int kSlotsPerScanThread = 4;
/// Floats and ints that a tile of cohesion keeps per element in shared memory.
constexpr int kTileWords = 8;
/// Numbers of rounds that it keeps there besides.
constexpr int kFoundRounds = 3;

/// Shared memory of a tile of at most `capacity` elements.
constexpr std::size_t tile_bytes(int capacity) {
    return sizeof(float) * kTileWords * capacity + sizeof(int) * kFoundRounds;
}

} // namespace spheroseg::cuda
