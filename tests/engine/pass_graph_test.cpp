// SPDX-License-Identifier: GPL-3.0-or-later
#include "pass_graph.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <queue>
#include <set>
#include <utility>
#include <vector>

namespace spheroseg {
namespace {

using namespace test;

/// All moves of single faces that are allowed, from all sides of the mesh.
std::vector<Move> allowed_moves(const Patchwork& patchwork) {
    std::vector<Move> moves;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            Move move;
            if (is_allowed_pass(patchwork, {f, c}, move)) {
                moves.push_back(move);
            }
        }
    }
    return moves;
}

/// The graph as a set of pairs (from, to), and its distances by plain breadth-first search.
struct Reference {
    explicit Reference(const Patchwork& patchwork) : count(patchwork.submesh_count()) {
        for (const Move& move : allowed_moves(patchwork)) {
            open.insert({move.from, move.to});
        }
    }

    /// Steps from `label` (`outward`) or to it, to the nearest of `ends`; -1: out of reach.
    int distance(int label, bool outward, const std::set<int>& ends) const {
        std::vector<int> distances(count, -1);
        std::queue<int> queue;
        queue.push(label);
        distances[label] = 0;
        for (; !queue.empty(); queue.pop()) {
            const int at = queue.front();
            if (at != label && ends.count(at) > 0) {
                return distances[at];
            }
            for (const auto& [from, to] : open) {
                const int other = outward ? to : from;
                if ((outward ? from : to) == at && distances[other] < 0) {
                    distances[other] = distances[at] + 1;
                    queue.push(other);
                }
            }
        }
        return -1;
    }

    int count;
    std::set<std::pair<int, int>> open;
};

/// Searches from or to a sub-mesh drawn at random for one of two others, and expects a path that is
/// open and as short as by brute force, or none where there is none. Returns whether there is one.
bool search_once(const Patchwork& patchwork,
                 PassGraph& graph,
                 const Reference& reference,
                 Random& random) {
    const auto draw = [&] { return static_cast<int>(random.below(patchwork.submesh_count())); };
    const int label = draw();
    const bool outward = random.below(2) == 0;
    std::set<int> ends;
    while (ends.size() < 2) {
        ends.insert(draw());
    }
    const std::vector<int>& path = graph.find_path(
        label, outward, [&](int other) { return ends.count(other) > 0; }, random);
    EXPECT_EQ(static_cast<int>(path.size()), reference.distance(label, outward, ends) + 1);
    if (path.empty()) {
        return false;
    }
    EXPECT_EQ(outward ? path.front() : path.back(), label);
    EXPECT_EQ(ends.count(outward ? path.back() : path.front()), 1u);
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        EXPECT_EQ(reference.open.count({path[i], path[i + 1]}), 1u);
    }
    return true;
}

TEST(PassGraph, PathsAreShortestWhereNothingMoved) {
    const Levels levels(displaced_sphere(3));
    int missing = 0;
    for (int k : {40, levels.mesh.face_count() / 4, levels.mesh.face_count() / 2}) {
        Patchwork patchwork = ragged_patchwork(levels, k, 1);
        SubmeshBoundaries boundaries(patchwork);
        PassGraph graph(patchwork, boundaries);
        const Reference reference(patchwork);
        Random random(3);
        for (int i = 0; i < 100; ++i) {
            missing += !search_once(patchwork, graph, reference, random);
            ASSERT_FALSE(HasFailure()) << k << ", search " << i;
        }
    }
    EXPECT_GT(missing, 10);
}

TEST(PassGraph, PathsAreShortestWhereFacesMoved) {
    const Levels levels(displaced_sphere(2));
    int found = 0;
    int missing = 0;
    for (int k : {20, levels.mesh.face_count() / 4, levels.mesh.face_count() / 2}) {
        Patchwork patchwork = ragged_patchwork(levels, k, 2);
        SubmeshBoundaries boundaries(patchwork);
        PassGraph graph(patchwork, boundaries);
        Random random(4);
        for (int i = 0; i < 300; ++i) {
            const std::vector<Move> moves = allowed_moves(patchwork);
            graph.pass(moves[random.below(static_cast<std::uint32_t>(moves.size()))]);
            const bool is_found = search_once(patchwork, graph, Reference(patchwork), random);
            (is_found ? found : missing) += 1;
            ASSERT_FALSE(HasFailure()) << k << ", search " << i;
        }
    }
    EXPECT_GT(found, 300);
    EXPECT_GT(missing, 20);
}

} // namespace
} // namespace spheroseg
