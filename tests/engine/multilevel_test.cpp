// SPDX-License-Identifier: GPL-3.0-or-later
#include "multilevel.h"

#include "patchwork_meshes.h"
#include "replay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

/// Returns the number of levels on which holes open.
int expect_sound_levels(const Levels& levels) {
    int opened = 0;
    Patchwork patchwork = levels.multilevel.coarsen(200, 9);
    bisect(patchwork, 9, 0, 2);
    EXPECT_EQ(repair(patchwork), 0);
    std::vector<int> loads = patchwork.load;
    while (true) {
        int weight = 0;
        std::vector<int> recount(9, 0);
        for (const Cell& cell : patchwork.cells) {
            EXPECT_GE(cell.weight, 1);
            weight += cell.weight;
            recount[cell.label] += cell.weight;
        }
        EXPECT_EQ(weight, levels.mesh.face_count());
        EXPECT_EQ(recount, loads);
        EXPECT_EQ(patchwork.load, loads);
        EXPECT_TRUE(is_sound(measures_of_level(patchwork)));
        if (patchwork.face_count() == levels.mesh.face_count()) {
            return opened;
        }
        if (levels.multilevel.uncoarsen(patchwork)) {
            ++opened;
            EXPECT_EQ(repair_unsound(patchwork), 0);
            loads = patchwork.load;
        }
    }
}

TEST(Multilevel, EveryLevelKeepsWeightsLoadsAndSoundness) {
    EXPECT_EQ(expect_sound_levels(Levels(displaced_sphere(4))), 0);
    EXPECT_EQ(expect_sound_levels(Levels(flipped_sphere(4, 3000))), 0);
    EXPECT_EQ(expect_sound_levels(Levels(open_grid(40))), 0);
    EXPECT_EQ(expect_sound_levels(Levels(torus(60, 20))), 0);
    EXPECT_GT(expect_sound_levels(Levels(grid_with_holes(44))), 0);
    EXPECT_GT(expect_sound_levels(Levels(pinholed(displaced_sphere(5), 50))), 0);
    EXPECT_GT(expect_sound_levels(Levels(sieve(displaced_sphere(5), 0.03, 1))), 0);
}

/// Where corner 0 of the cell is in the face that it is: faces may be turned.
int turn_of(const Patchwork& named, int cell, const std::array<int, 3>& neighbors) {
    for (int turn = 0; turn < 3; ++turn) {
        bool fits = true;
        for (int c = 0; c < 3; ++c) {
            const int across = named.neighbor(cell, c);
            fits = fits && neighbors[(c + turn) % 3] == (across < 0 ? -1 : named.label(across));
        }
        if (fits) {
            return turn;
        }
    }
    return -1;
}

/// A patchwork whose labels name the faces of a mesh has the neighbours of its dual graph, and
/// walks keep to their vertex.
void expect_linked_like(const TriangleMesh& mesh, const Patchwork& named) {
    const DualGraph graph = build_dual_graph(mesh, 1);
    ASSERT_EQ(named.face_count(), mesh.face_count());
    std::vector<int> turns;
    for (int i = 0; i < named.face_count(); ++i) {
        turns.push_back(turn_of(named, i, graph.neighbors[named.label(i)]));
        ASSERT_GE(turns.back(), 0);
    }
    const auto vertex = [&](int cell, int corner) {
        return mesh.faces[named.label(cell)][(corner + turns[cell]) % 3];
    };
    for (int i = 0; i < named.face_count(); ++i) {
        for (int c = 0; c < 3; ++c) {
            for (int at : {c, next_corner(c)}) {
                if (named.neighbor(i, c) < 0) {
                    continue;
                }
                const Step step = named.step_from({i, at, c});
                ASSERT_EQ(step.face, named.neighbor(i, c));
                ASSERT_EQ(vertex(step.face, step.at), vertex(i, at));
                // The walk goes on across the other side at the vertex: one step back from there
                // leads across the side that was taken.
                const int other_side = step.exit == step.at ? previous_corner(step.at) : step.at;
                const Step back = named.step_from({step.face, step.at, other_side});
                ASSERT_EQ(back.face, i);
                ASSERT_EQ(back.at, at);
            }
        }
    }
}

/// The finest level, labelled by the faces that the cells are.
Patchwork named_finest(const TriangleMesh& mesh, const Multilevel& multilevel) {
    std::vector<int> faces(mesh.face_count());
    std::iota(faces.begin(), faces.end(), 0);
    Patchwork named = multilevel.coarsen(mesh.face_count(), mesh.face_count());
    multilevel.set_labels(named, faces);
    EXPECT_EQ(multilevel.labels(named), faces);
    return named;
}

TEST(Multilevel, EveryLevelIsTheMeshThatTheCollapsesLeave) {
    for (const TriangleMesh& mesh : {limbed_figure(3),
                                     open_grid(20),
                                     grid_with_holes(24),
                                     pinholed(displaced_sphere(4), 20),
                                     sieve(flipped_sphere(4, 3000), 0.1, 1),
                                     torus(20, 10),
                                     moebius_strip(40, 5),
                                     icosahedron()}) {
        const Levels levels(mesh);
        expect_linked_like(mesh, named_finest(mesh, Multilevel(mesh, levels.graph)));
        const Patchwork finest = named_finest(mesh, levels.multilevel);
        Replay replay(levels.hierarchy, mesh.face_count());
        int step = levels.hierarchy.step_count();
        int level_count = 0;
        for (int count = 0; count < mesh.face_count(); ++level_count) {
            // A cell is the first one of those that it stands for.
            Patchwork level = levels.multilevel.coarsen(count + 1, 1);
            count = level.face_count();
            Patchwork spread = level;
            for (int i = 0; i < count; ++i) {
                spread.set_label(i, i);
            }
            while (spread.face_count() < mesh.face_count()) {
                levels.multilevel.uncoarsen(spread);
            }
            TriangleMesh left = replay.living_mesh(mesh.vertex_count());
            while (left.face_count() < count) {
                ASSERT_NO_FATAL_FAILURE(replay.undo(--step));
                left = replay.living_mesh(mesh.vertex_count());
            }
            ASSERT_EQ(left.face_count(), count);
            std::vector<int> place(mesh.face_count(), -1);
            int living = 0;
            for (int f = 0; f < mesh.face_count(); ++f) {
                place[f] = replay.lives(f) ? living++ : -1;
            }
            for (int i = mesh.face_count() - 1; i >= 0; --i) {
                level.set_label(spread.label(i), place[finest.label(i)]);
            }
            ASSERT_NO_FATAL_FAILURE(expect_linked_like(left, level));
        }
        EXPECT_EQ(level_count, levels.multilevel.level_count());
    }
}

TEST(Multilevel, WhatACellStandsForFollowsInTheOrderOfTheCells) {
    const Levels levels(displaced_sphere(4));
    std::vector<int> weights(levels.mesh.face_count());
    Random random(7);
    for (int& weight : weights) {
        weight = 1 + static_cast<int>(random.below(9));
    }
    const Multilevel weighted = levels.multilevel.with_weights(weights);
    EXPECT_EQ(weighted.total_weight(), std::accumulate(weights.begin(), weights.end(), 0));
    for (const Multilevel& multilevel : {levels.multilevel, weighted}) {
        Patchwork next = multilevel.coarsen(1, 1);
        for (int level = 1; level < multilevel.level_count(); ++level) {
            Patchwork patchwork = next;
            patchwork.load.resize(patchwork.cells.size());
            for (int i = 0; i < patchwork.face_count(); ++i) {
                patchwork.set_label(i, i);
                patchwork.load[i] = patchwork.weight(i);
            }
            const std::vector<int> loads = patchwork.load;
            while (patchwork.face_count() < levels.mesh.face_count()) {
                multilevel.uncoarsen(patchwork);
                const std::vector<int> labels = cell_labels(patchwork);
                EXPECT_TRUE(std::is_sorted(labels.begin(), labels.end()));
                sum_loads(patchwork);
                EXPECT_EQ(patchwork.load, loads);
            }
            multilevel.uncoarsen(next);
        }
        EXPECT_EQ(next.face_count(), levels.mesh.face_count());
    }
}

TEST(Multilevel, UndoneSubdivisionsAreLevelsOfAQuarterEach) {
    const auto counts = [](const TriangleMesh& mesh, std::vector<int> wanted) {
        const Multilevel multilevel = Levels(mesh).multilevel;
        for (int& count : wanted) {
            count = multilevel.quartered_cell_count(count);
        }
        return wanted;
    };
    EXPECT_EQ(counts(icosphere(4), {6000, 5120, 1281, 1280, 321, 21, 20, 1}),
              (std::vector<int>{5120, 5120, 5120, 1280, 1280, 80, 20, 20}));
    EXPECT_EQ(counts(open_grid(20), {800, 201, 200, 51, 1}),
              (std::vector<int>{800, 800, 200, 200, 50}));
    EXPECT_EQ(counts(flipped_sphere(4, 1), {5120, 1280, 1}), (std::vector<int>(3, 5120)));
}

TEST(Multilevel, DoesNotDependOnThreads) {
    // Large enough for several threads.
    for (const TriangleMesh& mesh : {displaced_sphere(6),
                                     open_grid(180),
                                     moebius_strip(600, 40),
                                     sieve(displaced_sphere(6), 0.03, 1)}) {
        const Levels levels(mesh);
        for (int threads : {2, 5}) {
            const Multilevel other(levels.hierarchy, mesh.face_count(), threads);
            ASSERT_EQ(other.level_count(), levels.multilevel.level_count());
            Patchwork expected = levels.multilevel.coarsen(1, 1);
            Patchwork found = other.coarsen(1, 1, threads);
            for (int level = 0; level < other.level_count(); ++level) {
                ASSERT_EQ(found.face_count(), expected.face_count());
                for (int f = 0; f < found.face_count(); ++f) {
                    ASSERT_TRUE(std::equal(
                        found.cells[f].side, found.cells[f].side + 3, expected.cells[f].side));
                    ASSERT_EQ(found.weight(f), expected.weight(f));
                }
                EXPECT_EQ(levels.multilevel.uncoarsen(expected), other.uncoarsen(found, threads));
            }
            EXPECT_EQ(cell_labels(named_finest(mesh, other)),
                      cell_labels(named_finest(mesh, levels.multilevel)));
        }
    }
}

} // namespace
} // namespace spheroseg
