// SPDX-License-Identifier: GPL-3.0-or-later
#include "relaxation.h"

#include "patchwork_meshes.h"
#include "random.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <queue>
#include <tuple>
#include <utility>
#include <vector>

namespace spheroseg {
namespace {

using namespace test;

/// The same by plain breadth-first search and Dijkstra's algorithm: a step of the waves counts 8.
class PlainRelaxation {
public:
    explicit PlainRelaxation(const Patchwork& patchwork)
        : patchwork_(patchwork), labels_(cell_labels(patchwork)),
          distances_(patchwork.face_count(), 0), offsets_(patchwork.submesh_count(), 0.0) {}

    std::vector<int> labels_after(int iterations) {
        for (int i = 1; i <= iterations; ++i) {
            grow_from(deepest_faces(rings(), i));
            adjust_offsets();
        }
        return labels_;
    }

private:
    using Wave = std::pair<int, int>; // distance, label

    template <typename Visit> void for_each_neighbor(int f, const Visit& visit) const {
        for (int c = 0; c < 3; ++c) {
            if (patchwork_.neighbor(f, c) >= 0) {
                visit(patchwork_.neighbor(f, c));
            }
        }
    }

    std::vector<int> rings() const {
        std::vector<int> ring(labels_.size(), -1);
        std::queue<int> queue;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            for_each_neighbor(f, [&](int g) {
                if (labels_[g] != labels_[f] && ring[f] < 0) {
                    ring[f] = 0;
                    queue.push(f);
                }
            });
        }
        for (; !queue.empty(); queue.pop()) {
            for_each_neighbor(queue.front(), [&](int g) {
                if (ring[g] < 0) {
                    ring[g] = ring[queue.front()] + 1;
                    queue.push(g);
                }
            });
        }
        return ring;
    }

    std::vector<int> deepest_faces(const std::vector<int>& ring, int iteration) const {
        std::vector<int> center(offsets_.size(), -1);
        const auto rank = [&](int f) {
            // The least of the random numbers wins.
            return std::tuple(ring[f], distances_[f], ~Random(iteration, f).next());
        };
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            int& best = center[labels_[f]];
            best = best < 0 || rank(f) > rank(best) ? f : best;
        }
        return center;
    }

    void grow_from(const std::vector<int>& centers) {
        std::vector<Wave> reached(labels_.size(), {1 << 30, 0});
        using Item = std::pair<Wave, int>;
        std::priority_queue<Item, std::vector<Item>, std::greater<>> queue;
        const double least = *std::min_element(offsets_.begin(), offsets_.end());
        for (int l = 0; l < static_cast<int>(centers.size()); ++l) {
            reached[centers[l]] = {0, l};
            queue.push({{static_cast<int>(offsets_[l] - least), l}, centers[l]});
        }
        for (; !queue.empty(); queue.pop()) {
            const auto [wave, f] = queue.top();
            if (reached[f] < wave && reached[f].first > 0) {
                continue;
            }
            const Wave next = {wave.first + 8, wave.second};
            for_each_neighbor(f, [&](int g) {
                if (next < reached[g]) {
                    reached[g] = next;
                    queue.push({next, g});
                }
            });
        }
        for (std::size_t f = 0; f < labels_.size(); ++f) {
            std::tie(distances_[f], labels_[f]) = reached[f];
        }
    }

    void adjust_offsets() {
        std::vector<double> load(offsets_.size(), 0.0);
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            load[labels_[f]] += patchwork_.weight(f);
        }
        const double submesh_count = patchwork_.submesh_count();
        const double radius = 8 * std::sqrt(patchwork_.face_count() / submesh_count);
        for (std::size_t l = 0; l < load.size(); ++l) {
            offsets_[l] += 0.25 * radius * (load[l] / mean_load(patchwork_) - 1.0);
        }
    }

    const Patchwork& patchwork_;
    std::vector<int> labels_;
    std::vector<int> distances_;
    std::vector<double> offsets_;
};

TEST(Relaxation, IsThatOfPlainSearches) {
    const Levels levels(displaced_sphere(6));
    // On the mesh, large enough for several parts on one thread; and on a level with weights.
    for (int least_face_count : {levels.mesh.face_count(), 20000}) {
        for (int submesh_count : {4, 300, 1500}) {
            Patchwork start = levels.multilevel.coarsen(least_face_count, submesh_count);
            bisect(start, submesh_count, 2, 1);
            const std::vector<int> expected = PlainRelaxation(start).labels_after(7);
            for (int threads : {1, 3}) {
                Patchwork patchwork = start;
                relax(patchwork, 7, threads, {});
                EXPECT_EQ(cell_labels(patchwork), expected)
                    << start.face_count() << " faces, " << submesh_count << " sub-meshes, "
                    << threads << " threads";
            }
        }
    }
}

TEST(Relaxation, EvensLoadsAndShortensTheBoundary) {
    const Levels levels(displaced_sphere(4));
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 40);
    bisect(patchwork, 40, 0, 1);
    const int before = measures_of(levels, patchwork).boundary_edge_count;
    relax(patchwork, 30, 1, {});
    const Measures relaxed = measures_of(levels, patchwork);
    EXPECT_LT(relaxed.boundary_edge_count, 0.85 * before);
    EXPECT_GE(relaxed.min_submesh_triangles, 1);
    EXPECT_LT(relaxed.max_submesh_triangles, 2 * levels.mesh.face_count() / 40);
}

TEST(Relaxation, RecordsTheBoundaryBeforeEachIteration) {
    const Levels levels(displaced_sphere(4));
    Patchwork start = levels.multilevel.coarsen(levels.mesh.face_count(), 40);
    bisect(start, 40, 0, 1);
    std::vector<double> expected;
    for (int iterations = 0; iterations < 5; ++iterations) {
        Patchwork patchwork = start;
        relax(patchwork, iterations, 1, {});
        expected.push_back(measures_of(levels, patchwork).boundary_edge_count);
    }
    History history;
    AnnealControl control;
    control.history = &history;
    relax(start, 5, 2, control);
    EXPECT_EQ(history.boundary_edges, expected);
}

TEST(Relaxation, DoesNotDependOnThreadsAndKeepsPiecesConnected) {
    // Large enough for several threads.
    const Levels levels(displaced_sphere(6));
    Patchwork start = levels.multilevel.coarsen(levels.mesh.face_count(), 300);
    bisect(start, 300, 1, 1);
    std::vector<int> reference;
    for (int threads : {1, 2, 5}) {
        Patchwork patchwork = start;
        relax(patchwork, 12, threads, {});
        const Measures relaxed = measures_of(levels, patchwork);
        EXPECT_EQ(relaxed.disconnected_submesh_count, 0);
        EXPECT_EQ(patchwork.load, relaxed.submesh_triangles);
        const std::vector<int> labels = levels.multilevel.labels(patchwork);
        if (reference.empty()) {
            reference = labels;
        }
        EXPECT_EQ(labels, reference) << threads << " threads";
    }
}

} // namespace
} // namespace spheroseg
