// SPDX-License-Identifier: GPL-3.0-or-later
#include "all_pairs_refinement.h"

#include "all_pairs_cohesion.h"
#include "cohesion_state.h"
#include "measures.h"
#include "refinement_cost.h"
#include "round_robin.h"
#include "test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace spheroseg {
namespace {

using namespace test;

struct Case {
    Case(const TriangleMesh& mesh, int k, std::uint64_t seed) : graph(build_dual_graph(mesh)) {
        const std::vector<Vec3> centroids = face_centroids_on_sphere(mesh, mesh.positions);
        labels = random_balanced_labels(mesh.face_count(), k, seed);
        SwapLimits limits;
        limits.max_iterations = 4;
        cohere_all_pairs(graph, centroids, k, seed, limits, labels);
    }
    DualGraph graph;
    std::vector<int> labels;
};

/// Eq. 1 from the text: phi counts the neighbours outside the sub-mesh.
int eq1(const DualGraph& graph, const std::vector<int>& labels, int face, int submesh) {
    const auto phi = [&](int f) {
        return std::count_if(graph.neighbors[f].begin(), graph.neighbors[f].end(), [&](int g) {
            return labels[g] != submesh;
        });
    };
    int cost = static_cast<int>(phi(face) * phi(face));
    for (int g : graph.neighbors[face]) {
        cost += labels[g] == submesh ? static_cast<int>(phi(g) * phi(g)) : 0;
    }
    return cost;
}

/// Algorithm 3: by how much the cost of two faces falls when they exchange labels.
int fall(const DualGraph& graph, const std::vector<int>& labels, int a, int b) {
    std::vector<int> after = labels;
    std::swap(after[a], after[b]);
    return eq1(graph, labels, a, labels[a]) + eq1(graph, labels, b, labels[b]) -
        eq1(graph, after, a, after[a]) - eq1(graph, after, b, after[b]);
}

bool on_boundary(const DualGraph& graph, const std::vector<int>& labels, int face) {
    return std::any_of(graph.neighbors[face].begin(), graph.neighbors[face].end(), [&](int g) {
        return labels[g] != labels[face];
    });
}

bool improves(const DualGraph& graph, const std::vector<int>& labels, int a, int b) {
    return labels[a] != labels[b] && on_boundary(graph, labels, a) &&
        on_boundary(graph, labels, b) && fall(graph, labels, a, b) > 0;
}

std::set<int> within_two_steps(const DualGraph& graph, int face) {
    std::set<int> faces{face};
    for (int step = 0; step < 2; ++step) {
        for (int f : std::set<int>(faces)) {
            faces.insert(graph.neighbors[f].begin(), graph.neighbors[f].end());
        }
    }
    return faces;
}

/// One iteration in the plainest way; checks that every swap lowers Eq. 1 when it is made.
int iterate_plainly(const DualGraph& graph, std::vector<int>& labels) {
    const RoundRobin schedule(graph.face_count());
    int swap_count = 0;
    for (int round = 0; round < schedule.round_count(); ++round) {
        std::vector<std::pair<int, int>> decided;
        schedule.for_each_run(round, 0, schedule.slot_count(), [&](const PairRun& run) {
            for (int i = 0; i < run.count; ++i) {
                if (improves(graph, labels, run.first + i, run.second - i)) {
                    decided.emplace_back(run.first + i, run.second - i);
                }
            }
        });
        std::set<int> taken;
        for (const auto& [a, b] : decided) {
            std::set<int> near = within_two_steps(graph, a);
            near.merge(within_two_steps(graph, b));
            const bool yields =
                std::any_of(near.begin(), near.end(), [&](int f) { return taken.count(f) > 0; });
            taken.insert({a, b});
            if (!yields) {
                EXPECT_GT(fall(graph, labels, a, b), 0);
                std::swap(labels[a], labels[b]);
                ++swap_count;
            }
        }
    }
    return swap_count;
}

TEST(RefinementCost, HandCountedOnATetrahedron) {
    // Faces 0 and 1 against 2 and 3; every face touches every other.
    const DualGraph graph = build_dual_graph(tetrahedron());
    const std::vector<int> labels{0, 0, 1, 1};
    EXPECT_EQ(boundary_side_count(graph, labels, 0, 0), 2);
    EXPECT_EQ(boundary_side_count(graph, labels, 0, 1), 1);
    EXPECT_EQ(refinement_cost(graph, labels, 0, 0), 4 + 4);
    EXPECT_EQ(refinement_energy(graph, labels), 4 * 8);
    EXPECT_EQ(swap_gain(graph, labels.data(), 0, 2), 0);
}

TEST(RefinementCost, GainIsTheFallOfEquationOneForNeighboursToo) {
    const Case mesh(icosphere(1), 6, 0);
    const int face_count = mesh.graph.face_count();
    for (int a = 0; a < face_count; ++a) {
        for (int b = 0; b < face_count; ++b) {
            EXPECT_EQ(swap_gain(mesh.graph, mesh.labels.data(), a, b),
                      fall(mesh.graph, mesh.labels, a, b))
                << a << " and " << b;
        }
    }
}

TEST(Refinement, MakesTheSwapsOfThePlainestVersionAndEachLowersEquationOne) {
    for (const TriangleMesh& mesh : {icosphere(2), bipyramid(80), long_thin_limb(6, 20)}) {
        for (int k : {3, 17, 60}) {
            Case start(mesh, k, 7);
            std::vector<int> expected = start.labels;
            const std::vector<int> before = start.labels;
            const double edges_before = count_boundary_edges(start.graph, before);
            SwapLimits limits;
            limits.max_iterations = 1;
            const SwapIterations history = refine_all_pairs(start.graph, limits, start.labels);
            ASSERT_EQ(history.count(), 1);
            EXPECT_EQ(history.swaps[0], iterate_plainly(start.graph, expected));
            if (count_boundary_edges(start.graph, expected) < edges_before) {
                EXPECT_EQ(start.labels, expected);
            } else {
                EXPECT_EQ(start.labels, before);
            }
            EXPECT_EQ(history.boundary_edges[0], count_boundary_edges(start.graph, start.labels));
        }
    }
}

TEST(Refinement, EndsWithNoImprovingPairWhereAnIterationWithoutASwapEndsIt) {
    int ended_so = 0;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        Case mesh(icosphere(2), 8, seed);
        const SwapIterations history = refine_all_pairs(mesh.graph, {}, mesh.labels);
        if (history.swaps.back() > 0.0) {
            continue;
        }
        ++ended_so;
        for (int a = 0; a < mesh.graph.face_count(); ++a) {
            for (int b = 0; b < a; ++b) {
                EXPECT_FALSE(improves(mesh.graph, mesh.labels, a, b)) << a << " and " << b;
            }
        }
    }
    EXPECT_GT(ended_so, 0);
}

TEST(Refinement, LowersTheBoundaryUntilItStopsFallingAndKeepsTheCounts) {
    Case mesh(icosphere(3), 30, 2);
    const std::vector<int> start = mesh.labels;
    const SwapIterations history = refine_all_pairs(mesh.graph, {}, mesh.labels);
    const auto& edges = history.boundary_edges;
    for (int i = 1; i + 1 < history.count(); ++i) {
        EXPECT_LT(edges[i], edges[i - 1]);
    }
    EXPECT_EQ(edges.back(), edges[edges.size() - 2]);
    EXPECT_EQ(count_boundary_edges(mesh.graph, mesh.labels), edges.back());
    EXPECT_LT(count_boundary_edges(mesh.graph, mesh.labels),
              count_boundary_edges(mesh.graph, start));
    for (int s = 0; s < 30; ++s) {
        EXPECT_EQ(std::count(mesh.labels.begin(), mesh.labels.end(), s),
                  std::count(start.begin(), start.end(), s));
    }
}

TEST(Refinement, TheNumberOfThreadsDoesNotMatter) {
    const Case start(long_thin_limb(8, 1050), 90, 1); // 8,400 slots: two threads
    std::vector<int> expected = start.labels;
    SwapLimits limits;
    limits.max_iterations = 1;
    limits.thread_count = 1;
    const SwapIterations history = refine_all_pairs(start.graph, limits, expected);
    for (int threads : {1, 2}) {
        std::vector<int> labels = start.labels;
        limits.thread_count = threads;
        EXPECT_EQ(refine_all_pairs(start.graph, limits, labels).swaps, history.swaps);
        EXPECT_EQ(labels, expected) << threads << " threads";
    }
}

TEST(Refinement, StopsAtLimitsAndOnCancel) {
    Case mesh(icosphere(2), 10, 0);
    const std::vector<int> start = mesh.labels;
    const Deadline passed(1e-9);
    SwapLimits limits;
    limits.deadline = &passed;
    EXPECT_TRUE(refine_all_pairs(mesh.graph, limits, mesh.labels).time_limit_hit);
    EXPECT_EQ(mesh.labels, start);
    const auto refuse = [](double, const char*) { return false; };
    EXPECT_THROW(refine_all_pairs(mesh.graph, {}, mesh.labels, refuse), Cancelled);
}

} // namespace
} // namespace spheroseg
