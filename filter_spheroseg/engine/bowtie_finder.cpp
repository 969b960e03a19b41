// SPDX-License-Identifier: GPL-3.0-or-later
#include "bowtie_finder.h"

namespace spheroseg {

BowtieFinder::BowtieFinder(const Patchwork& patchwork) : vertex_(3 * patchwork.cells.size(), -1) {
    int vertex_count = 0;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (vertex_[3 * f + c] < 0) {
                vertex_[3 * f + c] = vertex_count;
                for_each_around(patchwork, f, c, [&](int face, int corner) {
                    vertex_[3 * face + corner] = vertex_count;
                });
                ++vertex_count;
            }
        }
    }
    ends_.assign(vertex_count, 0);
}

} // namespace spheroseg
