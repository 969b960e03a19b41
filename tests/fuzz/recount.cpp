// SPDX-License-Identifier: GPL-3.0-or-later
#include "recount.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

namespace spheroseg::fuzz {

namespace {

/// Sets of numbers that are joined pair by pair.
class Groups {
public:
    explicit Groups(std::size_t count) : group_(count) {
        std::iota(group_.begin(), group_.end(), 0);
    }
    void join(int a, int b) { group_[of(a)] = of(b); }
    /// The member that stands for the group.
    int of(int member) {
        while (group_[member] != member) {
            group_[member] = group_[group_[member]];
            member = group_[member];
        }
        return member;
    }
    int count() const {
        int groups = 0;
        for (std::size_t i = 0; i < group_.size(); ++i) {
            groups += group_[i] == static_cast<int>(i);
        }
        return groups;
    }

private:
    std::vector<int> group_;
};

using Edge = std::pair<int, int>;

Edge edge_of(const Triangle& t, int corner) {
    return std::minmax(t[corner], t[(corner + 1) % 3]);
}

int corner_of(const Triangle& t, int vertex) {
    return static_cast<int>(std::find(t.begin(), t.end(), vertex) - t.begin());
}

} // namespace

Surface::Surface(const TriangleMesh& mesh) : mesh_(mesh), shared_of_face_(mesh.faces.size()) {
    join_sides();
    count_components();
    split_pinches();
    examine();
}

void Surface::join_sides() {
    struct Side {
        int face;
        int start;
    };
    std::map<Edge, std::vector<Side>> sides;
    for (int f = 0; f < mesh_.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            sides[edge_of(mesh_.faces[f], c)].push_back({f, mesh_.faces[f][c]});
        }
    }
    edge_count_ = static_cast<int>(sides.size());
    for (const auto& [ends, of_edge] : sides) {
        is_clean_ = is_clean_ && of_edge.size() <= 2;
        is_closed_ = is_closed_ && of_edge.size() == 2;
        if (of_edge.size() == 2 && of_edge[0].face != of_edge[1].face) {
            is_oriented_ = is_oriented_ && of_edge[0].start != of_edge[1].start;
            for (const Side& side : of_edge) {
                shared_of_face_[side.face].push_back(static_cast<int>(shared_.size()));
            }
            shared_.push_back({{of_edge[0].face, of_edge[1].face}, {ends.first, ends.second}});
        }
    }
}

void Surface::count_components() {
    Groups groups(mesh_.faces.size());
    for (const SharedEdge& edge : shared_) {
        groups.join(edge.faces[0], edge.faces[1]);
    }
    std::map<int, int> sizes;
    for (int f = 0; f < mesh_.face_count(); ++f) {
        ++sizes[groups.of(f)];
    }
    for (const auto& [group, size] : sizes) {
        component_sizes_.push_back(size);
    }
}

void Surface::split_pinches() {
    Groups groups(3 * mesh_.faces.size());
    for (const SharedEdge& edge : shared_) {
        for (int v : edge.vertices) {
            groups.join(3 * edge.faces[0] + corner_of(mesh_.faces[edge.faces[0]], v),
                        3 * edge.faces[1] + corner_of(mesh_.faces[edge.faces[1]], v));
        }
    }
    std::set<int> vertices;
    std::set<int> split_vertices;
    for (int f = 0; f < mesh_.face_count(); ++f) {
        corners_.push_back({groups.of(3 * f), groups.of(3 * f + 1), groups.of(3 * f + 2)});
        vertices.insert(mesh_.faces[f].begin(), mesh_.faces[f].end());
        split_vertices.insert(corners_[f].begin(), corners_[f].end());
    }
    is_pinched_ = split_vertices.size() != vertices.size();
    is_sphere_ = static_cast<int>(vertices.size()) - edge_count_ + mesh_.face_count() == 2;
}

void Surface::examine() {
    std::set<Triangle> seen;
    bool has_twins = false;
    for (Triangle t : mesh_.faces) {
        is_clean_ = is_clean_ && t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        for (int v : t) {
            const Vec3& p = mesh_.positions[v];
            is_clean_ = is_clean_ && std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
        }
        std::sort(t.begin(), t.end());
        has_twins = has_twins || !seen.insert(t).second;
    }
    is_clean_ = is_clean_ && !mesh_.faces.empty();
    is_sphere_ = is_sphere_ && is_clean_ && is_closed_ && is_oriented_ && !is_pinched_ &&
        !has_twins && component_sizes_.size() == 1;
}

int Surface::count_bowties(const std::vector<int>& faces) const {
    const std::set<int> members(faces.begin(), faces.end());
    std::map<int, std::vector<int>> faces_of_vertex;
    for (int f : faces) {
        for (int v : corners_[f]) {
            faces_of_vertex[v].push_back(f);
        }
    }
    int bowties = 0;
    for (const auto& [vertex, around] : faces_of_vertex) {
        const auto place = [&, &around = around](int face) {
            return static_cast<int>(std::find(around.begin(), around.end(), face) - around.begin());
        };
        Groups groups(around.size());
        for (int f : around) {
            for (int e : shared_of_face_[f]) {
                const SharedEdge& edge = shared_[e];
                const int other = edge.faces[0] == f ? edge.faces[1] : edge.faces[0];
                for (int v : edge.vertices) {
                    if (corners_[f][corner_of(mesh_.faces[f], v)] == vertex &&
                        members.count(other) > 0) {
                        groups.join(place(f), place(other));
                    }
                }
            }
        }
        bowties += groups.count() - 1;
    }
    return bowties;
}

int Surface::count_pieces(const std::vector<int>& labels, int label) const {
    std::vector<int> place(labels.size(), -1);
    int count = 0;
    for (std::size_t f = 0; f < labels.size(); ++f) {
        place[f] = labels[f] == label ? count++ : -1;
    }
    Groups groups(static_cast<std::size_t>(count));
    for (const SharedEdge& edge : shared_) {
        if (labels[edge.faces[0]] == label && labels[edge.faces[1]] == label) {
            groups.join(place[edge.faces[0]], place[edge.faces[1]]);
        }
    }
    return groups.count();
}

/// For connected faces without bowties: Euler characteristic 1 and one boundary loop.
bool Surface::is_disk(const std::vector<int>& faces) const {
    std::set<int> vertices;
    std::map<Edge, int> sides;
    for (int f : faces) {
        vertices.insert(corners_[f].begin(), corners_[f].end());
        for (int c = 0; c < 3; ++c) {
            ++sides[edge_of(corners_[f], c)];
        }
    }
    std::map<int, int> place;
    std::vector<Edge> rim;
    for (const auto& [ends, count] : sides) {
        if (count == 1) {
            rim.push_back(ends);
            place.emplace(ends.first, static_cast<int>(place.size()));
            place.emplace(ends.second, static_cast<int>(place.size()));
        }
    }
    Groups loops(place.size());
    for (const auto& [a, b] : rim) {
        loops.join(place[a], place[b]);
    }
    return loops.count() == 1 &&
        static_cast<int>(vertices.size()) - static_cast<int>(sides.size()) +
            static_cast<int>(faces.size()) ==
        1;
}

Recount Surface::recount(const std::vector<int>& labels, int submesh_count) const {
    Recount result;
    for (const SharedEdge& edge : shared_) {
        result.boundary_edge_count += labels[edge.faces[0]] != labels[edge.faces[1]];
    }
    for (int l = 0; l < submesh_count; ++l) {
        std::vector<int> faces;
        for (int f = 0; f < face_count(); ++f) {
            if (labels[f] == l) {
                faces.push_back(f);
            }
        }
        const int bowties = count_bowties(faces);
        const int pieces = count_pieces(labels, l);
        result.triangle_counts.push_back(static_cast<int>(faces.size()));
        result.bowtie_count += bowties;
        result.disconnected_submesh_count += pieces > 1;
        result.empty_submesh_count += pieces == 0;
        result.disk_count += pieces == 1 && bowties == 0 && is_disk(faces);
    }
    const auto [least, most] =
        std::minmax_element(result.triangle_counts.begin(), result.triangle_counts.end());
    result.max_triangle_count_difference = *most - *least;
    return result;
}

int Surface::least_count_difference(int submesh_count) const {
    if (static_cast<int>(component_sizes_.size()) > submesh_count) {
        return -1;
    }
    for (int difference = 0; difference < face_count(); ++difference) {
        for (int least = 1; least * submesh_count <= face_count(); ++least) {
            // A component of s faces can be cut into n chains of `least` to `most` faces when
            // n * least <= s <= n * most.
            const int most = least + difference;
            int fewest = 0;
            int greatest = 0;
            bool possible = true;
            for (int size : component_sizes_) {
                const int from = (size + most - 1) / most;
                const int to = size / least;
                possible = possible && from <= to;
                fewest += from;
                greatest += to;
            }
            if (possible && fewest <= submesh_count && submesh_count <= greatest) {
                return difference;
            }
        }
    }
    return face_count();
}

} // namespace spheroseg::fuzz
