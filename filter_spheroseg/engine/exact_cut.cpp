// SPDX-License-Identifier: GPL-3.0-or-later
#include "exact_cut.h"

#include <algorithm>

namespace spheroseg {

namespace {

constexpr int kFree = -1;

class ExactCut {
public:
    ExactCut(Patchwork& patchwork, int least, int most, int max_steps)
        : patchwork_(patchwork), least_(least), most_(most), steps_left_(max_steps),
          seen_(patchwork.cells.size(), 0) {}

    bool run() {
        for (Cell& cell : patchwork_.cells) {
            cell.label = kFree;
        }
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        return place_submesh(0);
    }

private:
    int free_neighbors(int face) const {
        int count = 0;
        for (int neighbor : patchwork_.cells[face].neighbor) {
            count += neighbor >= 0 && patchwork_.cells[neighbor].label == kFree;
        }
        return count;
    }

    /// The free face with the fewest free neighbours; -1 when there is none.
    int next_seed() const {
        int best = -1;
        int fewest = 4;
        for (int f = 0; f < patchwork_.face_count() && fewest > 0; ++f) {
            if (patchwork_.cells[f].label == kFree && free_neighbors(f) < fewest) {
                fewest = free_neighbors(f);
                best = f;
            }
        }
        return best;
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
        for (int size = most_; size >= least_; --size) {
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
            if (--steps_left_ < 0) {
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
                patchwork_.cells[face].label = label;
                ++patchwork_.load[label];
                std::vector<int> wider = frontier;
                for (int neighbor : patchwork_.cells[face].neighbor) {
                    if (neighbor >= 0 && patchwork_.cells[neighbor].label == kFree &&
                        std::find(wider.begin(), wider.end(), neighbor) == wider.end() &&
                        std::find(excluded.begin(), excluded.end(), neighbor) == excluded.end()) {
                        wider.push_back(neighbor);
                    }
                }
                if (grow(label, size, std::move(wider), excluded)) {
                    return true;
                }
                patchwork_.cells[face].label = kFree;
                --patchwork_.load[label];
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
            for (int neighbor : patchwork_.cells[queue_[head]].neighbor) {
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
    std::vector<std::uint8_t> seen_;
    std::vector<int> queue_;
};

} // namespace

bool cut_exactly(Patchwork& patchwork, int least, int most, int max_steps) {
    return ExactCut(patchwork, least, most, max_steps).run();
}

} // namespace spheroseg
