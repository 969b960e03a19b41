// SPDX-License-Identifier: GPL-3.0-or-later
#include "free_annealing.h"

#include "boundary.h"
#include "metropolis.h"
#include "random.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

class FreeAnnealer {
public:
    FreeAnnealer(Patchwork& patchwork, std::uint64_t seed)
        : patchwork_(patchwork), boundary_(patchwork, 1), faces_(boundary_.faces()),
          random_(seed, 0x66726565) {}

    /// `balance_weight` is that of squared units of load.
    void run_phase(double temperature, double balance_weight, double proposals_per_face) {
        const auto proposals = static_cast<std::int64_t>(proposals_per_face * faces_.size());
        for (std::int64_t i = 0; i < proposals && !faces_.empty(); ++i) {
            propose(temperature, balance_weight);
        }
    }

private:
    void propose(double temperature, double balance_weight) {
        const std::uint64_t bits = random_.next();
        const auto index = static_cast<std::size_t>(
            ((bits >> 32) * static_cast<std::uint64_t>(faces_.size())) >> 32);
        const int face = faces_[index];
        const Cell& cell = patchwork_.cells[face];
        const int from = cell.label;
        int across[3];
        int others = 0;
        for (int c = 0; c < 3; ++c) {
            across[c] = patchwork_.label_across(cell, c);
            others += across[c] >= 0 && across[c] != from;
        }
        if (others == 0) {
            boundary_.unlist(face);
            faces_[index] = faces_.back();
            faces_.pop_back();
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
            boundary_.list_neighbors(patchwork_, face, from, faces_);
        }
    }

    Patchwork& patchwork_;
    BoundaryFaces boundary_;
    std::vector<int>& faces_;
    Random random_;
};

} // namespace

void anneal_freely(Patchwork& patchwork, const AnnealSchedule& schedule, const Deadline& deadline) {
    const double mean_face_weight =
        mean_load(patchwork) * patchwork.submesh_count() / patchwork.face_count();
    FreeAnnealer annealer(patchwork, schedule.seed);
    for (int phase = 0; phase < schedule.phase_count && !deadline.expired(); ++phase) {
        const double at =
            schedule.phase_count > 1 ? static_cast<double>(phase) / (schedule.phase_count - 1) : 1;
        const auto between = [at](double begin, double end) {
            return begin * std::pow(end / begin, at);
        };
        annealer.run_phase(between(schedule.temperature_begin, schedule.temperature_end),
                           between(schedule.balance_weight_begin, schedule.balance_weight_end) /
                               (mean_face_weight * mean_face_weight),
                           schedule.proposals_per_face / schedule.phase_count);
    }
}

} // namespace spheroseg
