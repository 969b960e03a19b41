// SPDX-License-Identifier: GPL-3.0-or-later
#include "shares.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

namespace spheroseg {

namespace {

int ceil_divide(int a, int b) {
    return a / b + (a % b != 0);
}

/// Bounds of the triangle counts of all sub-meshes. A component of n faces keeps within them when
/// it gets ceil(n / most) to floor(n / least) sub-meshes.
struct Bounds {
    int least;
    int most;
};

class Sharing {
public:
    Sharing(const std::vector<int>& face_counts, int submesh_count)
        : face_counts_(face_counts), submesh_count_(submesh_count) {}

    Shares run() {
        const Bounds best = best_bounds();
        Shares shares;
        shares.max_triangle_count_difference = best.most - best.least;
        shares.least_count = best.least;
        shares.largest_count = best.most;
        shares.submesh_counts.reserve(face_counts_.size());
        int given = 0;
        for (int n : face_counts_) {
            shares.submesh_counts.push_back(ceil_divide(n, best.most));
            given += shares.submesh_counts.back();
        }
        give_rest(best, submesh_count_ - given, shares.submesh_counts);
        return shares;
    }

private:
    Bounds best_bounds() const {
        const int smallest = *std::min_element(face_counts_.begin(), face_counts_.end());
        const std::int64_t face_count =
            std::accumulate(face_counts_.begin(), face_counts_.end(), std::int64_t{0});
        const auto mean = static_cast<int>(face_count / submesh_count_);
        Bounds best{0, *std::max_element(face_counts_.begin(), face_counts_.end())};
        // Some sub-mesh has the mean or more.
        for (int least = std::min(smallest, mean);
             least > 0 && mean - least <= best.most - best.least;
             --least) {
            if (most_submeshes(least) < submesh_count_) {
                continue;
            }
            const int most = least_bound_above(least);
            const int change = (most - least) - (best.most - best.least);
            if (change < 0 || (change == 0 && most < best.most)) {
                best = {least, most};
            }
        }
        return best;
    }

    std::int64_t most_submeshes(int least) const {
        std::int64_t sum = 0;
        for (int n : face_counts_) {
            sum += n / least;
        }
        return sum;
    }

    /// The smallest upper bound that goes with `least`.
    int least_bound_above(int least) const {
        int most = least;
        for (int n : face_counts_) {
            most = std::max(most, ceil_divide(n, n / least));
        }
        int end = *std::max_element(face_counts_.begin(), face_counts_.end());
        while (most < end) {
            const int middle = most + (end - most) / 2;
            if (fewest_submeshes(middle) <= submesh_count_) {
                end = middle;
            } else {
                most = middle + 1;
            }
        }
        return most;
    }

    std::int64_t fewest_submeshes(int most) const {
        std::int64_t sum = 0;
        for (int n : face_counts_) {
            sum += ceil_divide(n, most);
        }
        return sum;
    }

    /// One more sub-mesh for a component; the greatest step by operator< is taken next.
    struct Step {
        /// How much the sum of squared counts falls.
        double gain;
        /// The mean counts before and after the step, less the smallest count after it: the one
        /// that is farther from 0.5, and the other one.
        double outer;
        double inner;
        int component;

        bool operator<(const Step& other) const {
            return std::make_tuple(gain, outer, -inner, -component) <
                std::make_tuple(other.gain, other.outer, -other.inner, -other.component);
        }
    };

    /// Gives the rest one by one where the sum of squares falls most, which is optimal as the sum
    /// is convex in each share. It falls by the same m (m + 1) wherever counts stay m or m + 1.
    /// Cuts are hardest to find where nearly all counts of a component have to be the same, so of
    /// equal steps those come first that lead away from a mean of m + 1, then those that end
    /// farthest from one of m.
    void give_rest(const Bounds& bounds, int rest, std::vector<int>& shares) const {
        std::priority_queue<Step> queue;
        const auto offer = [&](int i) {
            if (shares[i] < face_counts_[i] / bounds.least) {
                queue.push(step(i, shares[i]));
            }
        };
        for (int i = 0; i < static_cast<int>(shares.size()); ++i) {
            offer(i);
        }
        for (; rest > 0; --rest) {
            const int i = queue.top().component;
            queue.pop();
            ++shares[i];
            offer(i);
        }
    }

    Step step(int component, int share) const {
        const int n = face_counts_[component];
        const int small = n / (share + 1);
        const double gain = sum_of_squares(n, share) - sum_of_squares(n, share + 1);
        double outer = static_cast<double>(n) / share - small;
        double inner = static_cast<double>(n) / (share + 1) - small;
        if (std::abs(inner - 0.5) > std::abs(outer - 0.5)) {
            std::swap(outer, inner);
        }
        return {gain, outer, inner, component};
    }

    /// Of the counts of n faces in `parts` parts that differ by at most one.
    static double sum_of_squares(int n, int parts) {
        const double small = n / parts;
        const double large_parts = n % parts;
        return parts * small * small + large_parts * (2.0 * small + 1.0);
    }

    const std::vector<int>& face_counts_;
    const int submesh_count_;
};

} // namespace

Shares share_submeshes(const std::vector<int>& face_counts, int submesh_count) {
    return Sharing(face_counts, submesh_count).run();
}

std::vector<int> share_submeshes_by_weight(const std::vector<double>& weights,
                                           const std::vector<int>& face_counts,
                                           int submesh_count) {
    std::vector<int> submesh_counts(weights.size(), 1);
    using Heaviest = std::pair<double, int>; // weight per sub-mesh, minus the component
    std::priority_queue<Heaviest> queue;
    const auto enter = [&](int i) {
        if (submesh_counts[i] < face_counts[i]) {
            queue.emplace(weights[i] / submesh_counts[i], -i);
        }
    };
    for (std::size_t i = 0; i < weights.size(); ++i) {
        enter(static_cast<int>(i));
    }
    for (int given = static_cast<int>(weights.size()); given < submesh_count; ++given) {
        const int heaviest = -queue.top().second;
        queue.pop();
        ++submesh_counts[heaviest];
        enter(heaviest);
    }
    return submesh_counts;
}

} // namespace spheroseg
