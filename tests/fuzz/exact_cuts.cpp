// SPDX-License-Identifier: GPL-3.0-or-later
#include "exact_cuts.h"

#include <cstdint>
#include <set>

namespace spheroseg::fuzz {

namespace {

using FaceSet = std::uint64_t;

constexpr int kMaxFaces = 64;
constexpr std::size_t kMaxPatches = 100000;
constexpr int kMaxSteps = 300000;
/// Patches looked at, over all sizes.
constexpr int kMaxLooks = 30000;

int lowest(FaceSet set) {
    return __builtin_ctzll(set);
}
int size_of(FaceSet set) {
    return __builtin_popcountll(set);
}

/// Covers the faces with patches, each time the lowest face that is not covered yet.
class Search {
public:
    Search(const Surface& surface, int submesh_count)
        : surface_(surface), submesh_count_(submesh_count), neighbors_(surface.face_count(), 0),
          patches_(surface.face_count()) {
        for (const Surface::SharedEdge& edge : surface.shared_edges()) {
            neighbors_[edge.faces[0]] |= FaceSet{1} << edge.faces[1];
            neighbors_[edge.faces[1]] |= FaceSet{1} << edge.faces[0];
        }
        all_ = ~FaceSet{0} >> (kMaxFaces - surface.face_count());
    }

    Answer run(int least, int most) {
        least_ = least;
        most_ = most;
        patch_count_ = 0;
        steps_ = 0;
        dead_.clear();
        for (int root = 0; root < surface_.face_count(); ++root) {
            patches_[root].clear();
            const FaceSet lower = (FaceSet{1} << root) - 1;
            grow(root, FaceSet{1} << root, neighbors_[root] & ~lower, lower | FaceSet{1} << root);
        }
        if (gave_up()) {
            return Answer::unknown;
        }
        return cover(0, 0);
    }

    bool gave_up() const { return patch_count_ > kMaxPatches || looks_ > kMaxLooks; }

private:
    /// Collects the patches of a root: `open` are the neighbours that may still be added, `closed`
    /// those that may not, so that no patch is met twice.
    void grow(int root, FaceSet patch, FaceSet open, FaceSet closed) {
        ++looks_;
        if (gave_up()) {
            return;
        }
        if (size_of(patch) >= least_ && is_free_of_bowties(patch)) {
            patches_[root].push_back(patch);
            ++patch_count_;
        }
        if (size_of(patch) == most_) {
            return;
        }
        open &= ~closed;
        while (open) {
            const int face = lowest(open);
            const FaceSet bit = FaceSet{1} << face;
            open &= ~bit;
            closed |= bit;
            grow(root, patch | bit, open | (neighbors_[face] & ~closed), closed);
        }
    }

    bool is_free_of_bowties(FaceSet patch) {
        std::vector<int> faces;
        for (FaceSet rest = patch; rest; rest &= rest - 1) {
            faces.push_back(lowest(rest));
        }
        return surface_.count_bowties(faces) == 0;
    }

    Answer cover(FaceSet covered, int used) {
        if (covered == all_) {
            return used == submesh_count_ ? Answer::yes : Answer::no;
        }
        const int left = surface_.face_count() - size_of(covered);
        const int parts = submesh_count_ - used;
        if (left < parts * least_ || left > parts * most_ || dead_.count({covered, used}) > 0) {
            return Answer::no;
        }
        if (++steps_ > kMaxSteps) {
            return Answer::unknown;
        }
        Answer answer = Answer::no;
        for (FaceSet patch : patches_[lowest(~covered)]) {
            if ((patch & covered) == 0) {
                const Answer below = cover(covered | patch, used + 1);
                if (below == Answer::yes) {
                    return below;
                }
                answer = below == Answer::unknown ? below : answer;
            }
        }
        if (answer == Answer::no) {
            dead_.insert({covered, used});
        }
        return answer;
    }

    const Surface& surface_;
    const int submesh_count_;
    std::vector<FaceSet> neighbors_;
    std::vector<std::vector<FaceSet>> patches_;
    FaceSet all_ = 0;
    int least_ = 0;
    int most_ = 0;
    std::size_t patch_count_ = 0;
    int steps_ = 0;
    int looks_ = 0;
    std::set<std::pair<FaceSet, int>> dead_;
};

} // namespace

Answer can_be_cut(const Surface& surface, int submesh_count, int count_difference) {
    if (surface.face_count() > kMaxFaces) {
        return Answer::unknown;
    }
    Search search(surface, submesh_count);
    // From the most even sizes on, of which there are the fewest.
    Answer answer = Answer::no;
    for (int least = surface.face_count() / submesh_count; least >= 1; --least) {
        if ((least + count_difference) * submesh_count < surface.face_count()) {
            continue;
        }
        const Answer here = search.run(least, least + count_difference);
        if (here == Answer::yes) {
            return here;
        }
        answer = here == Answer::unknown ? here : answer;
        if (search.gave_up()) {
            break;
        }
    }
    return answer;
}

} // namespace spheroseg::fuzz
