// SPDX-License-Identifier: GPL-3.0-or-later
#include "faults.h"

#include "patchwork_meshes.h"
#include "pieces.h"
#include "random.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

/// The numbers of faces of the pieces of each label, by union of neighbours until nothing changes.
std::vector<std::vector<int>> piece_sizes(const Patchwork& patchwork) {
    std::vector<int> first(patchwork.face_count());
    for (int f = 0; f < patchwork.face_count(); ++f) {
        first[f] = f;
    }
    for (bool changed = true; changed;) {
        changed = false;
        for (int f = 0; f < patchwork.face_count(); ++f) {
            for (int neighbor : patchwork.neighbors(f)) {
                if (neighbor >= 0 && patchwork.label(neighbor) == patchwork.label(f) &&
                    first[neighbor] < first[f]) {
                    first[f] = first[neighbor];
                    changed = true;
                }
            }
        }
    }
    std::vector<std::vector<int>> sizes(patchwork.submesh_count());
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (first[f] == f && patchwork.label(f) >= 0) {
            const auto size = std::count(first.begin(), first.end(), f);
            sizes[patchwork.label(f)].push_back(static_cast<int>(size));
        }
    }
    return sizes;
}

Patchwork random_patchwork(const Levels& levels, int submesh_count, std::uint64_t seed) {
    const int face_count = levels.multilevel.face_count();
    Patchwork patchwork = levels.multilevel.coarsen(face_count, submesh_count);
    Random random(seed);
    std::vector<int> labels(face_count);
    for (int& label : labels) {
        label = static_cast<int>(random.below(submesh_count + 1)) - 1;
    }
    levels.multilevel.set_labels(patchwork, labels);
    return patchwork;
}

TEST(Pieces, AreThoseThatNeighborsMakeOneByOne) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        const Levels levels(mesh);
        const Patchwork patchwork = random_patchwork(levels, 3, 1);
        const Pieces found = find_pieces(patchwork);
        std::vector<std::vector<int>> sizes(3);
        for (const Piece& piece : found.pieces) {
            sizes[piece.label].push_back(piece.face_count);
        }
        EXPECT_EQ(sizes, piece_sizes(patchwork)) << name;
        for (int f = 0; f < patchwork.face_count(); ++f) {
            const int piece = found.of_face[f];
            ASSERT_EQ(piece < 0 ? -1 : found.pieces[piece].label, patchwork.label(f)) << name;
        }
    }
}

/// Most faces in one sub-mesh: a large piece full of bowties, which comes apart without them.
Patchwork porous_patchwork(const Levels& levels, std::uint64_t seed) {
    Patchwork patchwork = random_patchwork(levels, 2, seed);
    Random random(seed);
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (random.uniform() < 0.75) {
            patchwork.set_label(f, 0);
        }
    }
    sum_loads(patchwork);
    return patchwork;
}

TEST(Faults, AreFreedButForSubmeshesThatAreSound) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        const Levels levels(mesh);
        for (int seed = 0; seed < 4; ++seed) {
            Patchwork patchwork =
                seed % 2 ? porous_patchwork(levels, seed) : random_patchwork(levels, 2, seed);
            // A sub-mesh of one face is sound.
            patchwork.load.push_back(0);
            patchwork.set_label(0, 2);
            free_faults(patchwork, {0, 0, 1});
            std::vector<int> load(3, 0);
            for (int f = 0; f < patchwork.face_count(); ++f) {
                const int label = patchwork.label(f);
                if (label < 0) {
                    continue;
                }
                load[label] += patchwork.weight(f);
                for (int c = 0; c < 3; ++c) {
                    int ends = 0;
                    for_each_around(patchwork, f, c, [&](int face, int corner) {
                        ends +=
                            patchwork.label(face) == label ? fan_ends(patchwork, face, corner) : 0;
                    });
                    ASSERT_LE(ends, 2) << name << " face " << f;
                }
            }
            EXPECT_EQ(patchwork.load, load) << name;
            for (const std::vector<int>& sizes : piece_sizes(patchwork)) {
                EXPECT_LE(sizes.size(), 1U) << name;
            }
            EXPECT_EQ(patchwork.label(0), 2) << name;
        }
    }
}

TEST(Faults, TheLargestPieceOrFanStays) {
    // Around the upper apex sub-mesh 1 has one, four and two faces, apart: pieces, or fans if the
    // lower faces, which hang together, are of it too.
    constexpr int kValence = 12;
    const Levels levels(bipyramid(kValence));
    for (int lower : {0, 1}) {
        for (int turn = 0; turn < kValence; ++turn) {
            const auto upper = [&](int i) { return 2 * ((i + turn) % kValence); };
            std::vector<int> expected(levels.mesh.face_count(), lower);
            for (int i = 0; i < kValence; ++i) {
                expected[upper(i)] = i >= 2 && i < 6 ? 1 : -1;
            }
            std::vector<int> labels = expected;
            for (int i : {0, 7, 8}) {
                labels[upper(i)] = 1;
            }
            Patchwork patchwork = levels.multilevel.coarsen(levels.mesh.face_count(), 2);
            levels.multilevel.set_labels(patchwork, labels);
            free_faults(patchwork, {1, 0});
            EXPECT_EQ(levels.multilevel.labels(patchwork), expected) << lower << " turn " << turn;
        }
    }
}

} // namespace
} // namespace spheroseg
