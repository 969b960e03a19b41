// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include "parallel_failure.h"
#include "random.h"
#include "threads.h"
#include "types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace spheroseg {

namespace {

/// Distance of two neighbouring faces in the units of offsets, which so can be fractions of it.
constexpr int kStep = 8;

/// An iteration takes several times as long per face as a plain loop.
constexpr int kLeastFacesPerThread = kFacesPerThread / 2;
/// Faces that fit in a core's own cache with all that belongs to them.
constexpr int kFacesPerPart = 16384;
/// The number of a part.
using PartNumber = std::uint16_t;
static_assert(kMaxFaces / kFacesPerPart <= std::numeric_limits<PartNumber>::max());

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
          thread_count_(threads_for(thread_count, patchwork.face_count(), kLeastFacesPerThread)),
          parts_(part_count()), centers_(patchwork.submesh_count()),
          part_of_label_(patchwork.submesh_count()), offsets_(patchwork.submesh_count(), 0.0),
          faces_(sort_by_label(patchwork).faces), neighbors_(faces_.size()),
          weights_(faces_.size()), labels_(faces_.size()), parts_of_faces_(faces_.size()),
          distances_(faces_.size(), 0), inside_(faces_.size()), keys_(faces_.size(), kUnreached) {
        mean_load_ = mean_load(patchwork);
        // Steps from the centre of a round patch to its rim.
        radius_ = kStep * std::sqrt(mean_cell_count(patchwork));
        lay_out_parts();
        read_patchwork();
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
                for (const Part& part : parts_) {
                    sides += part.sides;
                }
                control.history->add(static_cast<double>(sides / 2), watch.elapsed_seconds());
            }
        }
    }

    /// Labels the patchwork by what the iterations made.
    void finish() {
        for_each_part([&](const Part& part) {
            for (int f = part.first_face; f < part.end_face; ++f) {
                patchwork_.set_own_label(faces_[f], labels_[f]);
            }
        });
        patchwork_.tell_neighbors(thread_count_);
    }

private:
    struct Crossing {
        int face;
        Key key;
    };

    /// The work of one thread at a time, small enough for its own cache: a range of faces for loops
    /// over faces, and a range of labels for all that goes by sub-mesh. At first the faces are
    /// those of the labels, and the two drift apart little.
    struct Part {
        int number = 0;
        int first_face = 0;
        int end_face = 0;
        int first_label = 0;
        int end_label = 0;
        /// Boundary faces in its range of faces whose labels are in the ranges of other parts.
        std::vector<int> strays;
        /// The boundary faces of its labels at first; then a breadth-first queue of faces by
        /// distance, and where in it each distance ends.
        std::vector<int> queue;
        std::vector<int> segments;
        /// Faces where waves begin, or go on, and at which distance.
        std::vector<std::pair<int, int>> starts;
        /// Where waves left the part, and where others came in.
        std::vector<Crossing> departures;
        std::vector<Crossing> arrivals;
        /// Of its labels.
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

    int part_count() const {
        return std::min(patchwork_.submesh_count(),
                        std::max(thread_count_, patchwork_.face_count() / kFacesPerPart));
    }

    void lay_out_parts() {
        const auto part_count = static_cast<int>(parts_.size());
        for (int p = 0; p < part_count; ++p) {
            Part& part = parts_[p];
            part.number = p;
            part.first_face = share_begin(p, part_count, patchwork_.face_count());
            part.end_face = share_begin(p + 1, part_count, patchwork_.face_count());
            part.first_label = share_begin(p, part_count, patchwork_.submesh_count());
            part.end_label = share_begin(p + 1, part_count, patchwork_.submesh_count());
            part.load.resize(part.end_label - part.first_label);
            std::fill(part_of_label_.begin() + part.first_label,
                      part_of_label_.begin() + part.end_label,
                      p);
        }
    }

    void read_patchwork() {
        std::vector<int> places(faces_.size());
        for_each_part([&](const Part& part) {
            for (int f = part.first_face; f < part.end_face; ++f) {
                places[faces_[f]] = f;
            }
        });
        for_each_part([&](const Part& part) {
            for (int f = part.first_face; f < part.end_face; ++f) {
                for (int c = 0; c < 3; ++c) {
                    const int neighbor = patchwork_.neighbor(faces_[f], c);
                    neighbors_[f][c] = neighbor < 0 ? f : places[neighbor];
                }
                weights_[f] = patchwork_.weight(faces_[f]);
                labels_[f] = patchwork_.label(faces_[f]);
                parts_of_faces_[f] = part_of_label_[labels_[f]];
            }
        });
    }

    template <typename Work> void for_each_part(const Work& work) {
        ParallelFailure failure;
        for_each_share(static_cast<int>(parts_.size()), thread_count_, [&](int begin, int end) {
            for (int p = begin; p < end; ++p) {
                failure.guard([&] { work(parts_[p]); });
            }
        });
        failure.rethrow();
    }

    void iterate() {
        ++iteration_;
        const double least = *std::min_element(offsets_.begin(), offsets_.end());
        for_each_part([&](Part& part) { list_boundary(part); });
        send_strays();
        for_each_part([&](Part& part) {
            find_centers(part);
            begin_waves(part, least);
        });
        while (send_waves()) {
            for_each_part([&](Part& part) { go_on_with_waves(part); });
        }
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        for_each_part([&](Part& part) { take_labels(part); });
        for (std::size_t l = 0; l < offsets_.size(); ++l) {
            offsets_[l] += 0.25 * radius_ * (patchwork_.load[l] / mean_load_ - 1.0);
        }
    }

    /// Whether a face is on the boundary is unpredictable: without a branch all are written to the
    /// end of the queue, which grows past boundary faces only.
    void list_boundary(Part& part) {
        part.queue.resize(part.end_face - part.first_face);
        part.strays.clear();
        int count = 0;
        std::int64_t sides = 0;
        for (int f = part.first_face; f < part.end_face; ++f) {
            const int label = labels_[f];
            int differing = 0;
            for (int neighbor : neighbors_[f]) {
                differing += labels_[neighbor] != label;
            }
            inside_[f] = differing == 0;
            sides += differing;
            if (parts_of_faces_[f] == part.number) {
                part.queue[count] = f;
                count += differing > 0;
            } else if (differing > 0) {
                part.strays.push_back(f);
            }
        }
        part.queue.resize(count);
        part.sides = sides;
    }

    void send_strays() {
        for (const Part& part : parts_) {
            for (int face : part.strays) {
                parts_[parts_of_faces_[face]].queue.push_back(face);
            }
        }
    }

    /// Finds a face of each sub-mesh that is farthest from its boundary. Of several it takes one
    /// that is farthest from the previous centre, so that centres move on quickly; of these a
    /// random one, redrawn in each iteration: a fixed choice would pull all centres in one
    /// direction where faces are numbered regularly.
    void find_centers(Part& part) {
        sort_by_ring(part);
        std::fill(centers_.begin() + part.first_label, centers_.begin() + part.end_label, Center{});
        auto left = std::count_if(patchwork_.load.begin() + part.first_label,
                                  patchwork_.load.begin() + part.end_label,
                                  [](int load) { return load > 0; });
        // From the innermost ring outwards, until all have theirs.
        for (int ring = static_cast<int>(part.segments.size()) - 2; ring >= 0 && left > 0; --ring) {
            for (int i = part.segments[ring]; i < part.segments[ring + 1]; ++i) {
                const int face = part.queue[i];
                const std::pair<int, int> depth{ring, distances_[face]};
                Center& center = centers_[labels_[face]];
                if (center.depth > depth) {
                    continue;
                }
                left -= center.face < 0;
                const std::uint64_t rank =
                    Random(iteration_, static_cast<std::uint64_t>(faces_[face])).next();
                if (center.depth < depth || rank < center.rank) {
                    center = {face, depth, rank};
                }
            }
        }
        // A centre stays with its sub-mesh even if another one would reach it earlier: nothing is
        // nearer than a distance of 0, and all others are greater.
        for (int l = part.first_label; l < part.end_label; ++l) {
            if (centers_[l].face >= 0) {
                keys_[centers_[l].face] = make_key(0, l);
            }
        }
    }

    /// Lists the faces of the part's labels by their distance from the boundary: those at distance
    /// r are queue[segments[r] .. segments[r + 1]). Which neighbours are new can not be foreseen,
    /// so they are appended without a branch.
    void sort_by_ring(Part& part) {
        std::vector<int>& queue = part.queue;
        auto tail = static_cast<int>(queue.size());
        part.segments.assign(1, 0);
        for (int head = 0; head < tail;) {
            const int ring_end = tail;
            part.segments.push_back(ring_end);
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

    void begin_waves(Part& part, double least) {
        part.starts.clear();
        for (int l = part.first_label; l < part.end_label; ++l) {
            if (centers_[l].face >= 0) {
                part.starts.emplace_back(static_cast<int>(offsets_[l] - least), centers_[l].face);
            }
        }
        grow(part);
    }

    /// Makes waves that left a part come in where they went; false when there were none.
    bool send_waves() {
        bool any = false;
        for (Part& part : parts_) {
            any = any || !part.departures.empty();
            for (const Crossing& crossing : part.departures) {
                parts_[parts_of_faces_[crossing.face]].arrivals.push_back(crossing);
            }
            part.departures.clear();
        }
        return any;
    }

    void go_on_with_waves(Part& part) {
        part.starts.clear();
        for (const Crossing& crossing : part.arrivals) {
            if (crossing.key < keys_[crossing.face]) {
                keys_[crossing.face] = crossing.key;
                part.starts.emplace_back(distance_of(crossing.key), crossing.face);
            }
        }
        part.arrivals.clear();
        grow(part);
    }

    /// Multi-source shortest paths with a bucket queue (Dial, 1969), in the faces of the part's
    /// labels. What is reached beyond departs; in the end there is the one fixed point, whichever
    /// wave came first. All steps are equally long, so that the buckets lie one after the other in
    /// one queue: that of distance d ends at segments[d].
    void grow(Part& part) {
        std::sort(part.starts.begin(), part.starts.end());
        std::vector<int>& queue = part.queue;
        auto next_start = part.starts.begin();
        int tail = 0;
        part.segments.clear();
        const auto close_bucket = [&] {
            const auto distance = static_cast<int>(part.segments.size());
            for (; next_start != part.starts.end() && next_start->first == distance; ++next_start) {
                make_room(queue, tail);
                queue[tail++] = next_start->second;
            }
            part.segments.push_back(tail);
        };
        while (part.segments.size() < kStep) {
            close_bucket();
        }
        int head = 0;
        for (int d = 0; head < tail || next_start != part.starts.end(); ++d) {
            for (; head < part.segments[d]; ++head) {
                make_room(queue, tail);
                spread(part, queue[head], d, tail);
            }
            close_bucket();
        }
    }

    /// Appends the neighbours that the wave at `face` reaches first.
    void spread(Part& part, int face, int distance, int& tail) {
        const Key key = keys_[face];
        const bool is_center = distance_of(key) == 0;
        if (!is_center && distance_of(key) != distance) {
            return; // another wave was earlier
        }
        const Key reached = make_key(distance + kStep, label_of(key));
        for (int neighbor : neighbors_[face]) {
            if (parts_of_faces_[neighbor] != part.number) {
                part.departures.push_back({neighbor, reached});
                continue;
            }
            const Key current = keys_[neighbor];
            keys_[neighbor] = std::min(current, reached); // without a branch
            part.queue[tail] = neighbor;
            tail += reached < current;
        }
    }

    void take_labels(Part& part) {
        std::fill(part.load.begin(), part.load.end(), 0);
        for (int f = part.first_face; f < part.end_face; ++f) {
            const Key key = keys_[f];
            if (key != kUnreached) {
                labels_[f] = label_of(key);
                parts_of_faces_[f] = part_of_label_[labels_[f]];
                distances_[f] = distance_of(key);
                keys_[f] = kUnreached;
            }
            if (parts_of_faces_[f] == part.number) {
                part.load[labels_[f] - part.first_label] += weights_[f];
            } else {
                add_load(labels_[f], weights_[f]);
            }
        }
        for (int l = part.first_label; l < part.end_label; ++l) {
            add_load(l, part.load[l - part.first_label]);
        }
    }

    void add_load(int label, int weight) {
#pragma omp atomic
        patchwork_.load[label] += weight;
    }

    Patchwork& patchwork_;
    const int thread_count_;
    std::vector<Part> parts_;
    std::vector<Center> centers_;
    std::vector<PartNumber> part_of_label_;
    std::vector<double> offsets_;
    /// By the labels at first; all that follows is in this order, in which parts lie together.
    const std::vector<int> faces_;
    std::vector<std::array<int, 3>> neighbors_;
    std::vector<int> weights_;
    std::vector<int> labels_;
    /// The part of each face's label.
    std::vector<PartNumber> parts_of_faces_;
    /// From the centre that a face was given to, and the start of its wave.
    std::vector<int> distances_;
    /// Not reached yet from the boundary.
    std::vector<std::uint8_t> inside_;
    std::vector<Key> keys_;
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
