// SPDX-License-Identifier: GPL-3.0-or-later
#include "patchwork.h"

#include "anneal.h"
#include "balance.h"
#include "bisection.h"
#include "boundary.h"
#include "exact_cut.h"
#include "free_annealing.h"
#include "patchwork_meshes.h"
#include "relaxation.h"
#include "replay.h"
#include "warm_start.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace spheroseg {
namespace {

using namespace test;

/// Soundness and boundary edges after a move, by relabelling a copy and measuring it anew.
Measures after(const Levels& levels, Patchwork patchwork, const Move& move) {
    apply(patchwork, move);
    return measures_of(levels, patchwork);
}

TEST(Patchwork, SingleMovesAreAllowedExactlyWhenBothSubmeshesStaySound) {
    int allowed_count = 0;
    int refused_count = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const Levels levels(flipped_sphere(2, 60, seed));
        const Patchwork patchwork = ragged_patchwork(levels, 12, seed);
        const Measures before = measures_of(levels, patchwork);
        ASSERT_TRUE(is_sound(before));
        for (int f = 0; f < patchwork.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                Move move;
                if (!describe_single(patchwork, f, c, move)) {
                    continue;
                }
                const bool allowed = single_is_allowed(patchwork, f, c, move);
                const Measures moved = after(levels, patchwork, move);
                EXPECT_EQ(moved.boundary_edge_count - before.boundary_edge_count,
                          move.boundary_change);
                if (allowed) {
                    EXPECT_TRUE(is_sound(moved)) << "face " << f << " corner " << c;
                } else {
                    EXPECT_FALSE(is_sound(moved)) << "face " << f << " corner " << c;
                }
                (allowed ? allowed_count : refused_count)++;
            }
        }
    }
    EXPECT_GT(allowed_count, 100);
    EXPECT_GT(refused_count, 100);
}

TEST(Patchwork, FanMovesThatAreAllowedKeepBothSubmeshesSound) {
    int allowed_count = 0;
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
        const Levels levels(flipped_sphere(2, 60, seed));
        const Patchwork patchwork = ragged_patchwork(levels, 12, seed + 10);
        const Measures before = measures_of(levels, patchwork);
        ASSERT_TRUE(is_sound(before));
        for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
            Fan fan;
            if (!describe_fan(patchwork, i / 6, i % 3, (i / 3) % 2 != 0, fan)) {
                continue;
            }
            const Measures moved = after(levels, patchwork, fan.move);
            EXPECT_EQ(moved.boundary_edge_count - before.boundary_edge_count,
                      fan.move.boundary_change);
            if (fan_is_allowed(patchwork, fan)) {
                EXPECT_TRUE(is_sound(moved)) << "face " << i / 6 << " way " << i % 6;
                ++allowed_count;
            }
        }
    }
    EXPECT_GT(allowed_count, 200);
}

TEST(Patchwork, TheShorterOfTwoFansIsTheShorterOneOfThoseThatBothFacesDescribe) {
    int turned_away = 0;
    int compared = 0;
    for (const TriangleMesh& mesh :
         {flipped_sphere(2, 60), grid_with_holes(12), moebius_strip(30, 5)}) {
        const Levels levels(mesh);
        const Patchwork patchwork = ragged_patchwork(levels, 12, 4);
        const Measures before = measures_of(levels, patchwork);
        for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
            const int face = i / 6;
            const int corner = i % 3;
            const bool forward = (i / 3) % 2 != 0;
            Fan own;
            Fan shorter;
            const bool has_own = describe_fan(patchwork, face, corner, forward, own);
            const bool has_shorter =
                describe_shorter_fan(patchwork, face, corner, forward, shorter);
            if (patchwork.label_across(face, corner) < 0 ||
                patchwork.label_across(face, corner) == patchwork.label(face)) {
                EXPECT_FALSE(has_shorter);
                continue;
            }
            // The same vertex and edge, seen from the face across.
            const int at = forward ? next_corner(corner) : corner;
            const Step across = patchwork.step_from({face, at, corner});
            const int side = corner_of(patchwork.cells[face].side[corner]);
            Fan other;
            const bool has_other =
                describe_fan(patchwork, across.face, side, across.at != side, other);
            ASSERT_EQ(has_shorter, has_own || has_other);
            if (!has_shorter) {
                continue;
            }
            const bool is_other =
                !has_own || (has_other && other.move.face_count < own.move.face_count);
            const Move& expected = is_other ? other.move : own.move;
            EXPECT_EQ(shorter.move.from, expected.from);
            EXPECT_EQ(shorter.move.to, expected.to);
            EXPECT_EQ(shorter.move.weight, expected.weight);
            EXPECT_EQ(shorter.move.boundary_change, expected.boundary_change);
            EXPECT_TRUE(std::equal(shorter.move.faces,
                                   shorter.move.faces + shorter.move.face_count,
                                   expected.faces,
                                   expected.faces + expected.face_count));
            EXPECT_EQ(fan_is_allowed(patchwork, shorter),
                      fan_is_allowed(patchwork, is_other ? other : own));
            EXPECT_EQ(after(levels, patchwork, shorter.move).boundary_edge_count -
                          before.boundary_edge_count,
                      shorter.move.boundary_change);
            turned_away += is_other;
            ++compared;
        }
    }
    EXPECT_GT(compared, 1000);
    EXPECT_GT(turned_away, 100);
}

TEST(Patchwork, EveryFaceThatComesToTheBoundaryIsListed) {
    const Levels levels(flipped_sphere(3, 100));
    Patchwork patchwork = ragged_patchwork(levels, 20, 7);
    BoundaryFaces boundary(patchwork, 1);
    int moved_faces = 0;
    for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
        Fan fan;
        if (!describe_shorter_fan(patchwork, i / 6, i % 3, (i / 3) % 2 != 0, fan) ||
            !fan_is_allowed(patchwork, fan)) {
            continue;
        }
        const Move& move = fan.move;
        apply(patchwork, move);
        for (int j = 0; j < move.face_count; ++j) {
            boundary.list_around(patchwork, move.faces[j], move.from, boundary.faces());
        }
        moved_faces += move.face_count > 2 ? move.face_count : 0;
    }
    EXPECT_GT(moved_faces, 100);
    std::vector<int> listed = boundary.faces();
    std::sort(listed.begin(), listed.end());
    EXPECT_EQ(std::adjacent_find(listed.begin(), listed.end()), listed.end());
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (patchwork.label_across(f, c) != patchwork.label(f)) {
                EXPECT_TRUE(std::binary_search(listed.begin(), listed.end(), f)) << f;
            }
        }
    }
}

AnnealSchedule schedule_of(double proposals, int thread_count) {
    AnnealSchedule schedule;
    schedule.proposals_per_face = proposals;
    schedule.phase_count = 8;
    schedule.thread_count = thread_count;
    schedule.seed = 5;
    return schedule;
}

/// Cells know the labels across their sides.
void expect_in_step(const Patchwork& patchwork) {
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            const int other = patchwork.neighbor(f, c);
            ASSERT_EQ(patchwork.label_across(f, c),
                      other < 0 ? kOpenBorder : patchwork.label(other));
        }
    }
}

TEST(Patchwork, CellsKnowTheLabelsAcrossTheirSidesWhateverChangesThem) {
    for (const TriangleMesh& mesh :
         {flipped_sphere(3, 60), grid_with_holes(12), torus(20, 10), moebius_strip(60, 5)}) {
        const Levels levels(mesh);
        Random random(5);
        Patchwork patchwork = levels.multilevel.coarsen(100, 12);
        expect_in_step(patchwork);
        for (int f = 0; f < patchwork.face_count(); ++f) {
            patchwork.set_label(f, static_cast<int>(random.below(12)));
        }
        expect_in_step(patchwork);
        repair(patchwork);
        expect_in_step(patchwork);
        levels.multilevel.uncoarsen(patchwork);
        expect_in_step(patchwork);
        adopt_labels(patchwork, 1);
        expect_in_step(patchwork);
        bisect(patchwork, 12, 1, 1);
        expect_in_step(patchwork);
        relax(patchwork, 3, 1, {});
        expect_in_step(patchwork);
        repair(patchwork);
        anneal(patchwork, schedule_of(20, 2), {});
        expect_in_step(patchwork);
        cut_exactly(patchwork, 1, patchwork.face_count(), 1000);
        expect_in_step(patchwork);
    }
}

TEST(Patchwork, CellsAreToldByAnyNumberOfThreads) {
    Patchwork patchwork = Levels(open_grid(180)).multilevel.coarsen(64800, 12);
    Random random(5);
    for (int threads : {1, 3}) {
        for (int f = 0; f < patchwork.face_count(); ++f) {
            patchwork.set_own_label(f, static_cast<int>(random.below(12)));
        }
        patchwork.tell_neighbors(threads);
        expect_in_step(patchwork);
    }
}

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

std::vector<int> random_labels(int face_count, int submesh_count) {
    Random random(3);
    std::vector<int> labels(face_count);
    for (int& label : labels) {
        label = static_cast<int>(random.below(submesh_count));
    }
    return labels;
}

TEST(Repair, MakesAnyLabelsSoundUnlessItSaysHowManyFacesItForced) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        const Levels levels(mesh);
        for (int k : {2, 5, mesh.face_count() / 4}) {
            if (k < 2 || 4 * k > mesh.face_count()) {
                continue;
            }
            Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), k);
            // All sub-meshes but one are empty.
            levels.multilevel.set_labels(patchwork, std::vector<int>(mesh.face_count(), 0));
            EXPECT_EQ(repair(patchwork), 0) << name << " k " << k;
            EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << name << " k " << k;
            Patchwork ragged = levels.multilevel.coarsen(mesh.face_count(), k);
            levels.multilevel.set_labels(ragged, random_labels(mesh.face_count(), k));
            const int forced = repair(ragged);
            const Measures measures = measures_of(levels, ragged);
            EXPECT_GE(measures.min_submesh_triangles, 1) << name << " k " << k;
            EXPECT_EQ(is_sound(measures), forced == 0) << name << " k " << k;
        }
    }
}

TEST(Repair, LeavesNoSubmeshEmptyWhereNoFaceCanBeSparedAlone) {
    // With all faces in one of k sub-meshes the others are split off, until what is left is a ring
    // that is one face wide.
    for (const TriangleMesh& mesh : {octahedron(), icosahedron(), torus(3, 3), bipyramid(7)}) {
        const Levels levels(mesh);
        for (int k = 1; k <= mesh.face_count(); ++k) {
            Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), k);
            levels.multilevel.set_labels(patchwork, std::vector<int>(mesh.face_count(), k - 1));
            const int forced = repair(patchwork);
            const Measures measures = measures_of(levels, patchwork);
            EXPECT_GE(measures.min_submesh_triangles, 1) << mesh.face_count() << " k " << k;
            EXPECT_EQ(is_sound(measures), forced == 0) << mesh.face_count() << " k " << k;
            EXPECT_EQ(patchwork.load, measures.submesh_triangles);
        }
    }
}

TEST(Repair, KeepsRingsAroundLimbsHolesAndHandles) {
    // Faces are numbered ring after ring, or row after row: each third is one sub-mesh, sound and
    // no disk.
    const std::vector<TriangleMesh> meshes = {
        torus(36, 7), torus(60, 3), grid_with_holes(24), grid_with_holes(36)};
    for (const TriangleMesh& mesh : meshes) {
        const Levels levels(mesh);
        std::vector<int> labels(mesh.face_count());
        for (int f = 0; f < mesh.face_count(); ++f) {
            labels[f] = 3 * f / mesh.face_count();
        }
        Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), 3);
        levels.multilevel.set_labels(patchwork, labels);
        ASSERT_TRUE(is_sound(measures_of(levels, patchwork)));
        ASSERT_EQ(measures_of(levels, patchwork).disk_count, 0);
        EXPECT_EQ(repair(patchwork), 0);
        EXPECT_EQ(levels.multilevel.labels(patchwork), labels);
    }
}

TEST(Repair, BisectionsOfSurfacesWithHolesAndHandlesBecomeSound) {
    const std::vector<TriangleMesh> meshes = {torus(36, 7),
                                              torus(60, 3),
                                              torus(24, 24),
                                              grid_with_holes(24),
                                              grid_with_holes(36),
                                              long_thin_limb(3, 100),
                                              long_thin_limb(5, 80)};
    for (const TriangleMesh& mesh : meshes) {
        const Levels levels(mesh);
        for (int k : {2, 3, 4, 7, 10}) {
            Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), k);
            bisect(patchwork, k, 1, 1);
            const int edges = measures_of(levels, patchwork).boundary_edge_count;
            EXPECT_EQ(repair(patchwork), 0) << mesh.face_count() << " k " << k;
            const Measures repaired = measures_of(levels, patchwork);
            EXPECT_TRUE(is_sound(repaired)) << mesh.face_count() << " k " << k;
            EXPECT_LE(repaired.boundary_edge_count, 2 * edges) << mesh.face_count() << " k " << k;
        }
    }
}

TEST(Bisection, CutInTwoAgainAndAgainGivesEachPartItsShare) {
    const Levels levels(limbed_figure(4));
    for (int k : {2, 3, 7, 12, 33}) {
        Patchwork patchwork = levels.multilevel.coarsen(60 * k, 1);
        std::vector<int> parts{k};
        for (int cuts = 0; static_cast<int>(parts.size()) < k; ++cuts) {
            ASSERT_LT(cuts, 6) << "log2 of 33, rounded up";
            const Patchwork before = patchwork;
            cut_in_two(patchwork, parts, 1);
            ASSERT_EQ(patchwork.submesh_count(), static_cast<int>(parts.size()));
            EXPECT_EQ(std::accumulate(parts.begin(), parts.end(), 0), k);
            const std::vector<int> load = patchwork.load;
            sum_loads(patchwork);
            EXPECT_EQ(load, patchwork.load);
            for (int f = 0; f < patchwork.face_count(); ++f) {
                const bool stays = patchwork.label(f) == before.label(f);
                ASSERT_TRUE(stays || patchwork.label(f) >= before.submesh_count());
            }
            const double share = mean_load(patchwork) * patchwork.submesh_count() / k;
            for (std::size_t l = 0; l < parts.size(); ++l) {
                // A cell of a coarse level weighs several faces.
                EXPECT_NEAR(load[l], parts[l] * share, 0.1 * parts[l] * share) << k;
            }
        }
    }
}

TEST(Bisection, CutInTwoOfFewerCellsThanPartsLeavesEmptySubmeshes) {
    const Levels levels(tetrahedron());
    Patchwork patchwork = levels.multilevel.coarsen(4, 1);
    std::vector<int> parts{3};
    cut_in_two(patchwork, parts, 0);
    patchwork.set_label(0, 0);
    patchwork.set_label(1, 0);
    patchwork.set_label(2, 0);
    patchwork.set_label(3, 1);
    sum_loads(patchwork);
    parts = {1, 3};
    cut_in_two(patchwork, parts, 0);
    EXPECT_EQ(parts, (std::vector<int>{1, 1, 2}));
    EXPECT_EQ(patchwork.load, (std::vector<int>{3, 1, 0}));
    cut_in_two(patchwork, parts, 0);
    EXPECT_EQ(patchwork.load, (std::vector<int>{3, 1, 0, 0}));
}

TEST(Balance, EverySubmeshHoldsFloorOrCeilingFacesOrItSaysSo) {
    const Levels levels(displaced_sphere(3));
    for (int k : {2, 7, 31, 200}) {
        // Many small sub-meshes may get stuck without annealing; they stay sound all the same.
        Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), k);
        bisect(patchwork, k, 1, 1);
        repair(patchwork);
        const bool balanced = balance_exactly(patchwork);
        EXPECT_TRUE(balanced || k == 200) << k;
        EXPECT_TRUE(is_sound(measures_of(levels, patchwork))) << k;
        EXPECT_EQ(measures_of(levels, patchwork).is_valid(), balanced) << k;
    }
}

TEST(Patchwork, ExactBalanceOfTwoOrThreeFacesEachNeedsNoAnnealing) {
    const Levels levels(displaced_sphere(4));
    const int face_count = levels.mesh.face_count();
    // A chain of passes breaks at nearly every sub-mesh here, unless each is planned.
    for (int k : {face_count / 2, 2 * face_count / 5, 5 * face_count / 16, face_count / 4}) {
        for (std::uint64_t seed : {1, 2, 3}) {
            Patchwork patchwork = ragged_patchwork(levels, k, seed);
            EXPECT_TRUE(balance_exactly(patchwork, 1000 * face_count)) << k << ", seed " << seed;
            EXPECT_TRUE(measures_of(levels, patchwork).is_valid()) << k << ", seed " << seed;
        }
    }
}

TEST(Anneal, LowersTheBoundaryKeepsSoundnessAndDoesNotDependOnThreads) {
    const Levels levels(limbed_figure(4));
    constexpr int kSubmeshes = 120;
    std::vector<int> reference;
    for (int threads : {1, 2, 3, 1}) {
        Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), kSubmeshes);
        bisect(patchwork, kSubmeshes, 0, threads);
        repair(patchwork);
        const int before = measures_of(levels, patchwork).boundary_edge_count;
        std::vector<double> edges;
        std::vector<double> seconds;
        AnnealControl control;
        control.boundary_edges = &edges;
        control.seconds = &seconds;
        anneal(patchwork, schedule_of(60, threads), control);
        const Measures annealed = measures_of(levels, patchwork);
        EXPECT_TRUE(is_sound(annealed));
        EXPECT_LT(annealed.boundary_edge_count, before);
        ASSERT_EQ(edges.size(), 8u);
        EXPECT_EQ(edges.back(), annealed.boundary_edge_count);

        ASSERT_TRUE(balance_exactly(patchwork));
        const int balanced = measures_of(levels, patchwork).boundary_edge_count;
        AnnealSchedule exchanges = schedule_of(200, threads);
        exchanges.temperature_begin = 0.25;
        exchanges.temperature_end = 0.08;
        anneal_balanced(patchwork, exchanges, control);
        const Measures exchanged = measures_of(levels, patchwork);
        EXPECT_TRUE(exchanged.is_valid());
        EXPECT_LT(exchanged.boundary_edge_count, balanced);
        EXPECT_EQ(edges.back(), exchanged.boundary_edge_count);
        for (int l = 0; l < kSubmeshes; ++l) {
            EXPECT_EQ(patchwork.load[l], exchanged.submesh_triangles[l]);
        }

        const std::vector<int> labels = levels.multilevel.labels(patchwork);
        if (reference.empty()) {
            reference = labels;
        }
        EXPECT_EQ(labels, reference) << threads << " threads";
    }
}

TEST(FreeAnnealing, FindsTheWayThroughAHole) {
    // A strip of 24 x 8 squares with a hole of 4 x 4 in its middle, which leaves bridges of two: 4
    // edges part the halves there. The start is a straight cut of 8 edges beside the hole; moves
    // that keep both sides connected can only push it along one side of the hole.
    TriangleMesh mesh = open_grid(24);
    std::vector<Triangle> kept;
    std::vector<int> labels;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const int x = f / 2 % 24;
        const int y = f / 2 / 24;
        if (y < 8 && (x < 10 || x >= 14 || y < 2 || y >= 6)) {
            kept.push_back(mesh.faces[f]);
            labels.push_back(x >= 8);
        }
    }
    mesh.faces = kept;
    const Levels levels(mesh);
    Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), 2);
    levels.multilevel.set_labels(patchwork, labels);
    Patchwork bound = patchwork;
    AnnealSchedule schedule = schedule_of(2000, 1);
    schedule.balance_weight_begin = 0.5 / mean_load(patchwork);
    schedule.balance_weight_end = 1.5 / mean_load(patchwork);
    anneal_freely(patchwork, schedule, Deadline());
    anneal(bound, schedule, {});
    EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
    EXPECT_EQ(repair(patchwork), 0);
    EXPECT_LE(measures_of(levels, patchwork).boundary_edge_count, 5);
    EXPECT_GE(measures_of(levels, bound).boundary_edge_count, 7);
}

TEST(FreeAnnealing, LeavesNoSubmeshEmptyAndRepeats) {
    const Levels levels(torus(20, 10));
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 60);
    bisect(patchwork, 60, 1, 1);
    Patchwork again = patchwork;
    AnnealSchedule schedule = schedule_of(300, 1);
    schedule.temperature_begin = 3.0;
    anneal_freely(patchwork, schedule, Deadline());
    EXPECT_GE(*std::min_element(patchwork.load.begin(), patchwork.load.end()), 1);
    EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
    anneal_freely(again, schedule, Deadline());
    EXPECT_EQ(levels.multilevel.labels(again), levels.multilevel.labels(patchwork));
}

TEST(Anneal, ClosesRingsAroundALimbOnlyWhereItMay) {
    const Levels levels(long_thin_limb(4, 100));
    constexpr int kSubmeshes = 20;
    for (bool may_close_rings : {true, false}) {
        Patchwork patchwork = ragged_patchwork(levels, kSubmeshes, 1);
        ASSERT_EQ(measures_of(levels, patchwork).disk_count, kSubmeshes);
        patchwork.may_close_rings = may_close_rings;
        AnnealSchedule schedule;
        schedule.proposals_per_face = 200.0;
        anneal(patchwork, schedule, {});
        const Measures annealed = measures_of(levels, patchwork);
        EXPECT_TRUE(is_sound(annealed));
        if (may_close_rings) {
            EXPECT_LT(annealed.disk_count, kSubmeshes);
        } else {
            EXPECT_EQ(annealed.disk_count, kSubmeshes);
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
