// SPDX-License-Identifier: GPL-3.0-or-later
#include "bisection.h"

#include "random.h"
#include "threads.h"

#include <algorithm>
#include <numeric>

namespace spheroseg {

namespace {

/// Below this many faces a part is not worth a task of its own.
constexpr int kTaskFaces = 2048;

class Bisection {
public:
    Bisection(Patchwork& patchwork, std::uint64_t seed)
        : patchwork_(patchwork), seed_(seed), order_(patchwork.cells.size()),
          queue_(patchwork.cells.size()), visited_(patchwork.cells.size(), 0) {
        std::iota(order_.begin(), order_.end(), 0);
    }

    /// The faces order_[begin, end) have label `label` and are to be parted into `parts`.
    void split(int begin, int end, int label, int parts) {
        while (parts > 1) {
            const int face_count = end - begin;
            Random random(seed_, static_cast<std::uint64_t>(label) << 32 | parts);
            const int any = order_[begin + static_cast<int>(random.below(face_count))];
            const int far_face = sort_breadth_first(begin, end, label, any);
            sort_breadth_first(begin, end, label, far_face);

            const int left_parts = parts / 2;
            const int right_parts = parts - left_parts;
            const int middle = begin + left_face_count(begin, end, left_parts, parts);
            const int right_label = label + left_parts;
            for (int i = middle; i < end; ++i) {
                patchwork_.set_own_label(order_[i], right_label);
            }
            if (face_count > kTaskFaces) {
#pragma omp task default(shared) firstprivate(middle, end, right_label, right_parts)
                split(middle, end, right_label, right_parts);
            } else {
                split(middle, end, right_label, right_parts);
            }
            end = middle;
            parts = left_parts;
        }
    }

private:
    /// Orders a part breadth first from `start`, component after component; returns the last face.
    /// Each call flips the visited marks of the whole part. Which neighbours are new can not be
    /// foreseen, so they are appended without a branch.
    int sort_breadth_first(int begin, int end, int label, int start) {
        const std::uint8_t fresh = visited_[start];
        int tail = begin;
        const auto visit = [&](int face) {
            mark(face, !fresh);
            queue_[tail++] = face;
        };
        visit(start);
        int next_unseen = begin;
        for (int head = begin; tail < end; ++head) {
            if (head == tail) {
                while (visited_[order_[next_unseen]] != fresh) {
                    ++next_unseen;
                }
                visit(order_[next_unseen]);
            }
            const int face = queue_[head];
            for (int side : patchwork_.neighbors(face)) {
                const int neighbor = side < 0 ? face : side;
                const bool is_new = is_fresh(neighbor, label, fresh);
                if (tail + 1 < end) {
                    queue_[tail] = neighbor;
                    tail += is_new;
                    mark(is_new ? neighbor : face, !fresh);
                } else if (is_new && tail < end) {
                    visit(neighbor);
                }
            }
        }
        std::copy(queue_.begin() + begin, queue_.begin() + end, order_.begin() + begin);
        return order_[end - 1];
    }

    /// Marks of faces of another part are read too, but make no difference.
    bool is_fresh(int face, int label, std::uint8_t fresh) const {
        const bool unmarked = __atomic_load_n(&visited_[face], __ATOMIC_RELAXED) == fresh;
        return (patchwork_.label(face) == label) & unmarked;
    }
    void mark(int face, std::uint8_t value) {
        __atomic_store_n(&visited_[face], value, __ATOMIC_RELAXED);
    }

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
        return std::clamp(count, left_parts, face_count - (parts - left_parts));
    }

    Patchwork& patchwork_;
    const std::uint64_t seed_;
    std::vector<int> order_;
    std::vector<int> queue_;
    std::vector<std::uint8_t> visited_;
};

} // namespace

void bisect(Patchwork& patchwork, int submesh_count, std::uint64_t seed, int thread_count) {
    for (int f = 0; f < patchwork.face_count(); ++f) {
        patchwork.set_own_label(f, 0);
    }
    Bisection bisection(patchwork, seed);
    const int face_count = patchwork.face_count();
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
#pragma omp parallel num_threads(threads)
#pragma omp single
    bisection.split(0, face_count, 0, submesh_count);

    patchwork.tell_neighbors(thread_count);
    patchwork.load.resize(submesh_count);
    sum_loads(patchwork);
}

} // namespace spheroseg
