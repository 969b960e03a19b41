// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "boundary.h"

#include <algorithm>

namespace spheroseg {

/// A side of a sub-mesh: the edge of `face` at `corner`.
struct SubmeshSide {
    int face;
    int corner;
};

/// The side across which a face would pass out of the sub-mesh of `face` beyond its edge at
/// `corner`, or, not `outward`, into it.
inline SubmeshSide passing_side(const Patchwork& patchwork, int face, int corner, bool outward) {
    if (outward) {
        return {face, corner};
    }
    const NeighborSide across = patchwork.cells[face].side[corner];
    return {face_of(across), corner_of(across)};
}

/// Describes the pass of a face across a side; false where it is not allowed.
inline bool is_allowed_pass(const Patchwork& patchwork, const SubmeshSide& side, Move& move) {
    return describe_single(patchwork, side.face, side.corner, move) &&
        single_is_allowed(patchwork, side.face, side.corner, move);
}

/// For each sub-mesh the faces that may touch another one, kept while single faces move.
class SubmeshBoundaries {
public:
    /// Finds them in O(F).
    explicit SubmeshBoundaries(Patchwork& patchwork)
        : patchwork_(patchwork), faces_of_(patchwork.submesh_count()) {
        const BoundaryFaces boundary(patchwork, 1);
        for (int f : boundary.faces()) {
            faces_of_[patchwork.cells[f].label].push_back(f);
        }
    }

    /// Listed faces of a sub-mesh: all that touch another one, and some that did.
    int listed_count(int label) const { return static_cast<int>(faces_of_[label].size()); }

    /// Calls `visit(face, corner, across)` for each side of the sub-mesh: the edge of its `face` at
    /// `corner`, beyond which sub-mesh `across` lies. Forgets faces that touch no other sub-mesh.
    template <typename Visit> void for_each_side(int label, Visit visit) {
        std::vector<int>& faces = faces_of_[label];
        for (std::size_t i = 0; i < faces.size();) {
            const int face = faces[i];
            bool touches = false;
            for (int c = 0; c < 3 && patchwork_.label(face) == label; ++c) {
                const int across = patchwork_.label_across(face, c);
                if (across >= 0 && across != label) {
                    touches = true;
                    visit(face, c, across);
                }
            }
            if (touches) {
                ++i;
            } else {
                take_out(faces, i);
            }
        }
    }

    /// Makes the move of a single face.
    void commit(const Move& move) {
        apply(patchwork_, move);
        const int face = move.faces[0];
        list(face, move.to);
        for (int neighbor : patchwork_.neighbors(face)) {
            if (neighbor >= 0 && patchwork_.label(neighbor) == move.from) {
                list(neighbor, move.from);
            }
        }
    }

    /// Makes that of `face` from sub-mesh `from` to `to`.
    void pass(int face, int from, int to) {
        Move move;
        move.faces[0] = face;
        move.face_count = 1;
        move.from = from;
        move.to = to;
        move.weight = patchwork_.weight(face);
        commit(move);
    }

private:
    void list(int face, int label) {
        std::vector<int>& faces = faces_of_[label];
        if (std::find(faces.begin(), faces.end(), face) == faces.end()) {
            faces.push_back(face);
        }
    }

    Patchwork& patchwork_;
    std::vector<std::vector<int>> faces_of_;
};

} // namespace spheroseg
