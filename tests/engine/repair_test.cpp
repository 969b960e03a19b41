// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair.h"

#include "boundary.h"
#include "patchwork_meshes.h"
#include "relaxation.h"
#include "soundness.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace spheroseg {
namespace {

using namespace test;

std::vector<int> random_labels(int face_count, int submesh_count, std::uint64_t seed) {
    Random random(seed);
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
            levels.multilevel.set_labels(ragged, random_labels(mesh.face_count(), k, 3));
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

TEST(Repair, AnEmptySubmeshGetsOneFaceThatAnotherCanSpare) {
    const Levels levels(open_grid(20));
    const std::vector<int> halves = labels_by_number(levels.mesh.face_count(), 2);
    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 3);
    levels.multilevel.set_labels(patchwork, halves);
    EXPECT_EQ(repair(patchwork), 0);
    EXPECT_TRUE(is_sound(patchwork));
    std::vector<int> labels = levels.multilevel.labels(patchwork);
    const auto given = std::find(labels.begin(), labels.end(), 2);
    ASSERT_NE(given, labels.end());
    *given = halves[given - labels.begin()];
    EXPECT_EQ(labels, halves);
}

TEST(Repair, FillsEmptySubmeshesFromTheLargestWhereTheHeaviestIsOneFace) {
    // A strip of twelve faces that is closed to a ring, and a heavy face on its rim.
    constexpr int kAround = 6;
    TriangleMesh mesh;
    for (int i = 0; i < kAround; ++i) {
        const int next = (i + 1) % kAround;
        mesh.faces.push_back({i, next, kAround + next});
        mesh.faces.push_back({i, kAround + next, kAround + i});
    }
    mesh.faces.push_back({1, 0, 2 * kAround});
    mesh.positions.resize(2 * kAround + 1);
    const Levels levels(mesh);
    std::vector<int> weights(mesh.face_count(), 1);
    weights.back() = 1000;
    const Multilevel weighted = levels.multilevel.with_weights(weights);
    Patchwork patchwork = weighted.coarsen(mesh.face_count(), 3);
    std::vector<int> labels(mesh.face_count(), 0);
    labels.back() = 1;
    weighted.set_labels(patchwork, labels);
    const int forced = repair(patchwork);
    const Measures measures = measures_of(levels, patchwork);
    EXPECT_GE(measures.min_submesh_triangles, 1);
    EXPECT_EQ(is_sound(measures), forced == 0);
    EXPECT_EQ(patchwork.may_be_unsound, forced > 0);
    EXPECT_EQ(patchwork.load[1], 1000);
}

TEST(Repair, KeepsRingsAroundLimbsHolesAndHandles) {
    // Faces are numbered ring after ring, or row after row: each third is one sub-mesh, sound and
    // no disk.
    const std::vector<TriangleMesh> meshes = {
        torus(36, 7), torus(60, 3), grid_with_holes(24), grid_with_holes(36)};
    for (const TriangleMesh& mesh : meshes) {
        const Levels levels(mesh);
        const std::vector<int> labels = labels_by_number(mesh.face_count(), 3);
        Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), 3);
        levels.multilevel.set_labels(patchwork, labels);
        ASSERT_TRUE(is_sound(measures_of(levels, patchwork)));
        ASSERT_EQ(measures_of(levels, patchwork).disk_count, 0);
        EXPECT_EQ(repair(patchwork), 0);
        EXPECT_EQ(levels.multilevel.labels(patchwork), labels);
    }
}

TEST(Repair, ChangesOnlyWhatIsNotSound) {
    const TriangleMesh mesh = open_grid(20);
    const Levels levels(mesh);
    const std::vector<int> halves = labels_by_number(mesh.face_count(), 2);
    std::vector<int> labels = halves;
    // Single faces in the midst of each half, and one that touches its own half at a vertex.
    const std::vector<int> strays = {205, 371, 402, 640};
    Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), 2);
    for (int f : strays) {
        labels[f] = 1 - labels[f];
    }
    levels.multilevel.set_labels(patchwork, labels);
    ASSERT_FALSE(is_sound(measures_of(levels, patchwork)));
    EXPECT_EQ(repair(patchwork), 0);
    EXPECT_TRUE(is_sound(measures_of(levels, patchwork)));
    const std::vector<int> repaired = levels.multilevel.labels(patchwork);
    for (int f = 0; f < mesh.face_count(); ++f) {
        if (std::find(strays.begin(), strays.end(), f) == strays.end()) {
            EXPECT_EQ(repaired[f], halves[f]) << f;
        }
    }
}

TEST(Repair, OfWhatIsNotSoundTakesNoFaceFromTheRest) {
    constexpr int kSubmeshes = 12;
    for (const TriangleMesh& mesh : {displaced_sphere(4), open_grid(30), torus(30, 20)}) {
        const Levels levels(mesh);
        for (std::uint64_t seed = 0; seed < 10; ++seed) {
            Patchwork patchwork = rough_patchwork(levels, kSubmeshes, seed);
            const std::vector<int> sound = levels.multilevel.labels(patchwork);
            patchwork.may_be_unsound = true;
            EXPECT_EQ(repair_unsound(patchwork), 0);
            EXPECT_FALSE(patchwork.may_be_unsound);
            EXPECT_EQ(levels.multilevel.labels(patchwork), sound) << "all were sound";
            std::vector<std::set<int>> labels_at(mesh.positions.size());
            for (int f = 0; f < mesh.face_count(); ++f) {
                for (int v : mesh.faces[f]) {
                    labels_at[v].insert(sound[f]);
                }
            }
            const auto is_inside = [&](const Triangle& face) {
                return std::all_of(
                    face.begin(), face.end(), [&](int v) { return labels_at[v].size() == 1; });
            };
            Random random(seed);
            int stray = 0;
            do {
                stray = static_cast<int>(random.below(mesh.face_count()));
            } while (!is_inside(mesh.faces[stray]));
            std::vector<int> labels = sound;
            labels[stray] = (labels[stray] + 1) % kSubmeshes;
            levels.multilevel.set_labels(patchwork, labels);
            ASSERT_FALSE(is_sound(patchwork));
            EXPECT_EQ(repair_unsound(patchwork), 0);
            EXPECT_TRUE(is_sound(patchwork));
            EXPECT_FALSE(patchwork.may_be_unsound);
            EXPECT_EQ(patchwork.load, measures_of(levels, patchwork).submesh_triangles);
            EXPECT_EQ(levels.multilevel.labels(patchwork), sound) << "the stray face went back";
        }
    }
}

TEST(Repair, AllowsRingsOnlyWhereDisksLeaveFacesOver) {
    using RepairFunction = int (*)(Patchwork&);
    const Levels levels(open_grid(20));
    const std::vector<int> halves = labels_by_number(levels.mesh.face_count(), 2);
    for (RepairFunction mend : {RepairFunction{repair}, RepairFunction{repair_unsound}}) {
        for (int stray : {-1, 205}) {
            std::vector<int> labels = halves;
            if (stray >= 0) {
                labels[stray] = 1;
            }
            Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 2);
            levels.multilevel.set_labels(patchwork, labels);
            patchwork.may_close_rings = false;
            EXPECT_EQ(mend(patchwork), 0);
            EXPECT_EQ(levels.multilevel.labels(patchwork), halves);
            EXPECT_FALSE(patchwork.may_close_rings);
        }
    }
    const Levels ring(torus(12, 6));
    Patchwork patchwork = ring.multilevel.coarsen(ring.mesh.face_count(), 1);
    ring.multilevel.set_labels(patchwork, std::vector<int>(ring.mesh.face_count(), 0));
    patchwork.may_close_rings = false;
    EXPECT_EQ(repair(patchwork), 0);
    EXPECT_TRUE(patchwork.may_close_rings) << "no disk covers a torus";
}

TEST(Repair, KeepsBoundariesShortWhereAllIsHandles) {
    const Levels levels(lattice(5));
    for (int k : {2, 5, 20}) {
        // On the coarsest level each face lies at a handle.
        for (int face_count : {1, levels.mesh.face_count()}) {
            Patchwork patchwork = levels.multilevel.coarsen(face_count, k);
            bisect(patchwork, k, 1, 1);
            relax(patchwork, 30, 1, {});
            const std::int64_t edges = count_boundary_edges(patchwork, 1);
            repair(patchwork);
            EXPECT_LE(count_boundary_edges(patchwork, 1), 1.3 * edges)
                << k << " " << patchwork.face_count();
        }
    }
}

TEST(Repair, NearlyAllLabelsOfGridsFullOfHolesBecomeSound) {
    // Without growing anew around faces that fit nowhere, 20 stay unsound.
    int runs = 0;
    int unsound = 0;
    for (int hole_seed = 1; hole_seed <= 30; ++hole_seed) {
        const Levels levels(sieve(open_grid(20), 0.25, hole_seed));
        for (int k : {2, 3, 5, 8, 13, 21, 34, 60}) {
            for (int seed = 0; seed < 6; ++seed) {
                for (bool at_random : {false, true}) {
                    Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), k);
                    if (at_random) {
                        levels.multilevel.set_labels(
                            patchwork, random_labels(levels.mesh.face_count(), k, seed));
                    } else {
                        bisect(patchwork, k, seed, 1);
                    }
                    const bool is_forced = repair(patchwork) > 0;
                    EXPECT_EQ(patchwork.may_be_unsound, is_forced);
                    const Measures measures = measures_of(levels, patchwork);
                    EXPECT_TRUE(is_forced || is_sound(measures));
                    EXPECT_EQ(patchwork.load, measures.submesh_triangles);
                    unsound += is_forced;
                    ++runs;
                }
            }
        }
    }
    EXPECT_EQ(runs, 2880);
    EXPECT_LE(unsound, 5);
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

} // namespace
} // namespace spheroseg
