// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

/// Distance of two neighbouring faces; offsets are finer than that.
constexpr int kStep = 8;

class Relaxation {
public:
    explicit Relaxation(Patchwork& patchwork)
        : patchwork_(patchwork), centers_(patchwork.submesh_count()),
          offsets_(patchwork.submesh_count(), 0.0), distance_(patchwork.cells.size()) {
        double total = 0.0;
        for (int load : patchwork.load) {
            total += load;
        }
        mean_load_ = total / patchwork.submesh_count();
        // Steps from the centre of a round patch to its rim.
        radius_ = kStep *
            std::sqrt(static_cast<double>(patchwork.face_count()) / patchwork.submesh_count());
    }

    void run(int iterations, const AnnealControl& control) {
        for (int i = 0; i < iterations && i < control.max_phases; ++i) {
            if (control.deadline && control.deadline->expired()) {
                return;
            }
            report_progress(control.progress, static_cast<double>(i) / iterations, "Relaxation");
            const Deadline watch;
            const std::int64_t boundary_edges = find_centers();
            if (control.boundary_edges) {
                control.boundary_edges->push_back(static_cast<double>(boundary_edges));
            }
            grow();
            if (control.seconds) {
                control.seconds->push_back(watch.elapsed_seconds());
            }
        }
    }

private:
    /// Finds the face of each sub-mesh that is farthest from its boundary; returns the number of
    /// boundary edges.
    std::int64_t find_centers() {
        std::int64_t sides = 0;
        queue_.clear();
        const int face_count = patchwork_.face_count();
        for (int f = 0; f < face_count; ++f) {
            const Cell& cell = patchwork_.cells[f];
            distance_[f] = -1;
            centers_[cell.label] = f;
            int differing = 0;
            for (int neighbor : cell.neighbor) {
                differing += neighbor >= 0 && patchwork_.cells[neighbor].label != cell.label;
            }
            if (differing > 0) {
                distance_[f] = 0;
                queue_.push_back(f);
                sides += differing;
            }
        }
        for (std::size_t head = 0; head < queue_.size(); ++head) {
            const Cell& cell = patchwork_.cells[queue_[head]];
            centers_[cell.label] = queue_[head];
            for (int neighbor : cell.neighbor) {
                if (neighbor >= 0 && distance_[neighbor] < 0) {
                    distance_[neighbor] = 0;
                    queue_.push_back(neighbor);
                }
            }
        }
        return sides / 2;
    }

    /// Multi-source shortest paths with a bucket queue (Dial, 1969).
    void grow() {
        std::vector<Cell>& cells = patchwork_.cells;
        const double least = *std::min_element(offsets_.begin(), offsets_.end());
        constexpr int kFar = 1 << 30;
        std::fill(distance_.begin(), distance_.end(), kFar);
        for (std::vector<int>& bucket : buckets_) {
            bucket.clear();
        }
        const auto put = [&](int face, int label, int distance) {
            distance_[face] = distance;
            cells[face].label = label;
            if (distance >= static_cast<int>(buckets_.size())) {
                buckets_.resize(distance + 1);
            }
            buckets_[distance].push_back(face);
        };
        for (std::size_t l = 0; l < centers_.size(); ++l) {
            put(centers_[l], static_cast<int>(l), static_cast<int>(offsets_[l] - least));
        }
        // A centre stays with its sub-mesh even if another one would reach it earlier.
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        for (std::size_t d = 0; d < buckets_.size(); ++d) {
            for (std::size_t i = 0; i < buckets_[d].size(); ++i) {
                const int face = buckets_[d][i];
                if (distance_[face] != static_cast<int>(d)) {
                    continue;
                }
                distance_[face] = -1 - distance_[face];
                const int label = cells[face].label;
                patchwork_.load[label] += cells[face].weight;
                const int next = static_cast<int>(d) + kStep;
                for (int neighbor : cells[face].neighbor) {
                    if (neighbor >= 0 && distance_[neighbor] > next &&
                        centers_[cells[neighbor].label] != neighbor) {
                        put(neighbor, label, next);
                    }
                }
            }
        }
        for (std::size_t l = 0; l < offsets_.size(); ++l) {
            offsets_[l] += 0.25 * radius_ * (patchwork_.load[l] / mean_load_ - 1.0);
        }
    }

    Patchwork& patchwork_;
    std::vector<int> centers_;
    std::vector<double> offsets_;
    std::vector<int> distance_;
    std::vector<int> queue_;
    std::vector<std::vector<int>> buckets_;
    double mean_load_ = 0.0;
    double radius_ = 0.0;
};

} // namespace

void relax(Patchwork& patchwork, int iterations, const AnnealControl& control) {
    Relaxation(patchwork).run(iterations, control);
}

} // namespace spheroseg
