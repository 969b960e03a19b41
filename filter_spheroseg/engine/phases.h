// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"
#include "boundary.h"
#include "metropolis.h"
#include "parallel_failure.h"
#include "random.h"
#include "threads.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

/// Single moves that cost one edge are not even tried with an allowance below this.
constexpr double kLikelyCost = 0.5;

/// The corner to draw among the sides (bit c: the one at corner c) that touch another sub-mesh: the
/// first one from a random corner on.
constexpr std::int8_t kCornerOfSides[8][3] = {
    {0, 0, 0}, {0, 0, 0}, {1, 1, 1}, {0, 1, 0}, {2, 2, 2}, {0, 2, 2}, {1, 1, 2}, {0, 1, 2}};

/// The settings of one phase of an annealing.
struct Phase {
    double temperature;
    /// Per squared unit of load.
    double balance_weight;
    double proposals_per_face;
    std::uint64_t seed;
};

/// Draws proposals for one group: a random face of its boundary, a corner, single face or fan.
class ProposalSource {
public:
    ProposalSource(Patchwork& patchwork,
                   BoundaryFaces& boundary,
                   Grouping& grouping,
                   int group,
                   const Phase& phase)
        : patchwork_(patchwork), boundary_(boundary), group_of_label_(grouping.group_of_label()),
          group_(group), grouping_(grouping), faces_(std::move(grouping.faces(group))),
          phase_(phase), random_(phase.seed, static_cast<std::uint64_t>(group)) {}
    ~ProposalSource() { grouping_.faces(group_) = std::move(faces_); }

    struct Proposal {
        int face;
        int corner;
        bool as_fan;
        bool forward;
        /// The most that the move may cost.
        double allowance;
    };

    /// False when the face drawn touches no other sub-mesh any more (it is unlisted), or the one
    /// drawn with it belongs to another group.
    bool draw(Proposal& proposal) {
        const std::uint64_t bits = random_.next();
        const auto count = static_cast<std::uint64_t>(faces_.size());
        const auto index = static_cast<std::size_t>(((bits >> 32) * count) >> 32);
        proposal.face = faces_[index];
        const int label = patchwork_.label(proposal.face);
        const Cell& cell = patchwork_.cells[proposal.face];
        const int across[3] = {patchwork_.label_across(cell, 0),
                               patchwork_.label_across(cell, 1),
                               patchwork_.label_across(cell, 2)};
        const auto differs = [&](int c) {
            return static_cast<unsigned>(across[c] >= 0 && across[c] != label);
        };
        const unsigned sides = differs(0) | differs(1) << 1 | differs(2) << 2;
        if (sides == 0) {
            boundary_.unlist(proposal.face);
            faces_[index] = faces_.back();
            faces_.pop_back();
            return false;
        }
        proposal.allowance = phase_.temperature * ExponentialQuantiles::get()(bits >> 8);
        proposal.forward = (bits >> 25) & 1;
        proposal.corner = kCornerOfSides[sides][(bits & 0xFF) * 3 >> 8];
        const int to = across[proposal.corner];
        if (group_of_label_[to] != group_) {
            return false;
        }
        // A face that touches its own sub-mesh by two edges adds a boundary edge when it leaves.
        const bool sits_deep = (sides & (sides - 1)) == 0;
        proposal.as_fan = ((bits >> 24) & 1) || (sits_deep && proposal.allowance < kLikelyCost);
        return true;
    }

    const std::vector<int>& faces() const { return faces_; }
    std::int64_t proposal_count() const {
        return static_cast<std::int64_t>(phase_.proposals_per_face *
                                         static_cast<double>(faces_.size()));
    }
    bool exhausted() const { return faces_.empty(); }
    Random& random() { return random_; }

    int load(int label) const { return grouping_.load(label); }

    void apply(const Move& move) { relabel(move, move.from, move.to); }
    void undo(const Move& move) { relabel(move, move.to, move.from); }

    /// Lists the faces that came to the boundary when a move was made.
    void list(const Move& move) {
        for (int i = 0; i < move.face_count; ++i) {
            boundary_.list_neighbors(patchwork_, move.faces[i], move.from, faces_);
        }
    }

private:
    void relabel(const Move& move, int from, int to) {
        for (int i = 0; i < move.face_count; ++i) {
            patchwork_.set_label(move.faces[i], to);
        }
        grouping_.load(from) -= move.weight;
        grouping_.load(to) += move.weight;
    }

    Patchwork& patchwork_;
    BoundaryFaces& boundary_;
    const std::vector<int>& group_of_label_;
    const int group_;
    Grouping& grouping_;
    std::vector<int> faces_;
    const Phase& phase_;
    Random random_;
};

/// Runs the phases of a schedule: new groups of labels in each, all groups in parallel.
/// `run_group(grouping, boundary, group, phase)` anneals one group and returns the change of the
/// number of boundary edges that it made.
template <typename RunGroup>
void run_phases(Patchwork& patchwork,
                const AnnealSchedule& schedule,
                double mean_face_weight,
                const AnnealControl& control,
                const char* step,
                RunGroup run_group) {
    const int threads = resolve_thread_count(schedule.thread_count);
    BoundaryFaces boundary(patchwork, threads);
    std::int64_t edges = count_boundary_edges(patchwork, threads);
    Grouping grouping;
    const int phases = std::max(1, schedule.phase_count);
    for (int p = 0; p < phases; ++p) {
        if (p >= control.max_phases || (control.deadline && control.deadline->expired())) {
            return;
        }
        report_progress(control.progress, static_cast<double>(p) / phases, step);
        const Deadline watch;
        const double at = phases > 1 ? static_cast<double>(p) / (phases - 1) : 1.0;
        const auto between = [at](double begin, double end) {
            return begin * std::pow(end / begin, at);
        };
        Phase phase;
        phase.temperature = between(schedule.temperature_begin, schedule.temperature_end);
        phase.balance_weight = between(schedule.balance_weight_begin, schedule.balance_weight_end) /
            (mean_face_weight * mean_face_weight);
        phase.proposals_per_face = schedule.proposals_per_face / phases;
        phase.seed = schedule.seed * 0x9E3779B97F4A7C15ULL + static_cast<std::uint64_t>(p);

        grouping.regroup(patchwork, boundary, phase.seed, threads);
        const std::vector<int> groups = grouping.largest_first();
        const int group_count = grouping.group_count();
        std::int64_t change = 0;
        ParallelFailure failure;
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) reduction(+ : change)
        for (int i = 0; i < group_count; ++i) {
            failure.guard([&] { change += run_group(grouping, boundary, groups[i], phase); });
        }
        failure.rethrow();
        grouping.collect(patchwork, boundary);
        edges += change;
        if (control.boundary_edges) {
            control.boundary_edges->push_back(static_cast<double>(edges));
            control.seconds->push_back(watch.elapsed_seconds());
        }
    }
}

} // namespace spheroseg
