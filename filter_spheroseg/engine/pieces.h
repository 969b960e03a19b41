// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <vector>

namespace spheroseg {

/// Faces of one label that hang together by edges, and no other face of that label does by them.
struct Piece {
    int label;
    int face_count;
};

/// In the order of their first faces.
struct Pieces {
    std::vector<Piece> pieces;
    /// Of each face, in `pieces`; -1 for a face that is in no sub-mesh.
    std::vector<int> of_face;
};

/// O(F).
Pieces find_pieces(const Patchwork& patchwork);

} // namespace spheroseg
