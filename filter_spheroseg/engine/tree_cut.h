// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "bowtie_finder.h"
#include "patchwork.h"
#include "random.h"

#include <cstdint>
#include <vector>

namespace spheroseg {

/// How spanning trees turn: at random; or, every fourth one, always to the same hand, along the
/// border of the region or along faces that the tree already has (wall following). Such a tree runs
/// up one side of a narrow limb and down the other, so that it can be cut lengthwise, which random
/// trees hardly ever allow. The boundaries that it gives are long.
enum class TreeTurns { random, often_along_walls };

/// Cuts connected regions of a patchwork of unit weights anew into sub-meshes of given sizes. A
/// random spanning tree of the faces is cut at an edge below which there are as many faces as some
/// of the sub-meshes have together, and both parts are cut further in the same way. The trees are
/// grown depth first: they are mostly long paths, which can be cut nearly anywhere.
/// Source: DeFord, Duchin, Solomon, Recombination: A Family of Markov Chains for Redistricting
/// ("ReCom"), 2021.
class TreeCut {
public:
    /// O(F).
    explicit TreeCut(Patchwork& patchwork, TreeTurns turns = TreeTurns::random);

    /// Cuts the sub-meshes of a region anew such that each is connected and free of bowties, and
    /// region.labels[i] has sizes[i] > 0 faces. The sizes sum up to the faces of the region.
    /// Returns false when a few trees gave no such cut; then the labels of the region and their
    /// loads mean nothing. At most 8 labels.
    bool cut(const Region& region, const std::vector<int>& sizes, Random& random);

    /// The same for two sub-meshes, of which the first one is to have `wanted` faces or, where that
    /// was not found, as near to it as the last tree allows, up to `limit` (which is above `wanted`
    /// or below). Of the cuts of a tree the one counts in which the first one keeps the most of its
    /// faces: the two are not to change places.
    bool cut_in_two(const Region& region, int wanted, int limit, Random& random);

private:
    /// A set of sub-meshes of the region, one bit for each.
    using Set = unsigned;

    /// The first sub-mesh is the subtree at the place `root` of the tree (`hangs`), or all but that
    /// subtree. Place 0, the root of the whole tree, stands for no cut.
    struct Cut {
        std::size_t root;
        bool hangs;
    };

    Cut nearest_cut(int wanted, int limit);
    bool cut_part(std::size_t begin, std::size_t end, Set set, Random& random);
    bool grow_tree(std::size_t begin, std::size_t end, Random& random);
    std::size_t part_off(std::size_t begin, std::size_t root);
    void label_faces(std::size_t begin, std::size_t end, int label);
    int size_of(Set set) const;
    bool is_free_of_bowties();

    Patchwork& patchwork_;
    const TreeTurns turns_;
    BowtieFinder bowtie_finder_;
    /// For each face its place in the tree, kWaiting, or kOutside of the part that a tree grows on.
    std::vector<int> place_;
    /// The faces of the region; what was cut lies together.
    std::vector<int> faces_;
    const std::vector<int>* labels_ = nullptr;
    const std::vector<int>* sizes_ = nullptr;
    /// The tree in depth-first order: its faces, the places of their parents, and the sizes of the
    /// subtrees. The faces of a subtree are consecutive.
    std::vector<int> tree_;
    std::vector<int> parent_;
    std::vector<int> hanging_;
    /// Which faces are of the first sub-mesh before the cut, and how many of them each subtree has.
    std::vector<std::uint8_t> is_of_first_;
    std::vector<int> of_first_;
    /// The path from the root of a growing tree to its last face: for each face the side by which
    /// the path enters it.
    std::vector<NeighborSide> way_;
    /// The faces have no other spanning tree: another try would be the same.
    bool is_only_tree_ = false;
    /// For each number of faces a set of sub-meshes that have so many together; 0: none.
    std::vector<Set> set_of_size_;
};

} // namespace spheroseg
