// SPDX-License-Identifier: GPL-3.0-or-later
#include "free_annealing.h"

#include "boundary.h"
#include "proposals.h"

namespace spheroseg {

namespace {

class FreeAnnealer {
public:
    FreeAnnealer(Patchwork& patchwork, std::uint64_t seed)
        : patchwork_(patchwork), boundary_(patchwork, 1), faces_(boundary_.faces()),
          random_(seed, 0x66726565) {}

    /// `balance_weight` is that of squared units of load.
    void run_phase(double temperature, double balance_weight, double proposals_per_face) {
        auto left = proposal_count(proposals_per_face, static_cast<int>(faces_.size()));
        for (; left > 0 && !faces_.empty(); --left) {
            propose(temperature, balance_weight);
        }
    }

private:
    void propose(double temperature, double balance_weight) {
        const std::uint64_t bits = random_.next();
        const int index = index_of(bits, static_cast<int>(faces_.size()));
        const int face = faces_[index];
        const Cell& cell = patchwork_.cells[face];
        const int from = cell.label;
        int across[3];
        int others = 0;
        for (int c = 0; c < 3; ++c) {
            across[c] = patchwork_.label_across(face, c);
            others += across[c] >= 0 && across[c] != from;
        }
        if (others == 0) {
            boundary_.unlist_at(faces_, index);
            return;
        }
        int choice = static_cast<int>((bits & 0xFFFF) * others >> 16);
        int to = -1;
        for (int c = 0; to < 0; ++c) {
            if (across[c] >= 0 && across[c] != from && choice-- == 0) {
                to = across[c];
            }
        }
        int change = 0;
        for (int label : across) {
            change += (label == from) - (label == to);
        }
        std::vector<int>& load = patchwork_.load;
        const double imbalance = 2.0 * cell.weight * (load[to] - load[from] + cell.weight);
        const double allowance =
            temperature * exponential_quantiles()[bits >> 16 & (kQuantileCount - 1)];
        if (load[from] > cell.weight && change + balance_weight * imbalance <= allowance) {
            patchwork_.set_label(face, to);
            load[from] -= cell.weight;
            load[to] += cell.weight;
            boundary_.list_around(patchwork_, face, from, faces_);
        }
    }

    Patchwork& patchwork_;
    BoundaryFaces boundary_;
    std::vector<int>& faces_;
    Random random_;
};

} // namespace

void anneal_freely(Patchwork& patchwork, const AnnealSchedule& schedule, const Deadline& deadline) {
    const double face_weight = mean_face_weight(patchwork);
    FreeAnnealer annealer(patchwork, schedule.seed);
    for (int phase = 0; phase < schedule.phase_count && !deadline.expired(); ++phase) {
        annealer.run_phase(schedule.temperature(phase),
                           schedule.balance_weight(phase, face_weight),
                           schedule.proposals_per_face / schedule.phase_count);
    }
}

} // namespace spheroseg
