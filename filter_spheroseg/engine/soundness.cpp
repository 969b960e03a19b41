// SPDX-License-Identifier: GPL-3.0-or-later
#include "soundness.h"

#include "pieces.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// Finds bowties, around each vertex once.
class Bowties {
public:
    explicit Bowties(const Patchwork& patchwork)
        : patchwork_(patchwork), met_(patchwork.cells.size(), 0),
          ends_(patchwork.submesh_count(), 0) {}

    /// Sets sound[l] to 0 for the sub-meshes of which more than one fan lies around a vertex.
    void find(std::vector<std::uint8_t>& sound) {
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                if ((met_[f] >> c & 1) == 0 && fan_ends(patchwork_, f, c) > 0) {
                    for_each_around(
                        patchwork_, f, c, [this](int face, int corner) { add_ends(face, corner); });
                    for (int label : labels_) {
                        sound[label] = sound[label] && ends_[label] <= 2;
                        ends_[label] = 0;
                    }
                    labels_.clear();
                }
            }
        }
    }

private:
    void add_ends(int face, int corner) {
        met_[face] |= 1 << corner;
        const int ends = fan_ends(patchwork_, face, corner);
        if (ends > 0) {
            ends_[patchwork_.label(face)] += ends;
            labels_.push_back(patchwork_.label(face));
        }
    }

    const Patchwork& patchwork_;
    /// Bit c: the vertex at corner c was looked at.
    std::vector<std::uint8_t> met_;
    /// Around this vertex, by sub-mesh, and the sub-meshes that have any.
    std::vector<int> ends_;
    std::vector<int> labels_;
};

} // namespace

std::vector<std::uint8_t> sound_submeshes(const Patchwork& patchwork) {
    std::vector<int> pieces(patchwork.submesh_count(), 0);
    for (const Piece& piece : find_pieces(patchwork).pieces) {
        ++pieces[piece.label];
    }
    std::vector<std::uint8_t> sound(patchwork.submesh_count());
    for (std::size_t l = 0; l < sound.size(); ++l) {
        sound[l] = pieces[l] == 1;
    }
    Bowties(patchwork).find(sound);
    return sound;
}

bool are_all_sound(const std::vector<std::uint8_t>& sound_submeshes) {
    return std::find(sound_submeshes.begin(), sound_submeshes.end(), 0) == sound_submeshes.end();
}

bool is_sound(const Patchwork& patchwork) {
    return are_all_sound(sound_submeshes(patchwork));
}

} // namespace spheroseg
