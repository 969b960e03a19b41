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
        is_done_.assign(sides_.size(), 0);
        place_of_.assign(mesh_.vertices.size(), -1);
        for (int i = 0; i < static_cast<int>(sides_.size()); ++i) {
            close_from(i);
        }
    }

private:
    /// Side `corner` of a face, on the border; it leads from one vertex to another.
    struct Side {
        int face;
        int corner;
        int from;
        int to;
    };

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
            sides_.begin(), sides_.end(), std::make_pair(face, corner), [](const Side& s, auto at) {
                return std::make_pair(s.face, s.corner) < at;
            });
        return static_cast<int>(side - sides_.begin());
    }

    /// The side at which the fan of a vertex ends that begins with this side; -1 where faces of the
    /// fan are oriented differently.
    int end_of_fan(const Side& begin) const {
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
        next_.assign(sides_.size(), -1);
        std::vector<int> order(sides_.size());
        std::iota(order.begin(), order.end(), 0);
        const auto begin_of = [&](int i) { return sides_[i].from; };
        std::stable_sort(
            order.begin(), order.end(), [&](int i, int j) { return begin_of(i) < begin_of(j); });
        for (auto first = order.begin(); first != order.end();) {
            const auto end = std::find_if(
                first, order.end(), [&](int i) { return begin_of(i) != begin_of(*first); });
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
                next_[ends[i]] = begins[(i + 1) % begins.size()];
            }
        }
    }

    /// Follows the border from this side on, and closes it where it meets itself.
    void close_from(int first) {
        for (int i = first; i >= 0 && !is_done_[i]; i = next_[i]) {
            is_done_[i] = 1;
            place_of_[sides_[i].from] = static_cast<int>(path_.size());
            path_.push_back(i);
            const int place = place_of_[sides_[i].to];
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
            place_of_[sides_[path_.back()].from] = -1;
        }
    }

    void cap() {
        if (loop_.size() == 3) {
            cap_by_triangle();
        } else if (loop_.size() > 3) {
            cap_by_fan();
        }
    }

    void cap_by_triangle() {
        const auto cap = static_cast<int>(mesh_.faces.size());
        const Side& a = sides_[loop_[0]];
        const Side& b = sides_[loop_[1]];
        const Side& c = sides_[loop_[2]];
        mesh_.faces.push_back({{a.to, a.from, c.from}, {a.face, c.face, b.face}, 0, -1});
        for (const Side& side : {a, b, c}) {
            mesh_.faces[side.face].neighbors[side.corner] = cap;
            mesh_.vertices[side.from].degree += 1;
        }
    }

    void cap_by_fan() {
        const auto count = static_cast<int>(loop_.size());
        const auto first = static_cast<int>(mesh_.faces.size());
        const auto center = static_cast<int>(mesh_.vertices.size());
        mesh_.vertices.push_back({first, count, 0, -1});
        for (int i = 0; i < count; ++i) {
            const Side& side = sides_[loop_[i]];
            mesh_.faces.push_back(
                {{side.to, side.from, center},
                 {side.face, first + (i + count - 1) % count, first + (i + 1) % count},
                 0,
                 -1});
            mesh_.faces[side.face].neighbors[side.corner] = first + i;
            mesh_.vertices[side.from].degree += 2;
        }
    }

    CollapseMesh& mesh_;
    std::vector<Side> sides_;
    /// How the border goes on after each side; -1: unclear.
    std::vector<int> next_;
    std::vector<char> is_done_;
    std::vector<int> path_;
    /// Of each vertex, the place of the side of the path that begins there.
    std::vector<int> place_of_;
    std::vector<int> loop_;
};

} // namespace

void close_holes(CollapseMesh& mesh) {
    Capper(mesh).run();
}

} // namespace spheroseg
