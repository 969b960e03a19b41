// SPDX-License-Identifier: GPL-3.0-or-later
#include "disks.h"

#include "patchwork_meshes.h"
#include "relaxation.h"
#include "soundness.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace spheroseg {
namespace {

using namespace test;

/// Steps between neighbours inside a sub-mesh from a face at its rim; -1: it has no rim.
std::vector<int> depths(const Patchwork& patchwork) {
    std::vector<int> depth(patchwork.face_count(), -1);
    std::vector<int> queue;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (is_at_rim(patchwork, f)) {
            depth[f] = 0;
            queue.push_back(f);
        }
    }
    for (std::size_t head = 0; head < queue.size(); ++head) {
        for (int neighbor : patchwork.neighbors(queue[head])) {
            if (neighbor >= 0 && depth[neighbor] < 0 &&
                patchwork.label(neighbor) == patchwork.label(queue[head])) {
                depth[neighbor] = depth[queue[head]] + 1;
                queue.push_back(neighbor);
            }
        }
    }
    return depth;
}

TEST(Disks, SubmeshesShrinkToDisksAroundTheirDeepestFacesUnlessTheyAreSound) {
    int sound_count = 0;
    for (const TriangleMesh& mesh : {icosphere(3),
                                     torus(24, 12),
                                     open_grid(12),
                                     grid_with_holes(12),
                                     moebius_strip(60, 5),
                                     lattice(3)}) {
        const Levels levels(mesh);
        const int face_count = mesh.face_count();
        for (int k : {2, 5, 12, 60}) {
            for (int seed = 0; seed < 4; ++seed) {
                Patchwork patchwork = levels.multilevel.coarsen(face_count, k);
                bisect(patchwork, k, seed, 1);
                // Ever more faces of other sub-meshes in between.
                Random random(seed);
                for (int i = 0; i < seed * face_count / 8; ++i) {
                    patchwork.set_label(static_cast<int>(random.below(face_count)),
                                        static_cast<int>(random.below(k)));
                }
                std::vector<std::uint8_t> sound(k, 0);
                if (seed % 2 == 0) {
                    sound = sound_submeshes(patchwork);
                    sound_count += static_cast<int>(std::count(sound.begin(), sound.end(), 1));
                }
                const std::vector<int> before = cell_labels(patchwork);
                const std::vector<int> depth = depths(patchwork);
                shrink_to_disks(patchwork, sound);
                const std::vector<int> after = cell_labels(patchwork);
                std::vector<int> deepest(k, -1);
                std::vector<int> deepest_kept(k, -1);
                std::vector<int> load(k, 0);
                for (int f = 0; f < face_count; ++f) {
                    const int label = before[f];
                    deepest[label] = std::max(deepest[label], depth[f]);
                    if (after[f] == label) {
                        deepest_kept[label] = std::max(deepest_kept[label], depth[f]);
                        ++load[label];
                    } else {
                        EXPECT_EQ(after[f], -1);
                        EXPECT_FALSE(sound[label]);
                    }
                }
                EXPECT_EQ(deepest_kept, deepest);
                EXPECT_EQ(patchwork.load, load);
                // With each face that is left over on its own.
                int submesh_count = k;
                std::vector<int> labels = levels.multilevel.labels(patchwork);
                for (int& label : labels) {
                    label = label < 0 ? submesh_count++ : label;
                }
                const Measures measures = measure(mesh, levels.graph, labels, submesh_count, 1);
                EXPECT_EQ(measures.disconnected_submesh_count, 0);
                EXPECT_EQ(measures.bowtie_count, 0);
                if (seed % 2 == 1) {
                    EXPECT_EQ(measures.disk_count,
                              submesh_count - std::count(load.begin(), load.end(), 0));
                }
            }
        }
    }
    EXPECT_GT(sound_count, 100);
}

TEST(Disks, RoundDisksKeepAllTheirFaces) {
    for (const TriangleMesh& mesh : {icosphere(3), open_grid(24), torus(40, 20)}) {
        const Levels levels(mesh);
        Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), 12);
        bisect(patchwork, 12, 1, 1);
        relax(patchwork, 30, 1, {});
        patchwork.may_close_rings = false;
        repair(patchwork);
        ASSERT_EQ(measures_of(levels, patchwork).disk_count, 12);
        shrink_to_disks(patchwork, std::vector<std::uint8_t>(12, 0));
        const std::vector<int> labels = cell_labels(patchwork);
        EXPECT_EQ(std::count(labels.begin(), labels.end(), -1), 0);
    }
}

} // namespace
} // namespace spheroseg
