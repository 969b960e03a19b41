// SPDX-License-Identifier: GPL-3.0-or-later
#include "bisection.h"

#include "random.h"
#include "threads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

namespace spheroseg {

namespace {

/// Up to so many faces a part is cut all the way by one thread.
constexpr int kSmallPart = 8192;

/// The faces [begin, end) of the order have label `label` and are to be cut into `count` parts.
struct Part {
    int begin;
    int end;
    int label;
    int count;
};

class Bisection {
public:
    Bisection(const Patchwork& patchwork, std::uint64_t seed, int thread_count)
        : patchwork_(patchwork), seed_(seed), neighbors_(neighbor_table(patchwork, thread_count)),
          order_(patchwork.cells.size()), queue_(patchwork.cells.size()),
          marks_(patchwork.cells.size(), mark_of(0)) {
        std::iota(order_.begin(), order_.end(), 0);
    }

    void give_labels(Patchwork& patchwork, int submesh_count, int thread_count) const {
        for (int f = 0; f < patchwork.face_count(); ++f) {
            patchwork.set_own_label(f, marks_[f] / 2);
        }
        patchwork.load.resize(submesh_count);
        patchwork.tell_neighbors(thread_count);
        sum_loads(patchwork);
    }

    /// Cuts all faces into parts, each part of a round in two, side by side.
    void cut_all(int count, int thread_count, const Progress& progress) {
        std::vector<Part> parts{{0, patchwork_.face_count(), 0, count}};
        const double rounds = std::max(1.0, std::ceil(std::log2(count)));
        for (int round = 0; !parts.empty(); ++round) {
            report_progress(progress, std::min(1.0, round / rounds), "Bisection");
            const auto part_count = static_cast<int>(parts.size());
            std::vector<std::array<Part, 2>> halves(parts.size());
            for_each_task(part_count, thread_count, [&](int i) {
                if (parts[i].end - parts[i].begin <= kSmallPart) {
                    cut_all_the_way(parts[i]);
                } else {
                    halves[i] = cut_in_halves(parts[i]);
                }
            });
            parts.clear();
            for (const std::array<Part, 2>& two : halves) {
                std::copy_if(two.begin(),
                             two.end(),
                             std::back_inserter(parts),
                             [](const Part& part) { return part.count > 1; });
            }
        }
    }

    /// Cuts each sub-mesh of the patchwork that is to have several parts in two; see cut_in_two.
    void cut_each(std::vector<int>& parts) {
        const auto submesh_count = static_cast<int>(parts.size());
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            set_mark(f, mark_of(patchwork_.label(f)));
        }
        FacesByLabel sorted = sort_by_label(patchwork_);
        order_ = std::move(sorted.faces);
        const std::vector<int>& begin = sorted.begin;
        for (int l = 0; l < submesh_count; ++l) {
            if (parts[l] > 1) {
                const auto new_label = static_cast<int>(parts.size());
                if (begin[l] < begin[l + 1]) {
                    cut(begin[l], begin[l + 1], l, parts[l], new_label);
                }
                parts.push_back(parts[l] - parts[l] / 2);
                parts[l] /= 2;
            }
        }
    }

private:
    void cut_all_the_way(Part part) {
        while (part.count > 1) {
            const std::array<Part, 2> halves = cut_in_halves(part);
            cut_all_the_way(halves[1]);
            part = halves[0];
        }
    }

    std::array<Part, 2> cut_in_halves(const Part& part) {
        const int left_count = part.count / 2;
        const int right_label = part.label + left_count;
        const int middle = cut(part.begin, part.end, part.label, part.count, right_label);
        return {{{part.begin, middle, part.label, left_count},
                 {middle, part.end, right_label, part.count - left_count}}};
    }

    /// Cuts the faces order_[begin, end), which have label `label`, into a side for parts / 2
    /// sub-meshes and one for the others, which gets `right_label`. Returns where that one begins.
    int cut(int begin, int end, int label, int parts, int right_label) {
        const int face_count = end - begin;
        Random random(seed_, static_cast<std::uint64_t>(label) << 32 | parts);
        const int any = order_[begin + static_cast<int>(random.below(face_count))];
        const int far_face = sort_breadth_first(begin, end, any);
        sort_breadth_first(begin, end, far_face);
        const int middle = begin + left_face_count(begin, end, parts / 2, parts);
        for (int i = middle; i < end; ++i) {
            set_mark(order_[i], mark_of(right_label));
        }
        return middle;
    }

    /// The mark of a face: twice its label, plus 1 after an odd number of searches of its part. So
    /// a search needs no pass to clear marks, and parts that are searched side by side differ.
    static constexpr int mark_of(int label) { return 2 * label; }

    /// Orders a part breadth first from `start`, component after component; returns the last face.
    /// Each search flips the lowest bit of all marks of the part. Whether a neighbour is new is
    /// unpredictable, so it is appended without a branch.
    int sort_breadth_first(int begin, int end, int start) {
        const int fresh = marks_[start];
        const int met = fresh ^ 1;
        int tail = begin;
        const auto visit = [&](int face) {
            set_mark(face, met);
            queue_[tail++] = face;
        };
        visit(start);
        int next_unseen = begin;
        for (int head = begin; tail < end; ++head) {
            if (head == tail) {
                while (marks_[order_[next_unseen]] != fresh) {
                    ++next_unseen;
                }
                visit(order_[next_unseen]);
            }
            const int face = queue_[head];
            for (int neighbor : neighbors_[face]) {
                const bool is_new = mark(neighbor) == fresh;
                if (tail + 1 < end) {
                    queue_[tail] = neighbor;
                    tail += is_new;
                    set_mark(is_new ? neighbor : face, met);
                } else if (is_new && tail < end) {
                    visit(neighbor);
                }
            }
        }
        std::copy(queue_.begin() + begin, queue_.begin() + end, order_.begin() + begin);
        return order_[end - 1];
    }

    /// Marks of faces of another part are read too, but are none of this part's.
    int mark(int face) const { return __atomic_load_n(&marks_[face], __ATOMIC_RELAXED); }
    void set_mark(int face, int value) { __atomic_store_n(&marks_[face], value, __ATOMIC_RELAXED); }

    /// Where to cut an ordered part so that the left side weighs left_parts / parts of it.
    int left_face_count(int begin, int end, int left_parts, int parts) const {
        const int face_count = end - begin;
        std::int64_t total = 0;
        for (int i = begin; i < end; ++i) {
            total += patchwork_.cells[order_[i]].weight;
        }
        std::int64_t left = 0;
        int count = 0;
        while (count < face_count && 2 * left * parts < (2 * total * left_parts - parts)) {
            left += patchwork_.cells[order_[begin + count++]].weight;
        }
        // A face for each part, if there are so many.
        const int least = std::min(left_parts, face_count);
        return std::clamp(count, least, std::max(least, face_count - (parts - left_parts)));
    }

    const Patchwork& patchwork_;
    const std::uint64_t seed_;
    const std::vector<std::array<int, 3>> neighbors_;
    std::vector<int> order_;
    std::vector<int> queue_;
    std::vector<int> marks_;
};

} // namespace

void bisect(Patchwork& patchwork,
            int submesh_count,
            std::uint64_t seed,
            int thread_count,
            const Progress& progress) {
    Bisection bisection(patchwork, seed, thread_count);
    const int face_count = patchwork.face_count();
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
    bisection.cut_all(submesh_count, threads, progress);
    bisection.give_labels(patchwork, submesh_count, thread_count);
}

void cut_in_two(Patchwork& patchwork, std::vector<int>& parts, std::uint64_t seed) {
    Bisection bisection(patchwork, seed, 1);
    bisection.cut_each(parts);
    bisection.give_labels(patchwork, static_cast<int>(parts.size()), 1);
}

} // namespace spheroseg
