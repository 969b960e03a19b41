// SPDX-License-Identifier: GPL-3.0-or-later
#include "disks.h"

#include "face_walk.h"

#include <algorithm>

namespace spheroseg {

namespace {

class Disks {
public:
    Disks(Patchwork& patchwork, const std::vector<std::uint8_t>& sound)
        : patchwork_(patchwork), sound_(sound) {}

    void shrink() {
        const int submesh_count = patchwork_.submesh_count();
        const int face_count = patchwork_.face_count();
        const auto [begin, faces] = sort_by_label(patchwork_);
        std::vector<int> seeds(submesh_count, -1);
        std::vector<std::uint8_t> seen(face_count, 0);
        for (int l = 0; l < submesh_count; ++l) {
            if (!sound_[l]) {
                seeds[l] = deepest(faces, begin[l], begin[l + 1], seen);
            }
        }
        for (int f = 0; f < face_count; ++f) {
            patchwork_.set_own_label(f, candidate(patchwork_.label(f)));
        }
        patchwork_.tell_neighbors();
        for (int l = 0; l < submesh_count; ++l) {
            if (seeds[l] >= 0) {
                grow(seeds[l], l);
            }
            for (int i = begin[l]; i < begin[l + 1] && sound_[l]; ++i) {
                patchwork_.set_label(faces[i], l);
            }
        }
        for (int f = 0; f < face_count; ++f) {
            patchwork_.set_own_label(f, std::max(patchwork_.label(f), -1));
        }
        patchwork_.tell_neighbors();
        sum_loads(patchwork_);
    }

private:
    // While a disk grows, a face that may still join sub-mesh l has the label -3 - l, below -1
    // (unassigned) and -2 (kOpenBorder).
    static int candidate(int label) { return -3 - label; }

    /// The face of a sub-mesh that is farthest from its boundary, of the component where that is
    /// largest; -1 when it is empty.
    int
    deepest(const std::vector<int>& faces, int begin, int end, std::vector<std::uint8_t>& seen) {
        queue_.clear();
        for (int i = begin; i < end; ++i) {
            if (is_at_rim(patchwork_, faces[i])) {
                seen[faces[i]] = 1;
                queue_.push_back(faces[i]);
            }
        }
        if (queue_.empty()) {
            return begin < end ? faces[begin] : -1;
        }
        walk_faces(patchwork_, queue_, [&](int face, int neighbor) {
            if (seen[neighbor] || patchwork_.label(neighbor) != patchwork_.label(face)) {
                return false;
            }
            seen[neighbor] = 1;
            return true;
        });
        return queue_.back();
    }

    void grow(int seed, int label) {
        queue_.assign(1, seed);
        patchwork_.set_label(seed, label);
        walk_faces(patchwork_, queue_, [&](int, int neighbor) {
            if (patchwork_.label(neighbor) != candidate(label) ||
                !may_join(patchwork_, neighbor, label)) {
                return false;
            }
            patchwork_.set_label(neighbor, label);
            return true;
        });
    }

    Patchwork& patchwork_;
    const std::vector<std::uint8_t>& sound_;
    std::vector<int> queue_;
};

} // namespace

void shrink_to_disks(Patchwork& patchwork, const std::vector<std::uint8_t>& sound) {
    Disks(patchwork, sound).shrink();
}

} // namespace spheroseg
