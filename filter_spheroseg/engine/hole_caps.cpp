// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_caps.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace spheroseg {

namespace {

class Capper {
public:
    explicit Capper(CollapseMesh& mesh) : mesh_(mesh) {}

    void run() {
        list_border();
        if (sides_.empty()) {
            return;
        }
        join_fans();
        join_turned_fans();
        is_done_.assign(sides_.size(), 0);
        place_of_.assign(mesh_.vertices.size(), -1);
        for (int i = 0; i < static_cast<int>(sides_.size()); ++i) {
            close_from(2 * i);
        }
    }

private:
    /// Side `corner` of a face, on the border; it leads from one vertex to another.
    struct BorderSide {
        int face;
        int corner;
        int from;
        int to;
    };

    /// A way is a directed border side: side way / 2 in the direction of its face where `way` is
    /// even, against it where odd. way ^ 1 is the same side in the other direction.
    const BorderSide& side_of(int way) const { return sides_[way / 2]; }
    int begin_of(int way) const { return way % 2 ? side_of(way).to : side_of(way).from; }
    int end_of(int way) const { return begin_of(way ^ 1); }

    void list_border() {
        const auto face_count = static_cast<int>(mesh_.faces.size());
        for (int f = 0; f < face_count; ++f) {
            const CollapseMesh::Face& face = mesh_.faces[f];
            for (int c = 0; c < 3; ++c) {
                if (face.neighbors[c] < 0) {
                    sides_.push_back({f, c, face.vertices[c], face.vertices[(c + 1) % 3]});
                }
            }
        }
    }

    int side_at(int face, int corner) const {
        const auto side = std::lower_bound(
            sides_.begin(),
            sides_.end(),
            std::make_pair(face, corner),
            [](const BorderSide& s, auto at) { return std::make_pair(s.face, s.corner) < at; });
        return static_cast<int>(side - sides_.begin());
    }

    /// The border side at the other end of the fan around begin.from; -1 where faces of the fan are
    /// oriented differently.
    int end_of_fan(const BorderSide& begin) const {
        int f = begin.face;
        int corner = begin.corner;
        for (;;) {
            const int across = (corner + 2) % 3;
            const int g = mesh_.faces[f].neighbors[across];
            if (g < 0) {
                return side_at(f, across);
            }
            corner = mesh_.corner_of(g, begin.from);
            if (mesh_.faces[g].vertices[(corner + 1) % 3] != mesh_.faces[f].vertices[across]) {
                return -1;
            }
            f = g;
        }
    }

    void join_fans() {
        next_.assign(2 * sides_.size(), -1);
        std::vector<int> order(sides_.size());
        std::iota(order.begin(), order.end(), 0);
        const auto vertex_of = [&](int i) { return sides_[i].from; };
        std::stable_sort(
            order.begin(), order.end(), [&](int i, int j) { return vertex_of(i) < vertex_of(j); });
        for (auto first = order.begin(); first != order.end();) {
            const auto end = std::find_if(
                first, order.end(), [&](int i) { return vertex_of(i) != vertex_of(*first); });
            join_fans_that_begin({first, end});
            first = end;
        }
    }

    /// `begins`: the sides at which the fans of a vertex begin. Fans that meet at an edge with more
    /// than two faces stay apart: together they would have a neighbour twice.
    void join_fans_that_begin(const std::vector<int>& begins) {
        std::vector<int> ends;
        std::vector<int> neighbors;
        for (int begin : begins) {
            ends.push_back(end_of_fan(sides_[begin]));
            neighbors.push_back(sides_[begin].to);
            if (ends.back() >= 0) {
                neighbors.push_back(sides_[ends.back()].from);
            }
        }
        std::sort(neighbors.begin(), neighbors.end());
        if (std::adjacent_find(neighbors.begin(), neighbors.end()) != neighbors.end()) {
            return;
        }
        for (std::size_t i = 0; i < ends.size(); ++i) {
            if (ends[i] >= 0) {
                join(2 * ends[i], 2 * begins[(i + 1) % begins.size()]);
            }
        }
    }

    void join(int way, int next) {
        next_[way] = next;
        next_[next ^ 1] = way ^ 1;
    }

    /// Joins the two border sides of a vertex whose only fan has faces that are oriented
    /// differently, as at the seam of a Moebius band: the border mostly goes on against the
    /// direction of the next face. Such a vertex, and the middle of its cap, are never removed.
    void join_turned_fans() {
        std::vector<int> end_counts(mesh_.vertices.size(), 0);
        for (const BorderSide& side : sides_) {
            ++end_counts[side.from];
            ++end_counts[side.to];
        }
        for (int way = 0; way < static_cast<int>(next_.size()); ++way) {
            if (next_[way] < 0 && end_counts[end_of(way)] == 2) {
                const int next = across_fan(way);
                if (begin_of(way) != end_of(next)) {
                    join(way, next);
                }
            }
        }
    }

    /// The way that follows this one across the fan at its end, however the faces of that fan are
    /// oriented.
    int across_fan(int way) const {
        const int v = end_of(way);
        int f = side_of(way).face;
        int corner = side_of(way).corner;
        for (;;) {
            const int at = mesh_.corner_of(f, v);
            // Of the two sides of the face at the vertex, the one that the walk did not enter by.
            corner = corner == at ? (at + 2) % 3 : at;
            const int g = mesh_.faces[f].neighbors[corner];
            if (g < 0) {
                return 2 * side_at(f, corner) + (corner != at);
            }
            const Triangle& vertices = mesh_.faces[f].vertices;
            const int u = vertices[corner == at ? (at + 1) % 3 : corner];
            const int at_v = mesh_.corner_of(g, v);
            corner = mesh_.faces[g].vertices[(at_v + 1) % 3] == u ? at_v : (at_v + 2) % 3;
            f = g;
        }
    }

    /// Follows the border from here on, and closes it where it meets itself.
    void close_from(int first) {
        for (int way = first; way >= 0 && !is_done_[way / 2]; way = next_[way]) {
            is_done_[way / 2] = 1;
            place_of_[begin_of(way)] = static_cast<int>(path_.size());
            path_.push_back(way);
            const int place = place_of_[end_of(way)];
            if (place >= 0) {
                loop_.assign(path_.begin() + place, path_.end());
                drop_path(place);
                cap();
            }
        }
        drop_path(0);
    }

    void drop_path(int length) {
        for (; static_cast<int>(path_.size()) > length; path_.pop_back()) {
            place_of_[begin_of(path_.back())] = -1;
        }
    }

    void cap() {
        if (loop_.size() == 3) {
            cap_by_triangle();
        } else if (loop_.size() > 3) {
            cap_by_fan();
        }
    }

    /// A face of a cap at this way, with a third vertex and the faces before and after it.
    CollapseMesh::Face cap_face(int way, int third, int before, int after) const {
        const BorderSide& side = side_of(way);
        if (way % 2) {
            std::swap(before, after);
        }
        return {{side.to, side.from, third}, {side.face, before, after}, 0, -1};
    }

    void cap_by_triangle() {
        const auto cap = static_cast<int>(mesh_.faces.size());
        mesh_.faces.push_back(
            cap_face(loop_[0], begin_of(loop_[2]), side_of(loop_[2]).face, side_of(loop_[1]).face));
        for (int way : loop_) {
            mesh_.faces[side_of(way).face].neighbors[side_of(way).corner] = cap;
            mesh_.vertices[begin_of(way)].degree += 1;
        }
    }

    void cap_by_fan() {
        const auto count = static_cast<int>(loop_.size());
        const auto first = static_cast<int>(mesh_.faces.size());
        const auto center = static_cast<int>(mesh_.vertices.size());
        mesh_.vertices.push_back({first, count, 0, -1});
        for (int i = 0; i < count; ++i) {
            const int way = loop_[i];
            mesh_.faces.push_back(
                cap_face(way, center, first + (i + count - 1) % count, first + (i + 1) % count));
            mesh_.faces[side_of(way).face].neighbors[side_of(way).corner] = first + i;
            mesh_.vertices[begin_of(way)].degree += 2;
        }
    }

    CollapseMesh& mesh_;
    std::vector<BorderSide> sides_;
    /// How the border goes on after each way; -1: unclear.
    std::vector<int> next_;
    std::vector<char> is_done_;
    std::vector<int> path_;
    /// Of each vertex, the place of the way of the path that begins there.
    std::vector<int> place_of_;
    std::vector<int> loop_;
};

} // namespace

void close_holes(CollapseMesh& mesh) {
    Capper(mesh).run();
}

} // namespace spheroseg
