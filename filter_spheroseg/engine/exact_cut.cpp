// SPDX-License-Identifier: GPL-3.0-or-later
#include "exact_cut.h"

#include "random.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

constexpr int kFree = -1;
/// Further searches after the first one, in other orders, and the part of the steps that each gets.
constexpr int kFurtherSearches = 20;
constexpr int kStepDivisor = 5;
/// Larger sub-meshes, where a search is nearly hopeless, use the steps up sooner.
constexpr int kFacesPerStep = 8;

class ExactCut {
public:
    /// Search 0 takes the largest sub-meshes and the first faces first, others what chance says.
    ExactCut(Patchwork& patchwork, int least, int most, int max_steps, int search)
        : patchwork_(patchwork), least_(least), most_(most), steps_left_(max_steps),
          is_random_(search > 0), free_count_(patchwork.face_count()),
          random_(static_cast<std::uint64_t>(search)), seen_(patchwork.cells.size(), 0) {}

    bool run() {
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            patchwork_.set_own_label(f, kFree);
        }
        patchwork_.tell_neighbors();
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        return rest_can_be_parted(patchwork_.submesh_count()) && place_submesh(0);
    }
    /// False when nothing was found because there is nothing.
    bool gave_up() const { return steps_left_ < 0; }

private:
    int free_neighbors(int face) const {
        int count = 0;
        for (int neighbor : patchwork_.neighbors(face)) {
            count += neighbor >= 0 && patchwork_.cells[neighbor].label == kFree;
        }
        return count;
    }

    /// The free face with the fewest free neighbours; -1 when there is none.
    int next_seed() {
        int best = -1;
        int fewest = 4;
        const int face_count = patchwork_.face_count();
        const int first = is_random_ ? below(face_count) : 0;
        for (int i = 0; i < face_count && fewest > 0; ++i) {
            const int f = first + i < face_count ? first + i : first + i - face_count;
            if (patchwork_.cells[f].label == kFree && free_neighbors(f) < fewest) {
                fewest = free_neighbors(f);
                best = f;
            }
        }
        return best;
    }

    int below(int bound) {
        return static_cast<int>(random_.below(static_cast<std::uint32_t>(bound)));
    }

    /// Sizes of the next sub-mesh, in the order in which they are tried: by chance those first
    /// that are near the mean of what is left.
    std::vector<int> sizes(int label) {
        std::vector<int> order;
        for (int size = most_; size >= least_; --size) {
            order.push_back(size);
        }
        if (is_random_) {
            const double mean =
                free_count_ / static_cast<double>(patchwork_.submesh_count() - label);
            const double wanted = mean + random_.uniform() - 0.5;
            std::sort(order.begin(), order.end(), [&](int a, int b) {
                return std::abs(a - wanted) < std::abs(b - wanted);
            });
        }
        return order;
    }

    /// Places sub-mesh `label` and all after it.
    bool place_submesh(int label) {
        const int seed = next_seed();
        if (seed < 0) {
            return label == patchwork_.submesh_count();
        }
        if (label == patchwork_.submesh_count()) {
            return false;
        }
        for (int size : sizes(label)) {
            std::vector<int> frontier(1, seed);
            std::vector<int> excluded;
            if (grow(label, size, frontier, excluded)) {
                return true;
            }
        }
        return false;
    }

    /// Adds faces to sub-mesh `label` until it has `size`, in every way: a face of the frontier
    /// either joins now, or stays out of this sub-mesh.
    bool grow(int label, int size, std::vector<int> frontier, std::vector<int> excluded) {
        if (patchwork_.load[label] == size) {
            return rest_can_be_parted(patchwork_.submesh_count() - label - 1) &&
                place_submesh(label + 1);
        }
        while (!frontier.empty()) {
            steps_left_ -=
                1 + static_cast<int>((frontier.size() + excluded.size()) / kFacesPerStep);
            if (steps_left_ < 0) {
                return false;
            }
            // Dead ends first: they can go with no other sub-mesh.
            const auto next =
                std::min_element(frontier.begin(), frontier.end(), [this](int a, int b) {
                    return free_neighbors(a) < free_neighbors(b);
                });
            const int face = *next;
            frontier.erase(next);
            if (patchwork_.load[label] == 0 || may_join(patchwork_, face, label)) {
                patchwork_.set_label(face, label);
                ++patchwork_.load[label];
                --free_count_;
                std::vector<int> wider = frontier;
                for (int neighbor : patchwork_.neighbors(face)) {
                    if (neighbor >= 0 && patchwork_.cells[neighbor].label == kFree &&
                        std::find(wider.begin(), wider.end(), neighbor) == wider.end() &&
                        std::find(excluded.begin(), excluded.end(), neighbor) == excluded.end()) {
                        wider.push_back(neighbor);
                    }
                }
                if (grow(label, size, std::move(wider), excluded)) {
                    return true;
                }
                patchwork_.set_label(face, kFree);
                --patchwork_.load[label];
                ++free_count_;
            }
            excluded.push_back(face);
        }
        return false;
    }

    /// `parts` sub-meshes can make up the sizes of all pieces of free faces.
    bool rest_can_be_parted(int parts) {
        std::fill(seen_.begin(), seen_.end(), 0);
        int fewest = 0;
        int greatest = 0;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            if (patchwork_.cells[f].label == kFree && !seen_[f]) {
                const int size = piece_size(f);
                const int from = (size + most_ - 1) / most_;
                const int to = size / least_;
                if (from > to) {
                    return false;
                }
                fewest += from;
                greatest += to;
            }
        }
        return fewest <= parts && parts <= greatest;
    }

    int piece_size(int start) {
        queue_.assign(1, start);
        seen_[start] = 1;
        for (std::size_t head = 0; head < queue_.size(); ++head) {
            for (int neighbor : patchwork_.neighbors(queue_[head])) {
                if (neighbor >= 0 && patchwork_.cells[neighbor].label == kFree &&
                    !seen_[neighbor]) {
                    seen_[neighbor] = 1;
                    queue_.push_back(neighbor);
                }
            }
        }
        return static_cast<int>(queue_.size());
    }

    Patchwork& patchwork_;
    const int least_;
    const int most_;
    int steps_left_;
    const bool is_random_;
    int free_count_;
    Random random_;
    std::vector<std::uint8_t> seen_;
    std::vector<int> queue_;
};

} // namespace

bool cut_exactly(Patchwork& patchwork, int least, int most, int max_steps) {
    for (int search = 0; search <= kFurtherSearches; ++search) {
        const int steps = search == 0 ? max_steps : max_steps / kStepDivisor;
        ExactCut cut(patchwork, least, most, steps, search);
        if (cut.run()) {
            return true;
        }
        if (!cut.gave_up()) {
            break;
        }
    }
    return false;
}

} // namespace spheroseg
