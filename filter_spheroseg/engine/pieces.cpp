// SPDX-License-Identifier: GPL-3.0-or-later
#include "pieces.h"

namespace spheroseg {

Pieces find_pieces(const Patchwork& patchwork) {
    Pieces found{{}, std::vector<int>(patchwork.cells.size(), -1)};
    std::vector<int> open;
    for (int start = 0; start < patchwork.face_count(); ++start) {
        const int label = patchwork.label(start);
        if (label < 0 || found.of_face[start] >= 0) {
            continue;
        }
        const auto number = static_cast<int>(found.pieces.size());
        found.pieces.push_back({label, 1});
        found.of_face[start] = number;
        open.assign(1, start);
        while (!open.empty()) {
            const int face = open.back();
            open.pop_back();
            for (int neighbor : patchwork.neighbors(face)) {
                if (neighbor >= 0 && found.of_face[neighbor] < 0 &&
                    patchwork.label(neighbor) == label) {
                    found.of_face[neighbor] = number;
                    ++found.pieces.back().face_count;
                    open.push_back(neighbor);
                }
            }
        }
    }
    return found;
}

} // namespace spheroseg
