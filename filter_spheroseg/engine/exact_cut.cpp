// SPDX-License-Identifier: GPL-3.0-or-later
#include "exact_cut.h"

#include "face_walk.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace spheroseg {

namespace {

constexpr int kFree = -1;
constexpr int kMet = -3;
/// Further searches after the first one, in other orders, and the part of the steps that each gets.
constexpr int kFurtherSearches = 20;
constexpr int kStepDivisor = 5;
/// Larger sub-meshes, where a search is nearly hopeless, use the steps up sooner.
constexpr int kFacesPerStep = 8;

class ExactCut {
public:
    /// Without `random` the search takes the largest sub-meshes and the first faces first, else
    /// what chance says.
    ExactCut(Patchwork& patchwork,
             const Region& region,
             int least,
             int most,
             int max_steps,
             Random* random)
        : patchwork_(patchwork), faces_(region.faces), labels_(region.labels), least_(least),
          most_(most), steps_left_(max_steps), random_(random),
          free_count_(static_cast<int>(region.faces.size())) {}

    bool run() {
        for (int f : faces_) {
            patchwork_.set_label(f, kFree);
        }
        for (int label : labels_) {
            patchwork_.load[label] = 0;
        }
        return rest_can_be_parted(submesh_count()) && place_submesh(0);
    }
    /// False when nothing was found because there is nothing.
    bool gave_up() const { return steps_left_ < 0; }

private:
    int submesh_count() const { return static_cast<int>(labels_.size()); }

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
        const auto face_count = static_cast<int>(faces_.size());
        const int first =
            random_ ? static_cast<int>(random_->below(static_cast<std::uint32_t>(face_count))) : 0;
        for (int i = 0; i < face_count && fewest > 0; ++i) {
            const int f = faces_[first + i < face_count ? first + i : first + i - face_count];
            if (patchwork_.cells[f].label == kFree && free_neighbors(f) < fewest) {
                fewest = free_neighbors(f);
                best = f;
            }
        }
        return best;
    }

    /// Sizes of the next sub-mesh in the order in which they are tried: from the largest down, or,
    /// with `random`, by their distance from the mean size of what is left plus noise.
    std::vector<int> sizes(int place) {
        std::vector<int> order;
        for (int size = most_; size >= least_; --size) {
            order.push_back(size);
        }
        if (random_) {
            const double mean = free_count_ / static_cast<double>(submesh_count() - place);
            const double wanted = mean + random_->uniform() - 0.5;
            std::sort(order.begin(), order.end(), [&](int a, int b) {
                return std::abs(a - wanted) < std::abs(b - wanted);
            });
        }
        return order;
    }

    /// Places the sub-mesh labels_[place] and all after it.
    bool place_submesh(int place) {
        const int seed = next_seed();
        if (seed < 0) {
            return place == submesh_count();
        }
        if (place == submesh_count()) {
            return false;
        }
        for (int size : sizes(place)) {
            std::vector<int> frontier(1, seed);
            std::vector<int> excluded;
            if (grow(place, size, frontier, excluded)) {
                return true;
            }
        }
        return false;
    }

    /// Adds faces to this sub-mesh until it has `size`, in every way: a face of the frontier either
    /// joins now, or stays out of it. One that would make a bowtie comes back to the frontier when
    /// the sub-mesh meets another of its edges.
    bool grow(int place, int size, std::vector<int> frontier, std::vector<int> excluded) {
        const int label = labels_[place];
        if (patchwork_.load[label] == size) {
            return rest_can_be_parted(submesh_count() - place - 1) && place_submesh(place + 1);
        }
        while (!frontier.empty()) {
            steps_left_ -=
                1 + static_cast<int>((frontier.size() + excluded.size()) / kFacesPerStep);
            if (steps_left_ < 0) {
                return false;
            }
            // Dead ends first: they can belong to no other sub-mesh.
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
                if (grow(place, size, std::move(wider), excluded)) {
                    return true;
                }
                patchwork_.set_label(face, kFree);
                --patchwork_.load[label];
                ++free_count_;
                excluded.push_back(face);
            }
        }
        return false;
    }

    /// False when sizes in [least, most] can not split the pieces of free faces into `parts`
    /// sub-meshes in all.
    bool rest_can_be_parted(int parts) {
        int fewest = 0;
        int greatest = 0;
        bool possible = true;
        for (std::size_t i = 0; i < faces_.size() && possible; ++i) {
            if (patchwork_.cells[faces_[i]].label == kFree) {
                const int size = piece_size(faces_[i]);
                const int from = (size + most_ - 1) / most_;
                const int to = size / least_;
                possible = from <= to;
                fewest += from;
                greatest += to;
            }
        }
        for (int f : met_) {
            patchwork_.set_own_label(f, kFree);
        }
        met_.clear();
        return possible && fewest <= parts && parts <= greatest;
    }

    int piece_size(int start) {
        const std::size_t first = met_.size();
        patchwork_.set_own_label(start, kMet);
        met_.push_back(start);
        const auto meet = [&](int, int face) {
            if (patchwork_.label(face) != kFree) {
                return false;
            }
            patchwork_.set_own_label(face, kMet);
            return true;
        };
        walk_faces(patchwork_, met_, meet, first);
        return static_cast<int>(met_.size() - first);
    }

    Patchwork& patchwork_;
    const std::vector<int>& faces_;
    const std::vector<int>& labels_;
    const int least_;
    const int most_;
    int steps_left_;
    Random* const random_;
    int free_count_;
    /// Free faces that were counted already, while pieces are counted.
    std::vector<int> met_;
};

} // namespace

bool cut_exactly(Patchwork& patchwork, int least, int most, int max_steps) {
    Region whole;
    whole.faces.resize(patchwork.cells.size());
    std::iota(whole.faces.begin(), whole.faces.end(), 0);
    whole.labels.resize(patchwork.load.size());
    std::iota(whole.labels.begin(), whole.labels.end(), 0);
    for (int search = 0; search <= kFurtherSearches; ++search) {
        const int steps = search == 0 ? max_steps : max_steps / kStepDivisor;
        Random random(static_cast<std::uint64_t>(search));
        ExactCut cut(patchwork, whole, least, most, steps, search == 0 ? nullptr : &random);
        if (cut.run()) {
            return true;
        }
        if (!cut.gave_up()) {
            break;
        }
    }
    return false;
}

bool cut_evenly(Patchwork& patchwork, const Region& region, int max_steps, Random& random) {
    const auto face_count = static_cast<int>(region.faces.size());
    const auto count = static_cast<int>(region.labels.size());
    const int least = face_count / count;
    return ExactCut(patchwork, region, least, least + (face_count % count != 0), max_steps, &random)
        .run();
}

} // namespace spheroseg
