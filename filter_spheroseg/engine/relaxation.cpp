// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include "parallel_failure.h"
#include "random.h"
#include "threads.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

namespace spheroseg {

namespace {

/// Distance of two neighbouring faces; offsets are finer than that.
constexpr int kStep = 8;

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
          workers_(threads_for(thread_count, patchwork.face_count(), kFacesPerThread)),
          centers_(patchwork.submesh_count()), worker_of_label_(patchwork.submesh_count()),
          offsets_(patchwork.submesh_count(), 0.0),
          neighbors_(neighbor_table(patchwork, thread_count)), labels_(cell_labels(patchwork)),
          distances_(patchwork.cells.size(), 0), inside_(patchwork.cells.size()),
          keys_(patchwork.cells.size()) {
        for (std::atomic<Key>& key : keys_) {
            key.store(kUnreached, std::memory_order_relaxed);
        }
        mean_load_ = mean_load(patchwork);
        // Steps from the centre of a round patch to its rim.
        radius_ = kStep *
            std::sqrt(static_cast<double>(patchwork.face_count()) / patchwork.submesh_count());
        for (int w = 0; w < static_cast<int>(workers_.size()); ++w) {
            Worker& worker = workers_[w];
            worker.load.resize(patchwork.submesh_count());
            std::fill(worker_of_label_.begin() + begin_of(w, patchwork.submesh_count()),
                      worker_of_label_.begin() + begin_of(w + 1, patchwork.submesh_count()),
                      w);
        }
    }

    void run(int iterations, const AnnealControl& control) {
        for (int i = 0; i < iterations && i < control.max_phases; ++i) {
            if (control.deadline && control.deadline->expired()) {
                return;
            }
            report_progress(control.progress, static_cast<double>(i) / iterations, "Relaxation");
            const StopWatch watch;
            iterate();
            if (control.history) {
                std::int64_t sides = 0;
                for (const Worker& worker : workers_) {
                    sides += worker.sides;
                }
                control.history->add(static_cast<double>(sides / 2), watch.elapsed_seconds());
            }
        }
    }

    /// Labels the patchwork by what the iterations made.
    void finish() {
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            patchwork_.set_own_label(f, labels_[f]);
        }
        patchwork_.tell_neighbors(static_cast<int>(workers_.size()));
    }

private:
    /// What belongs to one thread: a range of faces for what is done face by face, a range of
    /// labels for the waves.
    struct Worker {
        /// The first so many are the boundary faces of its range of faces.
        std::vector<int> boundary;
        int boundary_count = 0;
        /// Faces by distance, and where the distances change.
        std::vector<int> queue;
        std::vector<int> segments;
        /// Distance at which the wave of a centre begins, and the centre.
        std::vector<std::pair<int, int>> starts;
        std::vector<int> load;
        std::int64_t sides = 0;
    };

    struct Center {
        int face = -1;
        /// Its distance from the boundary, in faces, and from the centre before.
        std::pair<int, int> depth{-1, 0};
        /// Decides where these are the same.
        std::uint64_t rank = 0;
    };

    template <typename Work> void each_worker(Work work) {
        const int worker_count = static_cast<int>(workers_.size());
        ParallelFailure failure;
        for_each_task(worker_count, worker_count, [&](int w) {
            failure.guard([&] { work(workers_[w], w); });
        });
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
        return share_begin(worker, static_cast<int>(workers_.size()), count);
    }

    /// Which faces are on the boundary can not be foreseen: all are appended, these are counted.
    void list_boundary(Worker& worker, int w) {
        const int first = begin_of(w, patchwork_.face_count());
        const int end = begin_of(w + 1, patchwork_.face_count());
        worker.boundary.resize(end - first);
        int count = 0;
        std::int64_t sides = 0;
        for (int f = first; f < end; ++f) {
            const int label = labels_[f];
            int differing = 0;
            for (int neighbor : neighbors_[f]) {
                differing += labels_[neighbor] != label;
            }
            inside_[f] = differing == 0;
            worker.boundary[count] = f;
            count += differing > 0;
            sides += differing;
        }
        worker.boundary_count = count;
        worker.sides = sides;
    }

    /// Finds a face of each sub-mesh that is farthest from its boundary. Among several it takes one
    /// that is farthest from the centre before, so that centres do not linger on their way; among
    /// these a random one, another one in each iteration: a fixed choice pulls all centres one way
    /// where faces are numbered regularly.
    void find_centers(Worker& worker, int w) {
        const int first = begin_of(w, patchwork_.submesh_count());
        const int end = begin_of(w + 1, patchwork_.submesh_count());
        sort_by_ring(worker, w);
        std::fill(centers_.begin() + first, centers_.begin() + end, Center{});
        auto left = std::count_if(patchwork_.load.begin() + first,
                                  patchwork_.load.begin() + end,
                                  [](int load) { return load > 0; });
        // From the innermost ring outwards, until all have theirs.
        for (int ring = static_cast<int>(worker.segments.size()) - 2; ring >= 0 && left > 0;
             --ring) {
            for (int i = worker.segments[ring]; i < worker.segments[ring + 1]; ++i) {
                const int face = worker.queue[i];
                const std::pair<int, int> depth{ring, distances_[face]};
                Center& center = centers_[labels_[face]];
                if (center.depth > depth) {
                    continue;
                }
                left -= center.face < 0;
                const std::uint64_t rank =
                    Random(iteration_, static_cast<std::uint64_t>(face)).next();
                if (center.depth < depth || rank < center.rank) {
                    center = {face, depth, rank};
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

    /// Lists the faces of the worker's labels by their distance from the boundary: those at
    /// distance r are queue[segments[r] .. segments[r + 1]). Which neighbours are new can not be
    /// foreseen, so they are appended without a branch.
    void sort_by_ring(Worker& worker, int w) {
        std::vector<int>& queue = worker.queue;
        queue.clear();
        for (const Worker& lister : workers_) {
            std::copy_if(lister.boundary.begin(),
                         lister.boundary.begin() + lister.boundary_count,
                         std::back_inserter(queue),
                         [&](int face) { return worker_of_label_[labels_[face]] == w; });
        }
        auto tail = static_cast<int>(queue.size());
        worker.segments.assign(1, 0);
        for (int head = 0; head < tail;) {
            const int ring_end = tail;
            worker.segments.push_back(ring_end);
            for (; head < ring_end; ++head) {
                make_room(queue, tail);
                for (int neighbor : neighbors_[queue[head]]) {
                    std::uint8_t& mark = inside_[neighbor];
                    const std::uint8_t is_new = __atomic_load_n(&mark, __ATOMIC_RELAXED);
                    __atomic_store_n(&mark, 0, __ATOMIC_RELAXED);
                    queue[tail] = neighbor;
                    tail += is_new;
                }
            }
        }
    }

    /// For the neighbours of one more face.
    static void make_room(std::vector<int>& queue, int tail) {
        if (queue.size() < static_cast<std::size_t>(tail) + 3) {
            queue.resize(2 * static_cast<std::size_t>(tail) + 3);
        }
    }

    /// Multi-source shortest paths with a bucket queue (Dial, 1969). Each worker spreads what its
    /// own waves reached; the result is the one fixed point, whoever comes first. All steps are
    /// equally long, so that the buckets lie one after the other in one queue: that of distance d
    /// ends at segments[d].
    void grow(Worker& worker, int w, double least) {
        const int first = begin_of(w, patchwork_.submesh_count());
        const int end = begin_of(w + 1, patchwork_.submesh_count());
        worker.starts.clear();
        for (int l = first; l < end; ++l) {
            if (centers_[l].face >= 0) {
                worker.starts.emplace_back(static_cast<int>(offsets_[l] - least), centers_[l].face);
            }
        }
        std::sort(worker.starts.begin(), worker.starts.end());
        std::vector<int>& queue = worker.queue;
        auto next_start = worker.starts.begin();
        int tail = 0;
        worker.segments.clear();
        const auto close_bucket = [&] {
            const auto distance = static_cast<int>(worker.segments.size());
            for (; next_start != worker.starts.end() && next_start->first == distance;
                 ++next_start) {
                make_room(queue, tail);
                queue[tail++] = next_start->second;
            }
            worker.segments.push_back(tail);
        };
        while (worker.segments.size() < kStep) {
            close_bucket();
        }
        int head = 0;
        for (int d = 0; head < tail || next_start != worker.starts.end(); ++d) {
            for (; head < worker.segments[d]; ++head) {
                make_room(queue, tail);
                spread(queue[head], d, queue, tail);
            }
            close_bucket();
        }
    }

    /// Appends the neighbours that the wave at `face` reaches first.
    void spread(int face, int distance, std::vector<int>& queue, int& tail) {
        const Key key = keys_[face].load(std::memory_order_relaxed);
        const bool is_center = distance_of(key) == 0;
        if (!is_center && distance_of(key) != distance) {
            return; // another wave was earlier
        }
        const Key reached = make_key(distance + kStep, label_of(key));
        for (int neighbor : neighbors_[face]) {
            queue[tail] = neighbor;
            tail += lower(keys_[neighbor], reached);
        }
    }

    bool lower(std::atomic<Key>& key, Key to) const {
        Key current = key.load(std::memory_order_relaxed);
        if (workers_.size() == 1) {
            key.store(std::min(current, to), std::memory_order_relaxed); // without a branch
            return to < current;
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
            const Key key = keys_[f].load(std::memory_order_relaxed);
            if (key != kUnreached) {
                labels_[f] = label_of(key);
                distances_[f] = distance_of(key);
                keys_[f].store(kUnreached, std::memory_order_relaxed);
            }
            worker.load[labels_[f]] += patchwork_.weight(f);
        }
    }

    Patchwork& patchwork_;
    std::vector<Worker> workers_;
    std::vector<Center> centers_;
    std::vector<int> worker_of_label_;
    std::vector<double> offsets_;
    const std::vector<std::array<int, 3>> neighbors_;
    std::vector<int> labels_;
    /// From the centre that a face was given to, and the start of its wave.
    std::vector<int> distances_;
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
        Relaxation relaxation(patchwork, thread_count);
        relaxation.run(iterations, control);
        relaxation.finish();
    }
}

} // namespace spheroseg
