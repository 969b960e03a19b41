// SPDX-License-Identifier: GPL-3.0-or-later
#include "linked_patchwork.h"

#include "errors.h"
#include "threads.h"

#include <string>

namespace spheroseg {

namespace {

constexpr std::size_t kMaxFaces = std::size_t{1} << 28;

void check_count(std::size_t face_count) {
    if (face_count > kMaxFaces) {
        throw InvalidInput("The mesh has " + std::to_string(face_count) +
                           " triangles, but method \"fast\" takes at most " +
                           std::to_string(kMaxFaces) + ". Simplify it, or part it first.");
    }
}

LinkedCell link(const Patchwork& patchwork, const Cell& cell) {
    LinkedCell linked{
        {-1, -1, -1}, {kOpenBorder, kOpenBorder, kOpenBorder}, cell.label, cell.weight};
    for (int c = 0; c < 3; ++c) {
        const int neighbor = cell.neighbor[c];
        if (neighbor >= 0) {
            const Cell& other = patchwork.cells[neighbor];
            const int begin = corner_of(other, cell.vertex[c]);
            const int end = corner_of(other, cell.vertex[next_corner(c)]);
            const bool turned = next_corner(end) != begin;
            linked.side[c] = neighbor << 3 | (turned ? begin : end) << 1 | static_cast<int>(turned);
            linked.across[c] = other.label;
        }
    }
    return linked;
}

} // namespace

LinkedPatchwork::LinkedPatchwork(const Patchwork& patchwork,
                                 int thread_count,
                                 std::vector<LinkedCell> cells)
    : may_close_rings(patchwork.may_close_rings), cells_(std::move(cells)),
      submesh_count_(patchwork.submesh_count()) {
    check_count(patchwork.cells.size());
    cells_.resize(patchwork.cells.size());
    const int threads = threads_for(thread_count, face_count(), kFacesPerThread);
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int f = 0; f < face_count(); ++f) {
        cells_[f] = link(patchwork, patchwork.cells[f]);
    }
}

void LinkedPatchwork::give_labels(Patchwork& patchwork) const {
    for (int f = 0; f < face_count(); ++f) {
        patchwork.cells[f].label = cells_[f].label;
    }
}

} // namespace spheroseg
