// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// Annealing of groups of sub-meshes, a block for each. As in cohesion_kernels.cuh, the tests
// compile this source for the host too.

#include "anneal_arrays.h"

namespace spheroseg::cuda {

namespace { // the tests' emulation has kernels of the same names

/// The `Patches` of cell.h. Blocks read labels of faces that other blocks move, without order: any
/// value they see is a label of another group, and nothing depends on which.
struct DevicePatches {
    const Cell* cells;
    int* labels;
    bool may_close_rings;

    __device__ int label(int face) const { return labels[face]; }
    __device__ int weight(int face) const { return cells[face].weight; }
    __device__ int neighbor(int face, int corner) const {
        return face_of(cells[face].side[corner]);
    }
    __device__ int label_across(int face, int corner) const {
        const int other = neighbor(face, corner);
        return other < 0 ? kOpenBorder : labels[other];
    }
    __device__ Step step_from(const Step& step) const {
        return step_across(step, cells[step.face].side[step.exit]);
    }
};

/// What the threads of a block share.
struct GroupState {
    Random random;
    int face_count;
    /// The first thread whose proposal changes something, of even and of odd batches.
    int first[2];
};

constexpr int kNoThread = 0x7fffffff;

/// The `Group` of group_moves.h. One thread at a time makes moves.
class DeviceGroup {
public:
    __device__ DeviceGroup(const AnnealArrays& arrays, GroupState& state, int group)
        : arrays_(arrays), state_(state),
          faces_(arrays.faces + arrays.face_begin[group]), patches_{arrays.cells,
                                                                    arrays.labels,
                                                                    arrays.may_close_rings} {}

    __device__ const DevicePatches& patches() const { return patches_; }
    __device__ int load(int label) const { return arrays_.loads[label]; }
    __device__ Random& random() { return state_.random; }
    __device__ int face(int index) const { return faces_[index]; }

    __device__ void apply(const Move& move) { relabel(move, move.from, move.to); }
    __device__ void undo(const Move& move) { relabel(move, move.to, move.from); }

    /// Lists the faces that came to the boundary when a move was made.
    __device__ void list(const Move& move) {
        for (int i = 0; i < move.face_count; ++i) {
            list(move.faces[i]);
            for (int c = 0; c < 3; ++c) {
                if (patches_.label_across(move.faces[i], c) == move.from) {
                    list(patches_.neighbor(move.faces[i], c));
                }
            }
        }
    }
    __device__ void unlist(int index) {
        arrays_.listed[faces_[index]] = 0;
        faces_[index] = faces_[--state_.face_count];
    }

    __device__ int partner_count(int label) const { return arrays_.partner_counts[label]; }
    __device__ int partner(int label, int index) const {
        return arrays_.partners[arrays_.partner_begin[label] + index];
    }
    __device__ void drop_partner(int label, int index) {
        int* const list = arrays_.partners + arrays_.partner_begin[label];
        list[index] = list[--arrays_.partner_counts[label]];
    }
    __device__ void add_partner(int label, int face) {
        const long long begin = arrays_.partner_begin[label];
        int& count = arrays_.partner_counts[label];
        if (begin + count < arrays_.partner_begin[label + 1]) {
            arrays_.partners[begin + count++] = face;
        }
    }

private:
    __device__ void list(int face) {
        if (!arrays_.listed[face]) {
            arrays_.listed[face] = 1;
            faces_[state_.face_count++] = face;
        }
    }

    __device__ void relabel(const Move& move, int from, int to) {
        for (int i = 0; i < move.face_count; ++i) {
            arrays_.labels[move.faces[i]] = to;
        }
        arrays_.loads[from] -= move.weight;
        arrays_.loads[to] += move.weight;
        arrays_.cell_counts[from] -= move.face_count;
        arrays_.cell_counts[to] += move.face_count;
    }

    const AnnealArrays& arrays_;
    GroupState& state_;
    int* const faces_;
    const DevicePatches patches_;
};

/// Makes the proposals of one group in the order of the cores: each thread judges one of the next
/// proposals on the labels as they are, and the first that changes something is made. Those before
/// it change nothing, so they are done; those after it are judged again.
template <typename Loads>
__device__ void anneal_group(const AnnealArrays& arrays, const Phase& phase, const Loads& loads) {
    SPHEROSEG_DYNAMIC_SHARED(GroupState, state);
    const int group = arrays.order[blockIdx.x];
    const int thread = static_cast<int>(threadIdx.x);
    const int thread_count = static_cast<int>(blockDim.x);
    if (thread == 0) {
        state->random = Random(phase.seed, static_cast<std::uint64_t>(group));
        state->face_count = arrays.face_counts[group];
        state->first[0] = state->first[1] = kNoThread;
    }
    __syncthreads();
    DeviceGroup work(arrays, *state, group);
    const GroupRules rules{arrays.group_of_label, arrays.quantiles, group, phase.temperature};
    std::int64_t left = proposal_count(phase.proposals_per_face, state->face_count);
    long long change = 0;
    for (int batch = 0; left > 0 && state->face_count > 0; batch ^= 1) {
        const int tried = left < thread_count ? static_cast<int>(left) : thread_count;
        Proposal proposal;
        Fan fan;
        Drawn drawn = Drawn::nothing;
        int index = 0;
        if (thread < tried) {
            const std::uint64_t bits = state->random.after(thread);
            index = index_of(bits, state->face_count);
            drawn = draw_proposal(work.patches(), rules, work.face(index), bits, proposal);
            if (drawn == Drawn::stale ||
                (drawn == Drawn::proposal && loads.wants(work, proposal, fan))) {
                atomicMin(&state->first[batch], thread);
            }
        }
        __syncthreads();
        const int first = state->first[batch];
        const int done = first < tried ? first + 1 : tried;
        if (thread == (first < tried ? first : 0)) {
            state->random.skip(done);
            if (first < tried && drawn == Drawn::stale) {
                work.unlist(index);
            } else if (first < tried) {
                change += loads.make(work, proposal, fan);
            }
            state->first[batch ^ 1] = kNoThread;
        }
        left -= done;
        __syncthreads();
    }
    if (thread == 0) {
        arrays.face_counts[group] = state->face_count;
    }
    atomicAdd(arrays.change, static_cast<unsigned long long>(change));
}

// The 1 allows more than the 128 registers that nvcc chooses for so few threads: no spills.
__global__ void __launch_bounds__(kAnnealThreads, 1)
    anneal_groups(AnnealArrays arrays, Phase phase, FreeLoads loads) {
    anneal_group(arrays, phase, loads);
}

__global__ void __launch_bounds__(kAnnealThreads, 1)
    exchange_groups(AnnealArrays arrays, Phase phase, BoundedLoads loads) {
    anneal_group(arrays, phase, loads);
}

} // namespace

} // namespace spheroseg::cuda
