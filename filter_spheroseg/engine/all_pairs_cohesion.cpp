// SPDX-License-Identifier: GPL-3.0-or-later
#include "all_pairs_cohesion.h"

#include "cohesion_state.h"
#include "measures.h"
#include "random.h"
#include "swap_rounds.h"
#include "threads.h"
#include "yielding_barrier.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace spheroseg {

namespace {

constexpr long long kPairsPerReport = 1LL << 26;
/// A thread with fewer slots than this would mostly wait at the end of each round.
constexpr int kMinSlotsPerThread = 512;
/// Slots of a thread per round that it plays ahead of the others.
constexpr int kWedgeShare = 8;
/// Length of the random offset that parts coinciding centroids.
constexpr double kOffsetLength = 1e-3;

/// Shifts the centroids that coincide with another one. False when there are none.
bool part_coinciding_centroids(PointArrays& centroids, std::uint64_t seed) {
    std::vector<int> order(centroids.x.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int s) {
        return std::array{centroids.x[s], centroids.y[s], centroids.z[s]};
    };
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
    std::vector<int> coinciding;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool as_before = i > 0 && key(order[i]) == key(order[i - 1]);
        const bool as_after = i + 1 < order.size() && key(order[i]) == key(order[i + 1]);
        if (as_before || as_after) {
            coinciding.push_back(order[i]);
        }
    }
    for (int s : coinciding) {
        Random random(seed, s);
        const Vec3 direction =
            unit_or_zero({random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5});
        const Vec3 centroid{centroids.x[s], centroids.y[s], centroids.z[s]};
        centroids.set(s, unit_or_zero(centroid + direction * kOffsetLength));
    }
    return !coinciding.empty();
}

/// Plays the rounds [round_begin, round_end) and returns the number of swaps.
///
/// Slot j of a round meets the elements that slots j - 1, j and j + 1 met in the round before, so
/// that a thread can play many rounds of its own slots ahead, leaving out one more slot per round
/// at each end that it shares; after a barrier the wedges so left out are played. For the same
/// reason it can play them tile by tile, each tile one slot lower in every round, so that one
/// of the two faces of each pair stays. The order of the meetings of every element is
/// that of the rounds, whatever the number of threads.
long long play_rounds(ChordSwapState& state,
                      const RoundRobin& schedule,
                      int round_begin,
                      int round_end,
                      int threads) {
    long long swap_count = 0;
    const long long slots = schedule.slot_count();
    std::optional<YieldingBarrier> barrier;
#pragma omp parallel num_threads(threads) reduction(+ : swap_count)
    {
        const int team = omp_get_num_threads();
#pragma omp single
        barrier.emplace(team);
        const int member = omp_get_thread_num();
        const int slot_begin = static_cast<int>(slots * member / team);
        const int slot_end = static_cast<int>(slots * (member + 1) / team);
        const int rounds_ahead = static_cast<int>(std::max(1LL, slots / team / kWedgeShare));
        const auto play = [&](int round, int begin, int end) {
            schedule.for_each_run(
                round, begin, end, [&](const PairRun& run) { swap_count += swap_run(state, run); });
        };
        for (int first = round_begin; first < round_end; first += rounds_ahead) {
            const int last = std::min(first + rounds_ahead, round_end);
            for (int tile = slot_begin; tile < slot_end + rounds_ahead; tile += kColumnFaces) {
                for (int round = first; round < last;) {
                    const int ahead = round - first;
                    const int begin = member == 0 ? 0 : slot_begin + ahead;
                    const int end = member == team - 1 ? slot_end : slot_end - ahead;
                    const int slot = tile - ahead;
                    PairRun run;
                    int steps = 0;
                    if (slot >= begin && slot + kColumnFaces <= end) {
                        // The slots of a column that shares its lower end leave the thread's share.
                        const int within = member == 0 ? last - round : (slot - begin) / 2 + 1;
                        steps = schedule.sliding_run(
                            round, slot, kColumnFaces, std::min(within, last - round), run);
                    }
                    if (steps > 0) {
                        swap_count += swap_column(state, run.first, run.second, steps);
                        round += steps;
                    } else {
                        play(round, std::max(begin, slot), std::min(end, slot + kColumnFaces));
                        ++round;
                    }
                }
            }
            barrier->wait();
            for (int round = first; round < last && member > 0; ++round) {
                play(round, slot_begin - (round - first), slot_begin + (round - first));
            }
            barrier->wait();
        }
    }
    return swap_count;
}

} // namespace

std::vector<int> random_balanced_labels(int face_count, int submesh_count, std::uint64_t seed) {
    std::vector<int> labels(face_count);
    for (int f = 0; f < face_count; ++f) {
        labels[f] = f % submesh_count;
    }
    Random random(seed);
    for (int f = face_count - 1; f > 0; --f) {
        std::swap(labels[f], labels[random.below(f + 1)]);
    }
    return labels;
}

SwapIterations cohere_all_pairs(const DualGraph& dual_graph,
                                const std::vector<Vec3>& face_centroids,
                                int submesh_count,
                                std::uint64_t seed,
                                const SwapLimits& limits,
                                std::vector<int>& labels,
                                const Progress& progress) {
    SwapIterations history;
    ChordSwapState state = make_cohesion_state(face_centroids, labels);
    PointArrays centroids = submesh_centroids(state, submesh_count);
    assign_centroids(state, centroids);
    const std::unique_ptr<CohesionRounds> device = limits.device != nullptr
        ? limits.device->begin_cohesion(state.face, state.label, submesh_count)
        : nullptr;
    const RoundRobin schedule(state.face_count());
    const int threads = threads_for(limits.thread_count, schedule.slot_count(), kMinSlotsPerThread);
    LeastEnergy least_energy(energy_of(state));
    bool offset_used = false;
    bool converged = submesh_count < 2;
    while (!converged) {
        if (limits.max_iterations > 0 && history.count() >= limits.max_iterations) {
            break;
        }
        const StopWatch watch;
        bool complete = true;
        if (device) {
            device->set_centroids(centroids);
        }
        const IterationOverRounds iteration{"Cohesion", history.count(), schedule, kPairsPerReport};
        const long long swap_count = iteration.play(
            device.get(), limits, progress, complete, [&](int round_begin, int round_end) {
                return play_rounds(state, schedule, round_begin, round_end, threads);
            });
        if (device) {
            device->read_labels(state.label);
        }
        centroids = submesh_centroids(state, submesh_count);
        converged = complete && swap_count == 0;
        if (converged && !offset_used && part_coinciding_centroids(centroids, seed)) {
            offset_used = true;
            converged = false;
        }
        assign_centroids(state, centroids);
        history.boundary_edges.push_back(count_boundary_edges(dual_graph, state.label));
        history.swaps.push_back(static_cast<double>(swap_count));
        history.energy.push_back(energy_of(state));
        history.seconds.push_back(watch.elapsed_seconds());
        converged = !least_energy.may_fall_after(history.energy.back()) || converged;
        if (!complete) {
            history.time_limit_hit = true;
            break;
        }
    }
    labels = state.label;
    return history;
}

} // namespace spheroseg
