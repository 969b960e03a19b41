// SPDX-License-Identifier: GPL-3.0-or-later
#include "all_pairs_refinement.h"

#include "measures.h"
#include "parallel_failure.h"
#include "refinement_cost.h"
#include "swap_rounds.h"
#include "threads.h"
#include "yielding_barrier.h"

#include <algorithm>
#include <optional>

namespace spheroseg {

namespace {

constexpr long long kPairsPerReport = 1LL << 28;
/// A thread with fewer slots than this would mostly wait at the end of each round.
constexpr int kMinSlotsPerThread = 4096;
constexpr int kBlockSize = 256;

struct FacePair {
    int a;
    int b;
};

class Refinement {
public:
    Refinement(const DualGraph& dual_graph, std::vector<int>& labels)
        : dual_graph_(dual_graph), labels_(labels), schedule_(dual_graph.face_count()),
          bounds_(labels.size()), stamps_(labels.size(), 0) {
        for (int f = 0; f < dual_graph.face_count(); ++f) {
            bounds_[f] = gain_bound(dual_graph_, labels_.data(), f);
        }
    }

    const RoundRobin& schedule() const { return schedule_; }

    /// Plays the rounds [round_begin, round_end) and returns the number of swaps.
    long long play_rounds(int round_begin, int round_end, int threads) {
        std::vector<std::vector<FacePair>> decided(threads);
        long long swap_count = 0;
        std::optional<YieldingBarrier> barrier;
        ParallelFailure failure;
#pragma omp parallel num_threads(threads)
        {
            const int team = omp_get_num_threads();
#pragma omp single
            barrier.emplace(team);
            const int member = omp_get_thread_num();
            const long long slots = schedule_.slot_count();
            const int slot_begin = static_cast<int>(slots * member / team);
            const int slot_end = static_cast<int>(slots * (member + 1) / team);
            for (int round = round_begin; round < round_end; ++round) {
                std::vector<FacePair>& own = decided[member];
                own.clear();
                failure.guard([&] {
                    schedule_.for_each_run(
                        round, slot_begin, slot_end, [&](const PairRun& run) { decide(run, own); });
                });
                barrier->wait();
#pragma omp master
                swap_count += commit(decided);
                barrier->wait();
            }
        }
        failure.rethrow();
        return swap_count;
    }

private:
    /// Appends the pairs of a run that would swap, in the order of the slots.
    void decide(const PairRun& run, std::vector<FacePair>& decided) const {
        for (int begin = 0; begin < run.count; begin += kBlockSize) {
            const int first = run.first + begin;
            const int second = run.second - begin;
            const int count = std::min(kBlockSize, run.count - begin);
            const GainBound* bounds_a = bounds_.data() + first;
            const GainBound* bounds_b = bounds_.data() + second;
            GainBound most = -128;
            for (int i = 0; i < count; ++i) {
                const auto sum = static_cast<GainBound>(bounds_a[i] + bounds_b[-i]);
                most = std::max(most, sum);
            }
            if (most <= 0) {
                continue;
            }
            for (int i = 0; i < count; ++i) {
                if (bounds_a[i] + bounds_b[-i] > 0 &&
                    swaps(dual_graph_, labels_.data(), first + i, second - i)) {
                    decided.push_back({first + i, second - i});
                }
            }
        }
    }

    long long commit(const std::vector<std::vector<FacePair>>& decided) {
        ++stamp_;
        long long swap_count = 0;
        for (const std::vector<FacePair>& pairs : decided) {
            for (const FacePair& pair : pairs) {
                const bool yields = is_near_stamped(pair.a) || is_near_stamped(pair.b);
                stamps_[pair.a] = stamp_;
                stamps_[pair.b] = stamp_;
                if (!yields) {
                    std::swap(labels_[pair.a], labels_[pair.b]);
                    update_bounds_near(pair.a);
                    update_bounds_near(pair.b);
                    ++swap_count;
                }
            }
        }
        return swap_count;
    }

    bool is_near_stamped(int face) const {
        bool found = false;
        visit_within_two_steps(
            dual_graph_, face, [&](int f) { found = found || stamps_[f] == stamp_; });
        return found;
    }

    void update_bounds_near(int face) {
        visit_within_two_steps(dual_graph_, face, [&](int f) {
            bounds_[f] = gain_bound(dual_graph_, labels_.data(), f);
        });
    }

    const DualGraph& dual_graph_;
    std::vector<int>& labels_;
    RoundRobin schedule_;
    std::vector<GainBound> bounds_;
    /// Last commit in which a pair with this face was decided.
    std::vector<long long> stamps_;
    long long stamp_ = 0;
};

} // namespace

double refinement_energy(const DualGraph& dual_graph, const std::vector<int>& labels) {
    double energy = 0.0;
    for (int f = 0; f < dual_graph.face_count(); ++f) {
        energy += refinement_cost(dual_graph, labels, f, labels[f]);
    }
    return energy;
}

SwapIterations refine_all_pairs(const DualGraph& dual_graph,
                                const SwapLimits& limits,
                                std::vector<int>& labels,
                                const Progress& progress) {
    SwapIterations history;
    Refinement refinement(dual_graph, labels);
    const RoundRobin& schedule = refinement.schedule();
    const int threads = threads_for(limits.thread_count, schedule.slot_count(), kMinSlotsPerThread);
    const std::unique_ptr<SwapRounds> device =
        limits.device != nullptr ? limits.device->begin_refinement(dual_graph, labels) : nullptr;
    double boundary = count_boundary_edges(dual_graph, labels);
    for (bool converged = false; !converged && !history.time_limit_hit;) {
        if (limits.max_iterations > 0 && history.count() >= limits.max_iterations) {
            break;
        }
        const StopWatch watch;
        const std::vector<int> before = labels;
        bool complete = true;
        const IterationOverRounds iteration{
            "Refinement", history.count(), schedule, kPairsPerReport};
        const long long swap_count = iteration.play(
            device.get(), limits, progress, complete, [&](int round_begin, int round_end) {
                return refinement.play_rounds(round_begin, round_end, threads);
            });
        if (device) {
            device->read_labels(labels);
        }
        const double now = count_boundary_edges(dual_graph, labels);
        converged = now >= boundary;
        if (converged) {
            labels = before;
        } else {
            boundary = now;
        }
        history.boundary_edges.push_back(boundary);
        history.swaps.push_back(static_cast<double>(swap_count));
        history.energy.push_back(refinement_energy(dual_graph, labels));
        history.seconds.push_back(watch.elapsed_seconds());
        history.time_limit_hit = !complete;
    }
    return history;
}

} // namespace spheroseg
