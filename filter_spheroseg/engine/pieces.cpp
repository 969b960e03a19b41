// SPDX-License-Identifier: GPL-3.0-or-later
#include "pieces.h"

#include "face_walk.h"

namespace spheroseg {

Pieces find_pieces(const Patchwork& patchwork) {
    Pieces found{{}, std::vector<int>(patchwork.cells.size(), -1)};
    std::vector<int> faces;
    for (int start = 0; start < patchwork.face_count(); ++start) {
        const int label = patchwork.label(start);
        if (label < 0 || found.of_face[start] >= 0) {
            continue;
        }
        const auto number = static_cast<int>(found.pieces.size());
        found.of_face[start] = number;
        faces.assign(1, start);
        walk_faces(patchwork, faces, [&](int, int neighbor) {
            if (found.of_face[neighbor] >= 0 || patchwork.label(neighbor) != label) {
                return false;
            }
            found.of_face[neighbor] = number;
            return true;
        });
        found.pieces.push_back({label, static_cast<int>(faces.size())});
    }
    return found;
}

} // namespace spheroseg
