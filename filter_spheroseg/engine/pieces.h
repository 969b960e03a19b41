// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <vector>

namespace spheroseg {

/// A maximal edge-connected set of faces with one label.
struct Piece {
    int label;
    int face_count;
};

/// All of them, in the order of their first faces.
struct Pieces {
    std::vector<Piece> pieces;
    /// Per face the index of its piece in `pieces`; -1 for a face that is in no sub-mesh.
    std::vector<int> of_face;
};

/// O(F).
Pieces find_pieces(const Patchwork& patchwork);

} // namespace spheroseg
