// SPDX-License-Identifier: GPL-3.0-or-later
#include "pair_cohesion.h"

#include "cohesion_state.h"
#include "measures.h"
#include "threads.h"
#include "yielding_barrier.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

namespace spheroseg {

namespace {

/// A thread with fewer faces than this would mostly wait at the end of each round.
constexpr int kMinFacesPerThread = 2048;
/// Makes up for the rounding of distances when they are compared by the triangle inequality.
constexpr double kRadiusSlack = 1.0 + 1e-5;

struct SubmeshPair {
    int first;
    int second;
};

/// A face that might move to the other sub-mesh of a pair.
struct Mover {
    double gain; // by how much the move would lower its distance
    int slot;    // its place among the members of its sub-mesh
};

/// What a thread needs for one pair at a time.
struct Scratch {
    std::vector<double> gains;
    std::vector<Mover> movers[2];
};

class PairCohesion {
public:
    PairCohesion(const std::vector<Vec3>& face_centroids,
                 const std::vector<int>& labels,
                 int submesh_count,
                 int thread_count)
        : state_(make_cohesion_state(face_centroids, labels)), submesh_count_(submesh_count),
          thread_count_(threads_for(thread_count, state_.face_count(), kMinFacesPerThread)),
          members_(submesh_count), changed_(submesh_count, 1) {
        for (int f = 0; f < state_.face_count(); ++f) {
            members_[labels[f]].push_back(f);
        }
        update_centroids();
    }

    const std::vector<int>& labels() const { return state_.label; }
    double energy() const { return energy_of(state_); }

    /// All pairs of sub-meshes meet once, then the centroids move. Returns the number of swaps.
    long long iterate() {
        const std::vector<std::vector<SubmeshPair>> rounds = schedule(near_pairs());
        std::fill(changed_.begin(), changed_.end(), 0);
        const long long swap_count = play(rounds);
        update_centroids();
        return swap_count;
    }

private:
    void update_centroids() {
        centroids_ = submesh_centroids(state_, submesh_count_);
        assign_centroids(state_, centroids_);
    }

    float distance_to(int face, int submesh) const {
        return chord(state_.face.x[face],
                     state_.face.y[face],
                     state_.face.z[face],
                     centroids_.x[submesh],
                     centroids_.y[submesh],
                     centroids_.z[submesh]);
    }

    float centroid_distance(const SubmeshPair& pair) const {
        return chord(centroids_.x[pair.first],
                     centroids_.y[pair.first],
                     centroids_.z[pair.first],
                     centroids_.x[pair.second],
                     centroids_.y[pair.second],
                     centroids_.z[pair.second]);
    }

    /// Pairs of sub-meshes, one of them changed in the last iteration, that may want to swap. By
    /// the triangle inequality a face at distance d from its centroid gains at most 2 d - D when
    /// the centroids are D apart: no swap helps unless D is below the sum of the largest distances.
    std::vector<SubmeshPair> near_pairs() const {
        std::vector<double> radius(submesh_count_, 0.0);
        for (int f = 0; f < state_.face_count(); ++f) {
            double& r = radius[state_.label[f]];
            r = std::max(r, state_.distance[f] * kRadiusSlack);
        }
        std::vector<int> order(submesh_count_);
        std::iota(order.begin(), order.end(), 0);
        const auto left_end = [&](int s) { return centroids_.x[s] - radius[s]; };
        std::stable_sort(
            order.begin(), order.end(), [&](int a, int b) { return left_end(a) < left_end(b); });
        std::vector<SubmeshPair> pairs;
        for (auto first = order.begin(); first != order.end(); ++first) {
            const double right_end = centroids_.x[*first] + radius[*first];
            for (auto second = first + 1; second != order.end() && left_end(*second) <= right_end;
                 ++second) {
                const SubmeshPair pair{*first, *second};
                if ((changed_[pair.first] || changed_[pair.second]) &&
                    centroid_distance(pair) < radius[pair.first] + radius[pair.second]) {
                    pairs.push_back(pair);
                }
            }
        }
        return pairs;
    }

    /// The pairs in the order of a round robin over all sub-meshes, each of them moved ahead to the
    /// first round when both are free: same outcome in fewer rounds.
    std::vector<std::vector<SubmeshPair>> schedule(const std::vector<SubmeshPair>& pairs) const {
        const RoundRobin round_robin(submesh_count_);
        std::vector<std::pair<int, int>> by_round; // round, index: all different
        by_round.reserve(pairs.size());
        for (int i = 0; i < static_cast<int>(pairs.size()); ++i) {
            by_round.emplace_back(round_robin.round_of(pairs[i].first, pairs[i].second), i);
        }
        std::sort(by_round.begin(), by_round.end());
        std::vector<int> free_from(submesh_count_, 0);
        std::vector<std::vector<SubmeshPair>> rounds;
        for (const auto& entry : by_round) {
            const SubmeshPair pair = pairs[entry.second];
            const int round = std::max(free_from[pair.first], free_from[pair.second]);
            free_from[pair.first] = free_from[pair.second] = round + 1;
            if (round == static_cast<int>(rounds.size())) {
                rounds.emplace_back();
            }
            rounds[round].push_back(pair);
        }
        return rounds;
    }

    /// Scratch space is made here: an exception must not leave the parallel region.
    long long play(const std::vector<std::vector<SubmeshPair>>& rounds) {
        std::size_t largest = 0;
        for (const std::vector<int>& faces : members_) {
            largest = std::max(largest, faces.size());
        }
        std::vector<Scratch> scratch(thread_count_);
        for (Scratch& own : scratch) {
            own.gains.resize(2 * largest);
            own.movers[0].reserve(largest);
            own.movers[1].reserve(largest);
        }
        long long swap_count = 0;
        std::optional<YieldingBarrier> barrier;
#pragma omp parallel num_threads(thread_count_) reduction(+ : swap_count)
        {
            const int team = omp_get_num_threads();
#pragma omp single
            barrier.emplace(team);
            const int member = omp_get_thread_num();
            for (const std::vector<SubmeshPair>& round : rounds) {
                for (std::size_t p = member; p < round.size(); p += team) {
                    swap_count += swap_between(round[p], scratch[member]);
                }
                barrier->wait();
            }
        }
        return swap_count;
    }

    /// Fills gains[0 ..) with what the faces of `from` would gain in `to`; returns the largest.
    double measure_gains(int from, int to, double* gains) const {
        double largest = -std::numeric_limits<double>::infinity();
        for (int face : members_[from]) {
            // Exact: distances in single precision that are not far below their rounding.
            const double gain = static_cast<double>(state_.distance[face]) - distance_to(face, to);
            largest = std::max(largest, gain);
            *gains++ = gain;
        }
        return largest;
    }

    /// Those whose gain is above `least`, largest first.
    static void
    select_movers(const double* gains, int count, double least, std::vector<Mover>& movers) {
        movers.clear();
        for (int slot = 0; slot < count; ++slot) {
            if (gains[slot] > least) {
                movers.push_back({gains[slot], slot});
            }
        }
        std::sort(movers.begin(), movers.end(), [](const Mover& a, const Mover& b) {
            return a.gain != b.gain ? a.gain > b.gain : a.slot < b.slot;
        });
    }

    /// Swaps faces of two sub-meshes from the largest gains down. Afterwards no swap between the
    /// two helps: what has moved would lose at least what the best of the rest could gain.
    int swap_between(const SubmeshPair& pair, Scratch& scratch) {
        const auto& [i, j] = pair;
        const int first_count = static_cast<int>(members_[i].size());
        const int second_count = static_cast<int>(members_[j].size());
        double* const first_gains = scratch.gains.data();
        double* const second_gains = first_gains + first_count;
        const double first_most = measure_gains(i, j, first_gains);
        const double second_most = measure_gains(j, i, second_gains);
        if (!(first_most + second_most > 0.0)) {
            return 0;
        }
        auto& [first_movers, second_movers] = scratch.movers;
        select_movers(first_gains, first_count, -second_most, first_movers);
        select_movers(second_gains, second_count, -first_most, second_movers);
        const std::size_t limit = std::min(first_movers.size(), second_movers.size());
        std::size_t swap_count = 0;
        while (swap_count < limit &&
               first_movers[swap_count].gain + second_movers[swap_count].gain > 0.0) {
            int& a = members_[i][first_movers[swap_count].slot];
            int& b = members_[j][second_movers[swap_count].slot];
            std::swap(a, b);
            settle(a, i);
            settle(b, j);
            ++swap_count;
        }
        changed_[i] = changed_[j] = 1;
        return static_cast<int>(swap_count);
    }

    void settle(int face, int submesh) {
        state_.label[face] = submesh;
        state_.distance[face] = distance_to(face, submesh);
    }

    ChordSwapState state_;
    const int submesh_count_;
    const int thread_count_;
    std::vector<std::vector<int>> members_;
    PointArrays centroids_;
    /// Per sub-mesh: faces were swapped in the last iteration. Where neither of two sub-meshes
    /// changed, no swap between them helps now, as none was left when that iteration ended.
    std::vector<std::uint8_t> changed_;
};

} // namespace

SwapIterations cohere_pairs(const std::vector<Vec3>& face_centroids,
                            int submesh_count,
                            const SwapLimits& limits,
                            std::vector<int>& labels,
                            const Progress& progress,
                            const DualGraph* dual_graph) {
    SwapIterations history;
    PairCohesion cohesion(face_centroids, labels, submesh_count, limits.thread_count);
    LeastEnergy least_energy(cohesion.energy());
    bool converged = submesh_count < 2;
    while (!converged) {
        if (limits.max_iterations > 0 && history.count() >= limits.max_iterations) {
            break;
        }
        if (limits.expired()) {
            history.time_limit_hit = true;
            break;
        }
        report_progress(progress, open_ended_fraction(history.count()), "Cohesion");
        const StopWatch watch;
        const long long swap_count = cohesion.iterate();
        history.swaps.push_back(static_cast<double>(swap_count));
        history.energy.push_back(cohesion.energy());
        if (dual_graph) {
            history.boundary_edges.push_back(count_boundary_edges(*dual_graph, cohesion.labels()));
        }
        history.seconds.push_back(watch.elapsed_seconds());
        converged = !least_energy.may_fall_after(history.energy.back()) || swap_count == 0;
    }
    labels = cohesion.labels();
    return history;
}

} // namespace spheroseg
