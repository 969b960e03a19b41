// SPDX-License-Identifier: GPL-3.0-or-later
#include "branch_decomposition.h"

#include "union_find.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <tuple>
#include <utility>

namespace spheroseg {

namespace {

/// Single faces.
std::vector<FaceBlock> face_blocks(const Patchwork& patchwork, const std::vector<int>& faces) {
    std::vector<std::pair<int, int>> numbers;
    for (int f : faces) {
        numbers.emplace_back(f, static_cast<int>(numbers.size()));
    }
    std::sort(numbers.begin(), numbers.end());
    std::vector<FaceBlock> blocks(faces.size());
    blocks.reserve(2 * faces.size());
    for (int i = 0; i < static_cast<int>(faces.size()); ++i) {
        for (int neighbor : patchwork.neighbors(faces[i])) {
            const auto found =
                std::lower_bound(numbers.begin(), numbers.end(), std::pair(neighbor, 0));
            if (found != numbers.end() && found->first == neighbor) {
                blocks[i].outer.push_back({i, found->second});
            }
        }
    }
    return blocks;
}

class Joining {
public:
    Joining(std::vector<FaceBlock> faces, int most_edges, Random& random)
        : blocks_(std::move(faces)), most_edges_(most_edges), random_(random),
          whole_(2 * static_cast<int>(blocks_.size())) {}

    std::vector<FaceBlock> run() && {
        const auto face_count = static_cast<int>(blocks_.size());
        for (int i = 0; i < face_count; ++i) {
            offer_neighbors(i);
        }
        while (!offers_.empty() && std::get<0>(offers_.top()) <= most_edges_) {
            const int first = std::get<4>(offers_.top());
            const int second = std::get<5>(offers_.top());
            offers_.pop();
            if (whole_.find(first) == first && whole_.find(second) == second) {
                join(first, second);
                offer_neighbors(static_cast<int>(blocks_.size()) - 1);
            }
        }
        if (blocks_.empty() || blocks_.back().face_count < face_count) {
            return {};
        }
        return std::move(blocks_);
    }

private:
    /// Offers to join a block to each one beside it.
    void offer_neighbors(int block) {
        std::vector<int> others;
        for (const FaceBlock::Edge& edge : blocks_[block].outer) {
            others.push_back(whole_.find(edge.outside));
        }
        std::sort(others.begin(), others.end());
        for (auto begin = others.begin(); begin != others.end();) {
            const auto end = std::upper_bound(begin, others.end(), *begin);
            const FaceBlock& other = blocks_[*begin];
            const auto outer = static_cast<int>(blocks_[block].outer.size() + other.outer.size()) -
                2 * static_cast<int>(end - begin);
            int apart = 0;
            for (const FaceBlock::Edge& edge : other.outer) {
                const int third = whole_.find(edge.outside);
                apart -= third != block && std::binary_search(others.begin(), others.end(), third);
            }
            offers_.emplace(outer,
                            apart,
                            blocks_[block].face_count + other.face_count,
                            random_.next(),
                            block,
                            *begin);
            begin = end;
        }
    }

    void join(int first, int second) {
        const auto name = static_cast<int>(blocks_.size());
        FaceBlock block;
        block.of = {first, second};
        block.face_count = blocks_[first].face_count + blocks_[second].face_count;
        for (const int side : {0, 1}) {
            const std::vector<FaceBlock::Edge>& edges = blocks_[block.of[side]].outer;
            const std::vector<FaceBlock::Edge>& others = blocks_[block.of[1 - side]].outer;
            for (int e = 0; e < static_cast<int>(edges.size()); ++e) {
                const FaceBlock::Edge edge = edges[e];
                if (whole_.find(edge.outside) != block.of[1 - side]) {
                    block.outer.push_back(edge);
                    block.origin.push_back({side, e});
                } else if (side == 0) {
                    const auto same = std::find_if(
                        others.begin(), others.end(), [&](const FaceBlock::Edge& other) {
                            return other.inside == edge.outside && other.outside == edge.inside;
                        });
                    block.inner.push_back({e, static_cast<int>(same - others.begin())});
                }
            }
        }
        blocks_.push_back(std::move(block));
        whole_.join(first, name);
        whole_.join(second, name);
    }

    std::vector<FaceBlock> blocks_;
    const int most_edges_;
    Random& random_;
    /// Blocks that are in one: the largest one so far names them.
    UnionFind whole_;
    /// Two blocks that may be joined: the outer edges of both together, less the more of them lead
    /// to blocks that touch both, their faces, a random number, and which they are.
    using Offer = std::tuple<int, int, int, std::uint64_t, int, int>;
    std::priority_queue<Offer, std::vector<Offer>, std::greater<>> offers_;
};

} // namespace

std::vector<FaceBlock> branch_decomposition(const Patchwork& patchwork,
                                            const std::vector<int>& faces,
                                            int most_edges,
                                            Random& random) {
    return Joining(face_blocks(patchwork, faces), most_edges, random).run();
}

} // namespace spheroseg
