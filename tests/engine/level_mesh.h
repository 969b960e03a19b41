// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"
#include "types.h"

namespace spheroseg::test {

/// The triangles that a patchwork is made of: corners that a walk from side to side joins are one
/// vertex.
inline TriangleMesh mesh_of(const Patchwork& patchwork) {
    TriangleMesh mesh;
    mesh.faces.assign(patchwork.cells.size(), {-1, -1, -1});
    int vertex_count = 0;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (mesh.faces[f][c] >= 0) {
                continue;
            }
            mesh.faces[f][c] = vertex_count;
            for (int exit : {c, previous_corner(c)}) {
                Step step{f, c, exit};
                while (patchwork.neighbor(step.face, step.exit) >= 0) {
                    step = patchwork.step_from(step);
                    if (mesh.faces[step.face][step.at] >= 0) {
                        break;
                    }
                    mesh.faces[step.face][step.at] = vertex_count;
                }
            }
            ++vertex_count;
        }
    }
    mesh.positions.resize(static_cast<std::size_t>(vertex_count));
    return mesh;
}

} // namespace spheroseg::test
