// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include "parallel_failure.h"
#include "random.h"
#include "threads.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>

namespace spheroseg {

namespace {

/// Distance of two neighbouring faces; offsets are finer than that.
constexpr int kStep = 8;
/// Less than that is not worth another thread.
constexpr int kFacesPerWorker = 8192;

/// Where a wave reached a face: distance, then the sub-mesh that it came from. The order of the
/// keys decides between two waves, never the order of arrival.
using Key = std::uint64_t;
constexpr Key kUnreached = ~Key{0};
constexpr Key make_key(int distance, int label) {
    return static_cast<Key>(distance) << 32 | static_cast<Key>(label);
}
constexpr int distance_of(Key key) {
    return static_cast<int>(key >> 32);
}
constexpr int label_of(Key key) {
    return static_cast<int>(key & 0xFFFFFFFF);
}

class Relaxation {
public:
    Relaxation(Patchwork& patchwork, int thread_count)
        : patchwork_(patchwork),
          workers_(threads_for(thread_count, patchwork.face_count(), kFacesPerWorker)),
          centers_(patchwork.submesh_count()), offsets_(patchwork.submesh_count(), 0.0),
          inside_(patchwork.cells.size()), keys_(patchwork.cells.size()) {
        double total = 0.0;
        for (int load : patchwork.load) {
            total += load;
        }
        mean_load_ = total / patchwork.submesh_count();
        // Steps from the centre of a round patch to its rim.
        radius_ = kStep *
            std::sqrt(static_cast<double>(patchwork.face_count()) / patchwork.submesh_count());
        for (Worker& worker : workers_) {
            worker.boundary.resize(workers_.size());
            worker.load.resize(patchwork.submesh_count());
        }
    }

    void run(int iterations, const AnnealControl& control) {
        for (int i = 0; i < iterations && i < control.max_phases; ++i) {
            if (control.deadline && control.deadline->expired()) {
                return;
            }
            report_progress(control.progress, static_cast<double>(i) / iterations, "Relaxation");
            const Deadline watch;
            iterate();
            if (control.boundary_edges) {
                std::int64_t sides = 0;
                for (const Worker& worker : workers_) {
                    sides += worker.sides;
                }
                control.boundary_edges->push_back(static_cast<double>(sides / 2));
                control.seconds->push_back(watch.elapsed_seconds());
            }
        }
    }

private:
    /// What belongs to one thread: a range of faces for what is done face by face, a range of
    /// labels for the waves.
    struct Worker {
        /// Boundary faces of its range of faces, by the worker that has their label.
        std::vector<std::vector<int>> boundary;
        std::vector<int> queue;
        /// Faces to spread from, by distance.
        std::vector<std::vector<int>> buckets;
        std::vector<int> load;
        std::int64_t sides = 0;
    };

    struct Center {
        int face = -1;
        /// Its distance from the boundary, in faces.
        int ring = -1;
        std::uint64_t rank = 0;
    };

    template <typename Work> void each_worker(Work work) {
        const int worker_count = static_cast<int>(workers_.size());
        ParallelFailure failure;
#pragma omp parallel for schedule(static, 1) num_threads(worker_count)
        for (int w = 0; w < worker_count; ++w) {
            failure.guard([&] { work(workers_[w], w); });
        }
        failure.rethrow();
    }

    void iterate() {
        ++iteration_;
        const double least = *std::min_element(offsets_.begin(), offsets_.end());
        each_worker([&](Worker& worker, int w) { list_boundary(worker, w); });
        each_worker([&](Worker& worker, int w) { find_centers(worker, w); });
        each_worker([&](Worker& worker, int w) { grow(worker, w, least); });
        each_worker([&](Worker& worker, int w) { take_labels(worker, w); });
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        for (const Worker& worker : workers_) {
            for (std::size_t l = 0; l < offsets_.size(); ++l) {
                patchwork_.load[l] += worker.load[l];
            }
        }
        for (std::size_t l = 0; l < offsets_.size(); ++l) {
            offsets_[l] += 0.25 * radius_ * (patchwork_.load[l] / mean_load_ - 1.0);
        }
    }

    int begin_of(int worker, int count) const {
        return static_cast<int>(static_cast<std::int64_t>(count) * worker /
                                static_cast<int>(workers_.size()));
    }

    int worker_of_label(int label) const {
        const auto worker_count = static_cast<int>(workers_.size());
        return static_cast<int>(
            (static_cast<std::int64_t>(label) * worker_count + worker_count - 1) /
            patchwork_.submesh_count());
    }

    void list_boundary(Worker& worker, int w) {
        worker.sides = 0;
        for (std::vector<int>& faces : worker.boundary) {
            faces.clear();
        }
        const int end = begin_of(w + 1, patchwork_.face_count());
        for (int f = begin_of(w, patchwork_.face_count()); f < end; ++f) {
            const Cell& cell = patchwork_.cells[f];
            int differing = 0;
            for (int neighbor : cell.neighbor) {
                differing += neighbor >= 0 && patchwork_.cells[neighbor].label != cell.label;
            }
            inside_[f] = differing == 0;
            keys_[f].store(kUnreached, std::memory_order_relaxed);
            if (differing > 0) {
                worker.boundary[worker_of_label(cell.label)].push_back(f);
                worker.sides += differing;
            }
        }
    }

    /// Finds a face of each sub-mesh that is farthest from its boundary. Among several it takes a
    /// random one, another one in each iteration: a fixed choice pulls all centres one way where
    /// faces are numbered regularly, and holds them where they are.
    void find_centers(Worker& worker, int w) {
        const int first = begin_of(w, patchwork_.submesh_count());
        const int end = begin_of(w + 1, patchwork_.submesh_count());
        std::fill(centers_.begin() + first, centers_.begin() + end, Center{});
        std::vector<int>& queue = worker.queue;
        queue.clear();
        for (const Worker& lister : workers_) {
            queue.insert(queue.end(), lister.boundary[w].begin(), lister.boundary[w].end());
        }
        std::size_t ring_end = queue.size();
        int ring = 0;
        for (std::size_t head = 0; head < queue.size(); ++head) {
            if (head == ring_end) {
                ring_end = queue.size();
                ++ring;
            }
            const int face = queue[head];
            const Cell& cell = patchwork_.cells[face];
            const std::uint64_t rank = Random(iteration_, static_cast<std::uint64_t>(face)).next();
            Center& center = centers_[cell.label];
            if (center.ring < ring || rank < center.rank) {
                center = {face, ring, rank};
            }
            for (int neighbor : cell.neighbor) {
                if (neighbor >= 0 && inside_[neighbor]) {
                    inside_[neighbor] = 0;
                    queue.push_back(neighbor);
                }
            }
        }
        // A centre stays with its sub-mesh even if another one would reach it earlier: nothing is
        // nearer than a distance of 0, and all others are greater.
        for (int l = first; l < end; ++l) {
            if (centers_[l].face >= 0) {
                keys_[centers_[l].face].store(make_key(0, l), std::memory_order_relaxed);
            }
        }
    }

    /// Multi-source shortest paths with a bucket queue (Dial, 1969). Each worker spreads what its
    /// own waves reached; the result is the one fixed point, whoever comes first.
    void grow(Worker& worker, int w, double least) {
        for (std::vector<int>& bucket : worker.buckets) {
            bucket.clear();
        }
        const auto put = [&](int face, int distance) {
            if (distance >= static_cast<int>(worker.buckets.size())) {
                worker.buckets.resize(distance + 1);
            }
            worker.buckets[distance].push_back(face);
        };
        const int end = begin_of(w + 1, patchwork_.submesh_count());
        for (int l = begin_of(w, patchwork_.submesh_count()); l < end; ++l) {
            if (centers_[l].face >= 0) {
                put(centers_[l].face, static_cast<int>(offsets_[l] - least));
            }
        }
        for (std::size_t d = 0; d < worker.buckets.size(); ++d) {
            for (std::size_t i = 0; i < worker.buckets[d].size(); ++i) {
                const int face = worker.buckets[d][i];
                const Key key = keys_[face].load(std::memory_order_relaxed);
                const bool is_center = distance_of(key) == 0;
                if (!is_center && distance_of(key) != static_cast<int>(d)) {
                    continue;
                }
                const Key reached = make_key(static_cast<int>(d) + kStep, label_of(key));
                for (int neighbor : patchwork_.cells[face].neighbor) {
                    if (neighbor >= 0 && lower(keys_[neighbor], reached)) {
                        put(neighbor, static_cast<int>(d) + kStep);
                    }
                }
            }
        }
    }

    bool lower(std::atomic<Key>& key, Key to) const {
        Key current = key.load(std::memory_order_relaxed);
        if (workers_.size() == 1) {
            if (to < current) {
                key.store(to, std::memory_order_relaxed);
                return true;
            }
            return false;
        }
        while (to < current) {
            if (key.compare_exchange_weak(current, to, std::memory_order_relaxed)) {
                return true;
            }
        }
        return false;
    }

    void take_labels(Worker& worker, int w) {
        std::fill(worker.load.begin(), worker.load.end(), 0);
        const int end = begin_of(w + 1, patchwork_.face_count());
        for (int f = begin_of(w, patchwork_.face_count()); f < end; ++f) {
            Cell& cell = patchwork_.cells[f];
            const Key key = keys_[f].load(std::memory_order_relaxed);
            if (key != kUnreached) {
                cell.label = label_of(key);
            }
            worker.load[cell.label] += cell.weight;
        }
    }

    Patchwork& patchwork_;
    std::vector<Worker> workers_;
    std::vector<Center> centers_;
    std::vector<double> offsets_;
    /// Not reached yet from the boundary.
    std::vector<std::uint8_t> inside_;
    std::vector<std::atomic<Key>> keys_;
    std::uint64_t iteration_ = 0;
    double mean_load_ = 0.0;
    double radius_ = 0.0;
};

} // namespace

void relax(Patchwork& patchwork, int iterations, int thread_count, const AnnealControl& control) {
    if (patchwork.submesh_count() > 1) {
        Relaxation(patchwork, thread_count).run(iterations, control);
    }
}

} // namespace spheroseg
