// SPDX-License-Identifier: GPL-3.0-or-later
#include "bridge_bound.h"

#include <algorithm>
#include <iterator>
#include <unordered_map>
#include <utility>

namespace spheroseg {

namespace {

/// Sub-meshes with more faces too many are not looked at.
constexpr int kMostMisplaced = 1000;
constexpr int kOutOfSight = kMostMisplaced + 1;
/// Steps for each face, and any more.
constexpr std::int64_t kWorkPerFace = 100;
constexpr std::int64_t kMoreWork = 100000000;

/// For each number of faces that the sub-mesh on a bridge has beyond it, how many are misplaced in
/// the others there. 0: the bridge is on a boundary.
using Misplaced = std::vector<int>;

/// The faces of a depth-first search, in the order in which it meets them.
struct Walk {
    std::vector<int> order;
    /// For each face the one from which it was met; -1 for the first one.
    std::vector<int> parent;
    std::vector<bool> is_over_bridge;
};

Walk walk_from_first_face(const Patchwork& patchwork) {
    struct Step {
        int face;
        int entry; // the corner whose edge leads back; -1 at first
        int corner;
    };
    const int face_count = patchwork.face_count();
    Walk walk;
    walk.parent.assign(face_count, -1);
    walk.is_over_bridge.assign(face_count, false);
    // The place in the order, and the first place that the faces met from it on are beside.
    std::vector<int> place(face_count, -1);
    std::vector<int> lowest(face_count);
    const auto meet = [&](int face) {
        lowest[face] = place[face] = static_cast<int>(walk.order.size());
        walk.order.push_back(face);
    };
    std::vector<Step> steps = {{0, -1, 0}};
    meet(0);
    while (!steps.empty()) {
        Step& step = steps.back();
        const int face = step.face;
        if (step.corner == 3) {
            steps.pop_back();
            const int parent = walk.parent[face];
            if (parent >= 0) {
                walk.is_over_bridge[face] = lowest[face] == place[face];
                lowest[parent] = std::min(lowest[parent], lowest[face]);
            }
            continue;
        }
        const int corner = step.corner++;
        const NeighborSide across = patchwork.cells[face].side[corner];
        if (corner == step.entry || across < 0) {
            continue;
        }
        const int next = face_of(across);
        if (place[next] < 0) {
            walk.parent[next] = face;
            meet(next);
            steps.push_back({next, corner_of(across), 0});
        } else {
            lowest[face] = std::min(lowest[face], place[next]);
        }
    }
    return walk;
}

class BridgeBound {
public:
    BridgeBound(const Patchwork& patchwork, const LoadRange& asked)
        : asked_(asked), work_left_(kMoreWork + kWorkPerFace * patchwork.face_count()) {}

    /// Faces that are joined without bridges make a node; those of one face are treated exactly.
    int of(const Walk& walk) {
        const std::size_t face_count = walk.parent.size();
        std::vector<int> node(face_count); // its first face
        std::vector<int> own_faces(face_count, 0);
        std::vector<int> all_faces(face_count, 0); // with the nodes beyond
        for (int face : walk.order) {
            const int parent = walk.parent[face];
            node[face] = parent < 0 || walk.is_over_bridge[face] ? face : node[parent];
            ++own_faces[node[face]];
        }
        std::unordered_map<int, std::vector<Misplaced>> beyond;
        for (auto at = walk.order.rbegin(); at != walk.order.rend(); ++at) {
            const int face = *at;
            if (node[face] != face) {
                continue;
            }
            all_faces[face] += own_faces[face];
            Misplaced misplaced = of_node(own_faces[face], all_faces[face], beyond[face]);
            beyond.erase(face);
            if (work_left_ < 0) {
                return 0;
            }
            if (walk.parent[face] < 0) {
                return std::min(misplaced[0], kOutOfSight);
            }
            const int outer = node[walk.parent[face]];
            all_faces[outer] += all_faces[face];
            beyond[outer].push_back(std::move(misplaced));
        }
        return 0;
    }

private:
    Misplaced of_node(int own_faces, int all_faces, const std::vector<Misplaced>& beyond) {
        Misplaced misplaced(std::min(all_faces, asked_.ceiling + kMostMisplaced) + 1, 0);
        work_left_ -= static_cast<std::int64_t>(misplaced.size());
        if (own_faces == 1) {
            misplaced = of_face(beyond);
        } else {
            // Sub-meshes that meet have no less too many than they have apart. What the one on this
            // bridge has too many counts beyond it.
            int sum = 0;
            for (const Misplaced& other : beyond) {
                sum += least(other);
            }
            for (int i = 0; i < static_cast<int>(misplaced.size()); ++i) {
                misplaced[i] = std::max(0, std::min(sum, kOutOfSight) - excess(i));
            }
        }
        for (int i = 0; i < static_cast<int>(misplaced.size()); ++i) {
            misplaced[i] = std::max(misplaced[i], in_any_cut_of(all_faces - i));
        }
        return misplaced;
    }

    /// Faces that a sub-mesh has too many.
    int excess(int faces) const { return std::max(0, faces - asked_.ceiling); }

    /// In the sub-mesh on the bridge, too, which has at least one face on this side of it.
    int least(const Misplaced& beyond) const {
        int least = kOutOfSight;
        for (int i = 0; i < static_cast<int>(beyond.size()); ++i) {
            least = std::min(least, beyond[i] + excess(i + 1));
        }
        return least;
    }

    /// Of a face with what is beyond its bridges.
    Misplaced of_face(const std::vector<Misplaced>& beyond) {
        Misplaced sum = {kOutOfSight, 0};
        for (const Misplaced& other : beyond) {
            const std::size_t size = std::min<std::size_t>(sum.size() + other.size() - 1,
                                                           asked_.ceiling + kMostMisplaced + 1);
            Misplaced next(size, kOutOfSight);
            work_left_ -= static_cast<std::int64_t>(sum.size() * other.size());
            for (std::size_t i = 1; i < sum.size() && work_left_ >= 0; ++i) {
                for (std::size_t j = 0; j < other.size() && i + j < size; ++j) {
                    next[i + j] = std::min(next[i + j], sum[i] + other[j]);
                }
            }
            sum = std::move(next);
        }
        for (int i = 1; i < static_cast<int>(sum.size()); ++i) {
            sum[0] = std::min(sum[0], sum[i] + asked_.deviation(i));
        }
        return sum;
    }

    /// At least so many are misplaced when so many faces are cut into any number of sub-meshes.
    int in_any_cut_of(int faces) const {
        const int count = (faces + asked_.ceiling - 1) / asked_.ceiling;
        const int too_few = std::max(0, count * asked_.floor - faces);
        return count < 2 ? too_few : std::min(too_few, faces - (count - 1) * asked_.ceiling);
    }

    const LoadRange asked_;
    std::int64_t work_left_;
};

} // namespace

std::int64_t least_misplaced(const Patchwork& patchwork, const LoadRange& asked) {
    // One edge alone does not bound faces of a closed surface.
    const bool is_closed =
        std::all_of(patchwork.cells.begin(), patchwork.cells.end(), [](const Cell& cell) {
            return *std::min_element(std::begin(cell.side), std::end(cell.side)) >= 0;
        });
    return is_closed ? 0 : BridgeBound(patchwork, asked).of(walk_from_first_face(patchwork));
}

} // namespace spheroseg
