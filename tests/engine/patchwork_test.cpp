// SPDX-License-Identifier: GPL-3.0-or-later
#include "patchwork.h"

#include "exact_cut.h"
#include "patchwork_meshes.h"
#include "relaxation.h"
#include "warm_start.h"

#include <gtest/gtest.h>

namespace spheroseg {
namespace {

using namespace test;

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

} // namespace
} // namespace spheroseg
