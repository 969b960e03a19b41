// SPDX-License-Identifier: GPL-3.0-or-later
#include "device_swaps.h"

#include <algorithm>

namespace spheroseg::cuda {

namespace {

class DeviceCohesion : public CohesionRounds {
public:
    DeviceCohesion(Device& device,
                   const SwapTuning& tuning,
                   const PointArrays& faces,
                   const std::vector<int>& labels,
                   int submesh_count)
        : device_(device), tuning_(tuning), face_count_(static_cast<int>(labels.size())),
          block_count_(
              cohesion_block_count(face_count_, device.info().multiprocessor_count, tuning)),
          face_x_(device, faces.x), face_y_(device, faces.y), face_z_(device, faces.z),
          submesh_x_(device, submesh_count), submesh_y_(device, submesh_count),
          submesh_z_(device, submesh_count), labels_(device, labels), swap_count_(device, 1) {}

    void set_centroids(const PointArrays& centroids) override {
        submesh_x_.upload(centroids.x);
        submesh_y_.upload(centroids.y);
        submesh_z_.upload(centroids.z);
    }

    int rounds_per_report() const override {
        return rounds_per_phase(face_count_, block_count_) * tuning_.phases_per_report;
    }

    long long play(int round_begin, int round_end) override {
        const CohesionArrays arrays{face_x_.data(),
                                    face_y_.data(),
                                    face_z_.data(),
                                    submesh_x_.data(),
                                    submesh_y_.data(),
                                    submesh_z_.data(),
                                    labels_.data(),
                                    swap_count_.data()};
        const int capacity = most_tile_elements(face_count_, block_count_);
        const int phase_rounds = rounds_per_phase(face_count_, block_count_);
        swap_count_.clear();
        for (int round = round_begin; round < round_end; round += phase_rounds) {
            const int count = std::min(phase_rounds, round_end - round);
            TilePhase phase{face_count_, block_count_, round, count, false};
            device_.play_cohesion_tiles(arrays, phase, capacity);
            // The wedges have no slot in the first of their rounds.
            if (block_count_ > 1 && count > 1) {
                phase.wedges = true;
                device_.play_cohesion_tiles(arrays, phase, capacity);
            }
        }
        std::vector<unsigned long long> swap_count;
        swap_count_.download(swap_count);
        return static_cast<long long>(swap_count.front());
    }

    void read_labels(std::vector<int>& labels) override { labels_.download(labels); }

private:
    Device& device_;
    SwapTuning tuning_;
    int face_count_;
    int block_count_;
    DeviceArray<float> face_x_;
    DeviceArray<float> face_y_;
    DeviceArray<float> face_z_;
    DeviceArray<float> submesh_x_;
    DeviceArray<float> submesh_y_;
    DeviceArray<float> submesh_z_;
    DeviceArray<int> labels_;
    DeviceArray<unsigned long long> swap_count_;
};

std::vector<int> flat_neighbors(const DualGraph& dual_graph) {
    std::vector<int> flat;
    flat.reserve(3 * dual_graph.neighbors.size());
    for (const auto& neighbors : dual_graph.neighbors) {
        flat.insert(flat.end(), neighbors.begin(), neighbors.end());
    }
    return flat;
}

class DeviceRefinement : public SwapRounds {
public:
    DeviceRefinement(Device& device,
                     const SwapTuning& tuning,
                     const DualGraph& dual_graph,
                     const std::vector<int>& labels)
        : device_(device), tuning_(tuning), face_count_(dual_graph.face_count()),
          neighbors_(device, flat_neighbors(dual_graph)), labels_(device, labels),
          bounds_(device, labels.size()), stamps_(device, labels.size()),
          decided_(device, slot_count_of(face_count_)), cursor_(device, 1) {
        stamps_.clear();
        device_.measure_bounds(arrays());
    }

    int rounds_per_report() const override { return batch_rounds() * tuning_.batches_per_read; }

    long long play(int round_begin, int round_end) override {
        std::vector<RefinementCursor> cursor(1);
        cursor[0].next_round = round_begin;
        cursor[0].round_end = round_end;
        cursor[0].found_round = kNoRound;
        cursor[0].commit_count = commit_count_;
        cursor_.upload(cursor);
        while (cursor[0].next_round < round_end) {
            for (int i = 0; i < tuning_.batches_per_read; ++i) {
                device_.play_refinement_batch(arrays(), batch_rounds());
            }
            cursor_.download(cursor);
        }
        commit_count_ = cursor[0].commit_count;
        return static_cast<long long>(cursor[0].swap_count);
    }

    void read_labels(std::vector<int>& labels) override { labels_.download(labels); }

private:
    int batch_rounds() const {
        const long long slots = std::max(1, slot_count_of(face_count_));
        return static_cast<int>(std::clamp(tuning_.pairs_per_batch / slots, 1LL, 65535LL));
    }

    RefinementArrays arrays() const {
        return {neighbors_.data(),
                labels_.data(),
                bounds_.data(),
                stamps_.data(),
                decided_.data(),
                cursor_.data(),
                face_count_};
    }

    Device& device_;
    SwapTuning tuning_;
    int face_count_;
    unsigned int commit_count_ = 0;
    DeviceArray<int> neighbors_;
    DeviceArray<int> labels_;
    DeviceArray<signed char> bounds_;
    DeviceArray<unsigned long long> stamps_;
    DeviceArray<int> decided_;
    DeviceArray<RefinementCursor> cursor_;
};

} // namespace

int cohesion_block_count(int face_count, int multiprocessor_count, const SwapTuning& tuning) {
    const int slots = slot_count_of(face_count);
    const int even_share = slots / std::max(1, multiprocessor_count);
    const int per_block =
        std::clamp(even_share, tuning.min_slots_per_block, tuning.max_slots_per_block);
    return std::clamp((slots + per_block - 1) / per_block, std::min(2, slots), std::max(1, slots));
}

std::size_t cohesion_bytes(int face_count, int submesh_count) {
    return static_cast<std::size_t>(face_count) * (3 * sizeof(float) + sizeof(int)) +
        static_cast<std::size_t>(submesh_count) * 3 * sizeof(float) + sizeof(unsigned long long);
}

std::size_t refinement_bytes(int face_count) {
    return static_cast<std::size_t>(face_count) *
        (4 * sizeof(int) + sizeof(signed char) + sizeof(unsigned long long)) +
        static_cast<std::size_t>(slot_count_of(face_count)) * sizeof(int) +
        sizeof(RefinementCursor);
}

std::unique_ptr<CohesionRounds> DeviceSwaps::begin_cohesion(const PointArrays& faces,
                                                            const std::vector<int>& labels,
                                                            int submesh_count) {
    require_memory(
        *device_, cohesion_bytes(static_cast<int>(labels.size()), submesh_count), "cohesion");
    return std::make_unique<DeviceCohesion>(*device_, tuning_, faces, labels, submesh_count);
}

std::unique_ptr<SwapRounds> DeviceSwaps::begin_refinement(const DualGraph& dual_graph,
                                                          const std::vector<int>& labels) {
    require_memory(*device_, refinement_bytes(dual_graph.face_count()), "refinement");
    return std::make_unique<DeviceRefinement>(*device_, tuning_, dual_graph, labels);
}

} // namespace spheroseg::cuda
