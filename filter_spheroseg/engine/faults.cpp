// SPDX-License-Identifier: GPL-3.0-or-later
#include "faults.h"

#include "pieces.h"

#include <algorithm>
#include <tuple>

namespace spheroseg {

namespace {

void free_small_pieces(Patchwork& patchwork) {
    const Pieces found = find_pieces(patchwork);
    std::vector<int> largest(patchwork.submesh_count(), -1);
    for (std::size_t p = 0; p < found.pieces.size(); ++p) {
        int& best = largest[found.pieces[p].label];
        if (best < 0 || found.pieces[p].face_count > found.pieces[best].face_count) {
            best = static_cast<int>(p);
        }
    }
    for (int f = 0; f < patchwork.face_count(); ++f) {
        const int piece = found.of_face[f];
        if (piece >= 0 && piece != largest[found.pieces[piece].label]) {
            patchwork.set_label(f, -1);
        }
    }
}

class SmallFans {
public:
    SmallFans(Patchwork& patchwork, const std::vector<std::uint8_t>& sound)
        : patchwork_(patchwork), sound_(sound) {}

    /// False if there are none. Looks around each vertex once, and again where a face leaves.
    bool free() {
        seen_corners_.assign(patchwork_.cells.size(), 0);
        queue_.clear();
        bool any = false;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                if ((seen_corners_[f] >> c & 1) == 0 && is_at_rim(patchwork_, f)) {
                    any = free_around(f, c) || any;
                }
            }
        }
        while (!queue_.empty()) {
            const int face = queue_.back();
            queue_.pop_back();
            for (int c = 0; c < 3; ++c) {
                if ((seen_corners_[face] >> c & 1) == 0) {
                    free_around(face, c);
                }
            }
        }
        return any;
    }

private:
    /// Around the vertex at a corner of the face; queues what leaves, to look around its other
    /// vertices.
    bool free_around(int face, int corner) {
        list_around(face, corner);
        fans_.clear();
        for (std::size_t i = 0; i < around_.size(); ++i) {
            const int label = patchwork_.label(around_[i].face);
            if (i > 0 && label == patchwork_.label(around_[i - 1].face)) {
                ++fans_.back().face_count;
            } else {
                fans_.push_back({label, static_cast<int>(i), 1});
            }
        }
        std::sort(fans_.begin(), fans_.end(), [](const RimFan& a, const RimFan& b) {
            return std::tie(a.label, b.face_count, a.begin) <
                std::tie(b.label, a.face_count, b.begin);
        });
        bool any = false;
        for (std::size_t i = 1; i < fans_.size(); ++i) {
            const RimFan& fan = fans_[i];
            if (fan.label == fans_[i - 1].label && fan.label >= 0 && !sound_[fan.label]) {
                for (int j = fan.begin; j < fan.begin + fan.face_count; ++j) {
                    const Corner& corner = around_[j];
                    patchwork_.set_label(corner.face, -1);
                    seen_corners_[corner.face] = 1 << corner.at;
                    queue_.push_back(corner.face);
                }
                any = true;
            }
        }
        return any;
    }

    /// The faces around the vertex at a corner of a face, one beside the other; where they close to
    /// a ring, the label changes between the last and the first one, if it does anywhere.
    void list_around(int face, int corner) {
        const bool is_ring = list_corners(patchwork_, face, corner, around_);
        for (const Corner& met : around_) {
            seen_corners_[met.face] |= 1 << met.at;
        }
        const auto changes = std::adjacent_find(
            around_.begin(), around_.end(), [&](const Corner& a, const Corner& b) {
                return patchwork_.label(a.face) != patchwork_.label(b.face);
            });
        if (is_ring && changes != around_.end()) {
            std::rotate(around_.begin(), changes + 1, around_.end());
        }
    }

    Patchwork& patchwork_;
    const std::vector<std::uint8_t>& sound_;
    std::vector<int> queue_;
    /// Bit c: fans around the vertex at corner c were looked at.
    std::vector<std::uint8_t> seen_corners_;
    /// Around a vertex.
    std::vector<Corner> around_;
    struct RimFan {
        int label;
        /// In `around_`.
        int begin;
        int face_count;
    };
    std::vector<RimFan> fans_;
};

} // namespace

void free_faults(Patchwork& patchwork, const std::vector<std::uint8_t>& sound) {
    free_small_pieces(patchwork);
    if (SmallFans(patchwork, sound).free()) {
        free_small_pieces(patchwork);
    }
    sum_loads(patchwork);
}

} // namespace spheroseg
