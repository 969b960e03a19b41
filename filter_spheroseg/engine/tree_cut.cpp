// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree_cut.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace spheroseg {

namespace {

/// Tries with the whole region, and spanning trees that each part of it gets in one of them.
constexpr int kTries = 3;
constexpr int kTreesPerPart = 3;

/// One of so many trees follows walls, if any does.
constexpr std::uint32_t kAlongWallsOneOf = 4;

constexpr int kOutside = -1;
constexpr int kWaiting = -2;

} // namespace

TreeCut::TreeCut(Patchwork& patchwork, TreeTurns turns)
    : patchwork_(patchwork), turns_(turns), bowtie_finder_(patchwork),
      place_(patchwork.cells.size(), kOutside), is_of_first_(patchwork.cells.size(), 0) {}

bool TreeCut::cut(const Region& region, const std::vector<int>& sizes, Random& random) {
    faces_ = region.faces;
    labels_ = &region.labels;
    sizes_ = &sizes;
    const Set all = (Set{1} << sizes.size()) - 1;
    for (int i = 0; i < kTries; ++i) {
        if (cut_part(0, faces_.size(), all, random) && is_free_of_bowties()) {
            return true;
        }
    }
    return false;
}

bool TreeCut::cut_in_two(const Region& region, int wanted, int limit, Random& random) {
    faces_ = region.faces;
    for (int f : faces_) {
        is_of_first_[f] = patchwork_.label(f) == region.labels[0];
    }
    for (int tries = kTries * kTreesPerPart; tries > 0; --tries) {
        if (!grow_tree(0, faces_.size(), random)) {
            return false;
        }
        const bool is_last = tries == 1 || is_only_tree_;
        const auto [root, hangs] = nearest_cut(wanted, is_last ? limit : wanted);
        if (root > 0) {
            const std::size_t middle = part_off(0, root);
            label_faces(0, middle, region.labels[hangs ? 0 : 1]);
            label_faces(middle, faces_.size(), region.labels[hangs ? 1 : 0]);
            if (is_free_of_bowties()) {
                return true;
            }
        }
        if (is_last) {
            break;
        }
    }
    return false;
}

/// Of the cuts of the tree that give the first sub-mesh as nearly as possible the wanted size, up
/// to a limit, the one in which it keeps the most of its faces.
TreeCut::Cut TreeCut::nearest_cut(int wanted, int limit) {
    of_first_.assign(tree_.size(), 0);
    for (std::size_t at = tree_.size(); --at > 0;) {
        of_first_[at] += is_of_first_[tree_[at]];
        of_first_[parent_[at]] += of_first_[at];
    }
    of_first_[0] += is_of_first_[tree_[0]];
    const auto [least, most] = std::minmax({wanted, limit});
    const auto face_count = static_cast<int>(tree_.size());
    Cut best = {0, false};
    int nearest = face_count;
    int kept = -1;
    for (std::size_t at = 1; at < tree_.size(); ++at) {
        for (const bool hangs : {true, false}) {
            const int size = hangs ? hanging_[at] : face_count - hanging_[at];
            const int distance = std::abs(size - wanted);
            const int keeps = hangs ? of_first_[at] : of_first_[0] - of_first_[at];
            if (size >= least && size <= most &&
                (distance < nearest || (distance == nearest && keeps > kept))) {
                best = {at, hangs};
                nearest = distance;
                kept = keeps;
            }
        }
    }
    return best;
}

/// Cuts the connected faces faces_[begin, end) into the sub-meshes of a set.
bool TreeCut::cut_part(std::size_t begin, std::size_t end, Set set, Random& random) {
    if ((set & (set - 1)) == 0) {
        label_faces(begin, end, (*labels_)[__builtin_ctz(set)]);
        return true;
    }
    set_of_size_.assign(end - begin, 0);
    for (Set some = (set - 1) & set; some > 0; some = (some - 1) & set) {
        set_of_size_[size_of(some)] = some;
    }
    for (int i = 0; i < kTreesPerPart; ++i) {
        if (!grow_tree(begin, end, random)) {
            return false;
        }
        std::size_t root = 0;
        std::uint32_t found = 0;
        for (std::size_t at = 1; at < tree_.size(); ++at) {
            if (set_of_size_[hanging_[at]] != 0 && random.below(++found) == 0) {
                root = at;
            }
        }
        if (found > 0) {
            const Set first = set_of_size_[hanging_[root]];
            const std::size_t middle = part_off(begin, root);
            return cut_part(begin, middle, first, random) &&
                cut_part(middle, end, set & ~first, random);
        }
        if (is_only_tree_) {
            break;
        }
    }
    return false;
}

/// Reorders the faces from `begin` on, on which the tree has grown, so that those of the subtree at
/// `root` come first. Returns where the others begin.
std::size_t TreeCut::part_off(std::size_t begin, std::size_t root) {
    const auto subtree = tree_.begin() + static_cast<std::ptrdiff_t>(root);
    std::rotate(tree_.begin(), subtree, subtree + hanging_[root]);
    std::copy(tree_.begin(), tree_.end(), faces_.begin() + static_cast<std::ptrdiff_t>(begin));
    return begin + static_cast<std::size_t>(hanging_[root]);
}

void TreeCut::label_faces(std::size_t begin, std::size_t end, int label) {
    for (std::size_t i = begin; i < end; ++i) {
        patchwork_.set_label(faces_[i], label);
    }
    patchwork_.load[label] = static_cast<int>(end - begin);
}

/// Grows a random spanning tree on faces_[begin, end). False when these are not connected.
bool TreeCut::grow_tree(std::size_t begin, std::size_t end, Random& random) {
    const std::size_t count = end - begin;
    for (std::size_t i = begin; i < end; ++i) {
        place_[faces_[i]] = kWaiting;
    }
    tree_.clear();
    parent_.clear();
    way_.clear();
    std::size_t sides = 0; // where two of these faces meet
    const auto add = [&](NeighborSide side, int parent) {
        place_[face_of(side)] = static_cast<int>(tree_.size());
        tree_.push_back(face_of(side));
        parent_.push_back(parent);
        way_.push_back(side);
    };
    const bool follows_walls =
        turns_ == TreeTurns::often_along_walls && random.below(kAlongWallsOneOf) == 0;
    add(make_side(faces_[begin + random.below(static_cast<std::uint32_t>(count))], 0, false), -1);
    while (!way_.empty()) {
        const int face = face_of(way_.back());
        const int first =
            follows_walls ? corner_of(way_.back()) + 1 : static_cast<int>(random.below(3));
        NeighborSide next = -1;
        std::size_t met = 0;
        for (int c = 0; c < 3 && next < 0; ++c) {
            const NeighborSide across = patchwork_.cells[face].side[(first + c) % 3];
            if (across >= 0 && place_[face_of(across)] != kOutside) {
                next = place_[face_of(across)] == kWaiting ? across : -1;
                ++met;
            }
        }
        if (next >= 0) {
            add(next, place_[face]);
        } else {
            way_.pop_back();
            sides += met;
        }
    }
    for (std::size_t i = begin; i < end; ++i) {
        place_[faces_[i]] = kOutside;
    }
    is_only_tree_ = sides == 2 * (count - 1);
    hanging_.assign(tree_.size(), 1);
    for (std::size_t at = tree_.size(); --at > 0;) {
        hanging_[parent_[at]] += hanging_[at];
    }
    return tree_.size() == count;
}

int TreeCut::size_of(Set set) const {
    int size = 0;
    for (std::size_t i = 0; i < sizes_->size(); ++i) {
        size += (set >> i & 1) != 0 ? (*sizes_)[i] : 0;
    }
    return size;
}

bool TreeCut::is_free_of_bowties() {
    // The faces of each sub-mesh lie together.
    const auto ends = [this](int face, int corner) { return fan_ends(patchwork_, face, corner); };
    for (std::size_t begin = 0; begin < faces_.size();) {
        const int label = patchwork_.label(faces_[begin]);
        const std::size_t end = begin + static_cast<std::size_t>(patchwork_.load[label]);
        if (bowtie_finder_.has_bowtie(faces_, begin, end, ends)) {
            return false;
        }
        begin = end;
    }
    return true;
}

} // namespace spheroseg
