// SPDX-License-Identifier: GPL-3.0-or-later
#include "levels.h"

#include "threads.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace spheroseg {

namespace {

/// Faces of a connected cluster that get numbers in a row.
constexpr int kClusterFaces = 256;
/// Steps of a round that are worth a thread.
constexpr int kStepsPerThread = 1024;

/// A triangle and its neighbours: neighbor[c] lies across the edge from vertex[c] to the next one.
struct LinkedTriangle {
    Triangle vertex;
    std::array<int, 3> neighbor;

    int corner(int v) const { return (vertex[1] == v) + 2 * (vertex[2] == v); }
};

/// For each side of a triangle the side of the neighbour there; face f has the number place[f].
template <typename TriangleOf>
std::array<NeighborSide, 3> sides_of(const LinkedTriangle& triangle,
                                     const TriangleOf& triangle_of,
                                     const std::vector<int>& place) {
    std::array<NeighborSide, 3> sides{-1, -1, -1};
    for (int c = 0; c < 3; ++c) {
        const int neighbor = triangle.neighbor[c];
        if (neighbor >= 0) {
            const LinkedTriangle other = triangle_of(neighbor);
            const int begin = other.corner(triangle.vertex[c]);
            const int end = other.corner(triangle.vertex[next_corner(c)]);
            const bool turned = next_corner(end) != begin;
            sides[c] = make_side(place[neighbor], turned ? begin : end, turned);
        }
    }
    return sides;
}

/// The hubs of a level; they are searched for only if some vertex has enough faces, which counting
/// tells in far less time. `triangle_of(f)` are the vertices of face f in any numbering of the
/// faces: counting is fastest in the order in which they lie in memory.
template <typename TriangleOf>
std::shared_ptr<const Hubs> hubs_of(const std::vector<std::array<NeighborSide, 3>>& sides,
                                    const TriangleOf& triangle_of) {
    std::vector<int> degrees;
    int most = 0;
    for (int f = 0; f < static_cast<int>(sides.size()); ++f) {
        for (int v : triangle_of(f)) {
            if (v >= static_cast<int>(degrees.size())) {
                degrees.resize(v + 1, 0);
            }
            most = std::max(most, ++degrees[v]);
        }
    }
    return most > Hubs::kMostWalked ? find_hubs(sides) : nullptr;
}

std::vector<int> inverse(const std::vector<int>& order, std::size_t size) {
    std::vector<int> place(size);
    for (std::size_t i = 0; i < order.size(); ++i) {
        place[order[i]] = static_cast<int>(i);
    }
    return place;
}

/// An order of the faces in connected clusters of up to kClusterFaces, each adjacent to an earlier
/// one unless a new component begins.
std::vector<int> order_by_clusters(const DualGraph& dual_graph) {
    const int face_count = dual_graph.face_count();
    std::vector<int> order;
    order.reserve(face_count);
    std::vector<std::uint8_t> seen(face_count, 0);
    std::vector<int> border;
    std::size_t next_border = 0;
    int next_unseen = 0;
    while (static_cast<int>(order.size()) < face_count) {
        const std::size_t begin = order.size();
        while (next_border < border.size() && seen[border[next_border]]) {
            ++next_border;
        }
        int seed;
        if (next_border < border.size()) {
            seed = border[next_border];
        } else {
            while (seen[next_unseen]) {
                ++next_unseen;
            }
            seed = next_unseen;
        }
        seen[seed] = 1;
        order.push_back(seed);
        for (std::size_t head = begin; head < order.size(); ++head) {
            for (int neighbor : dual_graph.neighbors[order[head]]) {
                if (neighbor < 0 || seen[neighbor]) {
                    continue;
                }
                if (order.size() - begin < kClusterFaces) {
                    seen[neighbor] = 1;
                    order.push_back(neighbor);
                } else {
                    border.push_back(neighbor);
                }
            }
        }
    }
    return order;
}

/// Undoes the collapses of a hierarchy and notes how the mesh is linked at some of its rounds.
/// Cells are numbered here in the order in which they appear, coarse ones first.
class LevelBuilder {
public:
    LevelBuilder(const CollapseHierarchy& hierarchy, int face_count, int thread_count)
        : hierarchy_(hierarchy), face_count_(face_count), thread_count_(thread_count) {
        number_cells();
    }

    MeshLevels build() {
        MeshLevels result;
        std::vector<std::vector<int>> orders(1, finest_order());
        result.face_at = in_faces(orders.front());
        const std::vector<int> rounds = choose_rounds();
        result.levels.resize(rounds.size());
        result.quartered_count = static_cast<int>(hierarchy_.quartered_rounds.size());
        for (std::size_t l = 1; l < rounds.size(); ++l) {
            std::vector<int>& begin = result.levels[l].begin;
            orders.push_back(
                coarser_order(orders.back(), result.levels[l - 1], cell_count(rounds[l]), begin));
            begin.push_back(face_count_);
        }
        set_base();
        int round = hierarchy_.round_count();
        for (std::size_t l = rounds.size(); l-- > 0;) {
            while (round > rounds[l]) {
                result.levels[l + 1].closes_holes |= undo(--round);
            }
            result.levels[l].sides = link(orders[l]);
            result.levels[l].hubs =
                hubs_of(result.levels[l].sides, [&](int cell) { return cells_[cell].vertex; });
            orders.pop_back();
        }
        return result;
    }

private:
    /// Where a face comes back: between its heir, which took its place, and what lies beyond. Where
    /// a hole opens again, `cell` is -1; where nothing changes, `heir` is.
    struct Insertion {
        int cell;
        int heir;
        int heir_side;
        int beyond;
        int beyond_side;
        /// The side of `cell` towards what lies beyond.
        static constexpr int kBeyond = 1;
    };

    int step_count() const { return hierarchy_.step_count(); }
    /// Cells when all steps of `round` and the later ones are undone.
    int cell_count(int round) const {
        const int step = hierarchy_.round_begin[round];
        return step == 0 ? face_count_ : cells_before_[step - 1];
    }

    void number_cells() {
        cell_of_face_.resize(face_count_);
        cells_before_.resize(step_count());
        int next = 0;
        for (int f : hierarchy_.base_faces) {
            cell_of_face_[f] = next++;
        }
        for (int step = step_count() - 1; step >= 0; --step) {
            cells_before_[step] = next;
            for (bool first : {true, false}) {
                const int face = hierarchy_.removed_face(step, first);
                if (face < face_count_) {
                    cell_of_face_[face] = next++;
                }
            }
        }
    }

    /// A cell, then what it stands for at finer levels, the latest first: so the cells that it
    /// stands for at any level follow one another.
    std::vector<int> finest_order() const {
        std::vector<int> last_child(face_count_, -1);
        std::vector<int> older_sibling(face_count_, -1);
        for (int step = step_count() - 1; step >= 0; --step) {
            for (bool first : {true, false}) {
                const int face = hierarchy_.removed_face(step, first);
                if (face < face_count_) {
                    const int cell = cell_of_face_[face];
                    const int heir = cell_of_face_[hierarchy_.heir_face(step, first)];
                    older_sibling[cell] = last_child[heir];
                    last_child[heir] = cell;
                }
            }
        }
        std::vector<int> order;
        order.reserve(face_count_);
        std::vector<int> stack(hierarchy_.base_faces.size());
        std::iota(stack.rbegin(), stack.rend(), 0);
        while (!stack.empty()) {
            const int cell = stack.back();
            stack.pop_back();
            order.push_back(cell);
            for (int next : {older_sibling[cell], last_child[cell]}) {
                if (next >= 0) {
                    stack.push_back(next);
                }
            }
        }
        return order;
    }

    std::vector<int> in_faces(const std::vector<int>& order) const {
        std::vector<int> face_of_cell(face_count_);
        for (int f = 0; f < face_count_; ++f) {
            face_of_cell[cell_of_face_[f]] = f;
        }
        std::vector<int> faces(order.size());
        std::transform(order.begin(), order.end(), faces.begin(), [&](int cell) {
            return face_of_cell[cell];
        });
        return faces;
    }

    /// From 0 on, those at which subdivisions are undone; then each the last one at which the mesh
    /// has at least kLeastShare of the cells that it has at the one before.
    std::vector<int> choose_rounds() const {
        std::vector<int> rounds(1, 0);
        rounds.insert(
            rounds.end(), hierarchy_.quartered_rounds.begin(), hierarchy_.quartered_rounds.end());
        for (int r = rounds.back() + 1; r <= hierarchy_.round_count(); ++r) {
            const bool is_next = r == hierarchy_.round_count() ||
                cell_count(r + 1) < MeshLevels::kLeastShare * cell_count(rounds.back());
            if (is_next) {
                rounds.push_back(r);
            }
        }
        return rounds;
    }

    /// The first `count` cells in the order that they have on the finer level; appends to `begin`
    /// where each begins on the finest one.
    static std::vector<int> coarser_order(const std::vector<int>& order,
                                          const Level& finer,
                                          int count,
                                          std::vector<int>& begin) {
        std::vector<int> coarser;
        coarser.reserve(count);
        begin.reserve(count + 1);
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (order[i] < count) {
                coarser.push_back(order[i]);
                begin.push_back(finer.begin_of(static_cast<int>(i)));
            }
        }
        return coarser;
    }

    void set_base() {
        TriangleMesh mesh;
        int vertex_count = 0;
        for (const Triangle& triangle : hierarchy_.base_triangles) {
            vertex_count =
                std::max(vertex_count, *std::max_element(triangle.begin(), triangle.end()) + 1);
        }
        mesh.positions.resize(vertex_count);
        mesh.faces = hierarchy_.base_triangles;
        const DualGraph graph = build_dual_graph(mesh, 1);
        cells_.reserve(face_count_);
        for (int f = 0; f < mesh.face_count(); ++f) {
            cells_.push_back({mesh.faces[f], graph.neighbors[f]});
        }
    }

    /// The stars of a round share no face, so that its steps can be undone at the same time.
    /// Returns whether a hole opens.
    bool undo(int round) {
        const int begin = hierarchy_.round_begin[round];
        const int count = hierarchy_.round_begin[round + 1] - begin;
        const int threads = threads_for(thread_count_, count, kStepsPerThread);
        insertions_.resize(2 * static_cast<std::size_t>(count));
        cells_.resize(cell_count(round));
#pragma omp parallel num_threads(threads)
        {
#pragma omp for schedule(static)
            for (int i = 0; i < count; ++i) {
                find_place(begin + i, true, insertions_[2 * i]);
                find_place(begin + i, false, insertions_[2 * i + 1]);
            }
#pragma omp for schedule(static)
            for (int i = 0; i < count; ++i) {
                insert(begin + i, insertions_[2 * i], insertions_[2 * i + 1]);
            }
#pragma omp for schedule(static)
            for (int i = 0; i < 2 * count; ++i) {
                link_beyond(insertions_[i]);
            }
        }
        return std::any_of(insertions_.begin(), insertions_.end(), [](const Insertion& insertion) {
            return insertion.heir >= 0 && insertion.cell < 0;
        });
    }

    void find_place(int step, bool first, Insertion& insertion) const {
        const int face = hierarchy_.removed_face(step, first);
        const int heir_of_face = hierarchy_.heir_face(step, first);
        insertion.cell = face < face_count_ ? cell_of_face_[face] : -1;
        insertion.heir = heir_of_face < face_count_ ? cell_of_face_[heir_of_face] : -1;
        if (insertion.heir < 0) {
            return;
        }
        const int target = hierarchy_.target[step];
        const LinkedTriangle& heir = cells_[insertion.heir];
        const int corner = heir.corner(target);
        insertion.heir_side = first ? corner : previous_corner(corner);
        insertion.beyond = heir.neighbor[insertion.heir_side];
        if (insertion.beyond >= 0) {
            // There the shared edge runs the other way: from the rim, or from the target.
            insertion.beyond_side =
                cells_[insertion.beyond].corner(first ? rim(step, first) : target);
        }
    }

    /// The vertex of the first or the last face of a star that is neither removed nor the target.
    int rim(int step, bool first) const {
        return hierarchy_.ring(step)[first ? 1 : hierarchy_.degree(step) - 1];
    }

    void insert(int step, const Insertion& first, const Insertion& last) {
        const int vertex = hierarchy_.vertex[step];
        const int target = hierarchy_.target[step];
        for (const Insertion& insertion : {first, last}) {
            if (insertion.heir >= 0) {
                cells_[insertion.heir].neighbor[insertion.heir_side] = insertion.cell;
            }
        }
        if (first.cell >= 0) {
            cells_[first.cell] = {{vertex, target, rim(step, true)},
                                  {last.cell, first.beyond, first.heir}};
        }
        if (last.cell >= 0) {
            cells_[last.cell] = {{vertex, rim(step, false), target},
                                 {last.heir, last.beyond, first.cell}};
        }
        for (int i = 1; i + 1 < hierarchy_.degree(step); ++i) {
            const int face = hierarchy_.star(step)[i];
            if (face < face_count_) {
                LinkedTriangle& cell = cells_[cell_of_face_[face]];
                cell.vertex[cell.corner(target)] = vertex;
            }
        }
    }

    /// What lies beyond learns of the face; unless there, too, a face came back at the same edge:
    /// then that one lies beyond.
    void link_beyond(const Insertion& insertion) {
        if (insertion.heir < 0 || insertion.beyond < 0) {
            return;
        }
        int& side = cells_[insertion.beyond].neighbor[insertion.beyond_side];
        if (side == insertion.heir) {
            side = insertion.cell;
        } else if (insertion.cell >= 0) {
            cells_[insertion.cell].neighbor[Insertion::kBeyond] = side;
        }
    }

    std::vector<std::array<NeighborSide, 3>> link(const std::vector<int>& order) const {
        const auto count = static_cast<int>(order.size());
        const std::vector<int> place = inverse(order, cells_.size());
        std::vector<std::array<NeighborSide, 3>> sides(count);
        const auto triangle_of = [this](int cell) { return cells_[cell]; };
        const int threads = threads_for(thread_count_, count, kFacesPerThread);
        for_each_share(count, threads, [&](int begin, int end) {
            for (int i = begin; i < end; ++i) {
                sides[i] = sides_of(cells_[order[i]], triangle_of, place);
            }
        });
        return sides;
    }

    const CollapseHierarchy& hierarchy_;
    const int face_count_;
    const int thread_count_;
    std::vector<int> cell_of_face_;
    /// Number of cells before each step is undone; falls with the steps.
    std::vector<int> cells_before_;
    std::vector<LinkedTriangle> cells_;
    std::vector<Insertion> insertions_;
};

} // namespace

int Level::first_cell_from(int finest) const {
    return begin.empty()
        ? finest
        : static_cast<int>(std::lower_bound(begin.begin(), begin.end(), finest) - begin.begin());
}

MeshLevels build_levels(const CollapseHierarchy& hierarchy, int face_count, int thread_count) {
    return LevelBuilder(hierarchy, face_count, thread_count).build();
}

MeshLevels
build_finest_level(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count) {
    MeshLevels result;
    result.face_at = order_by_clusters(dual_graph);
    result.levels.resize(1);
    const int face_count = mesh.face_count();
    std::vector<std::array<NeighborSide, 3>>& sides = result.levels.front().sides;
    sides.resize(face_count);
    const std::vector<int> place = inverse(result.face_at, result.face_at.size());
    const auto triangle_of = [&](int face) {
        return LinkedTriangle{mesh.faces[face], dual_graph.neighbors[face]};
    };
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
    for_each_share(face_count, threads, [&](int begin, int end) {
        for (int i = begin; i < end; ++i) {
            sides[i] = sides_of(triangle_of(result.face_at[i]), triangle_of, place);
        }
    });
    result.levels.front().hubs = hubs_of(sides, [&](int face) { return mesh.faces[face]; });
    return result;
}

} // namespace spheroseg
