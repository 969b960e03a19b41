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
    explicit Groups(int count) : group_(count) { std::iota(group_.begin(), group_.end(), 0); }
    void join(int a, int b) {
        const int from = group_[a];
        const int to = group_[b];
        std::replace(group_.begin(), group_.end(), from, to);
    }
    int of(int member) const { return group_[member]; }

private:
    std::vector<int> group_;
};

bool names_twice(const Triangle& t) {
    return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

} // namespace

Surface::Surface(const TriangleMesh& mesh) : mesh_(mesh) {
    join_sides();
    count_components();
    examine();
}

void Surface::join_sides() {
    std::map<std::pair<int, int>, std::vector<int>> sides;
    for (int f = 0; f < mesh_.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            const auto ends = std::minmax(mesh_.faces[f][c], mesh_.faces[f][(c + 1) % 3]);
            sides[{ends.first, ends.second}].push_back(f);
        }
    }
    for (const auto& [ends, of_edge] : sides) {
        if (of_edge.size() == 2 && of_edge[0] != of_edge[1]) {
            shared_.push_back({{of_edge[0], of_edge[1]}, {ends.first, ends.second}});
        } else {
            has_unjoined_pair_ = has_unjoined_pair_ || of_edge.size() > 1;
        }
    }
}

void Surface::count_components() {
    Groups groups(mesh_.face_count());
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

void Surface::examine() {
    is_manifold_ = mesh_.face_count() > 0 && !has_unjoined_pair_;
    for (const Triangle& t : mesh_.faces) {
        is_manifold_ = is_manifold_ && !names_twice(t);
        for (int v : t) {
            const Vec3& p = mesh_.positions[v];
            is_manifold_ = is_manifold_ && std::isfinite(p.x + p.y + p.z);
        }
    }
}

/// Fans of the sub-mesh over all its vertices; `vertex_count`: how many these are, where each fan
/// of the whole surface counts as a vertex of its own.
int Surface::count_fans(const std::vector<int>& labels, int label, int* vertex_count) const {
    std::map<int, std::vector<int>> faces_of_vertex;
    for (int f = 0; f < mesh_.face_count(); ++f) {
        for (int v : mesh_.faces[f]) {
            faces_of_vertex[v].push_back(f);
        }
    }
    std::map<int, std::vector<const SharedEdge*>> edges_of_vertex;
    for (const SharedEdge& edge : shared_) {
        edges_of_vertex[edge.vertices[0]].push_back(&edge);
        edges_of_vertex[edge.vertices[1]].push_back(&edge);
    }
    int fans = 0;
    *vertex_count = 0;
    for (const auto& [vertex, faces] : faces_of_vertex) {
        const auto place = [&, &around = faces](int face) {
            return static_cast<int>(std::find(around.begin(), around.end(), face) - around.begin());
        };
        Groups of_surface(static_cast<int>(faces.size()));
        Groups of_label(static_cast<int>(faces.size()));
        for (const SharedEdge* edge : edges_of_vertex[vertex]) {
            const int a = edge->faces[0];
            const int b = edge->faces[1];
            of_surface.join(place(a), place(b));
            if (labels[a] == label && labels[b] == label) {
                of_label.join(place(a), place(b));
            }
        }
        std::set<int> surface_fans;
        std::set<int> label_fans;
        for (int face : faces) {
            if (labels[face] == label) {
                surface_fans.insert(of_surface.of(place(face)));
                label_fans.insert(of_label.of(place(face)));
            }
        }
        *vertex_count += static_cast<int>(surface_fans.size());
        fans += static_cast<int>(label_fans.size());
    }
    return fans;
}

int Surface::count_pieces(const std::vector<int>& labels, int label) const {
    std::vector<int> place(mesh_.faces.size(), -1);
    int count = 0;
    for (std::size_t f = 0; f < labels.size(); ++f) {
        place[f] = labels[f] == label ? count++ : -1;
    }
    Groups groups(count);
    for (const SharedEdge& edge : shared_) {
        if (labels[edge.faces[0]] == label && labels[edge.faces[1]] == label) {
            groups.join(place[edge.faces[0]], place[edge.faces[1]]);
        }
    }
    std::set<int> different;
    for (int i = 0; i < count; ++i) {
        different.insert(groups.of(i));
    }
    return static_cast<int>(different.size());
}

/// For a connected sub-mesh without bowties: Euler characteristic 1 and a boundary.
bool Surface::is_disk(const std::vector<int>& labels, int label) const {
    std::map<std::pair<int, int>, int> sides;
    int triangles = 0;
    for (int f = 0; f < mesh_.face_count(); ++f) {
        if (labels[f] == label) {
            ++triangles;
            for (int c = 0; c < 3; ++c) {
                const auto ends = std::minmax(mesh_.faces[f][c], mesh_.faces[f][(c + 1) % 3]);
                ++sides[{ends.first, ends.second}];
            }
        }
    }
    const bool has_boundary =
        std::any_of(sides.begin(), sides.end(), [](const auto& side) { return side.second == 1; });
    int vertices = 0;
    count_fans(labels, label, &vertices);
    return has_boundary && vertices - static_cast<int>(sides.size()) + triangles == 1;
}

Recount Surface::recount(const std::vector<int>& labels, int submesh_count) const {
    Recount result;
    for (const SharedEdge& edge : shared_) {
        result.boundary_edge_count += labels[edge.faces[0]] != labels[edge.faces[1]];
    }
    for (int l = 0; l < submesh_count; ++l) {
        result.triangle_counts.push_back(
            static_cast<int>(std::count(labels.begin(), labels.end(), l)));
        int vertices = 0;
        const int bowties = count_fans(labels, l, &vertices) - vertices;
        const int pieces = count_pieces(labels, l);
        result.bowtie_count += bowties;
        result.disconnected_submesh_count += pieces > 1;
        result.empty_submesh_count += pieces == 0;
        result.disk_count += pieces == 1 && bowties == 0 && is_disk(labels, l);
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
    const int face_count = mesh_.face_count();
    for (int difference = 0; difference < face_count; ++difference) {
        for (int least = 1; least * submesh_count <= face_count; ++least) {
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
    return face_count;
}

/// Labels the faces from `face` on in every way; a new label is always the next unused one.
bool Surface::place(std::vector<int>& labels,
                    std::vector<int>& counts,
                    int face,
                    int used,
                    int count_difference) const {
    const int submesh_count = static_cast<int>(counts.size());
    const int face_count = mesh_.face_count();
    if (submesh_count - used > face_count - face) {
        return false;
    }
    if (face == face_count) {
        const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
        if (*most - *least > count_difference) {
            return false;
        }
        for (int l = 0; l < submesh_count; ++l) {
            int vertices = 0;
            if (count_pieces(labels, l) != 1 || count_fans(labels, l, &vertices) != vertices) {
                return false;
            }
        }
        return true;
    }
    const int ceiling =
        (face_count + submesh_count - 1) / submesh_count + (count_difference > 1 ? face_count : 0);
    for (int l = 0; l < std::min(used + 1, submesh_count); ++l) {
        if (counts[l] < ceiling) {
            labels[face] = l;
            ++counts[l];
            if (place(labels, counts, face + 1, std::max(used, l + 1), count_difference)) {
                return true;
            }
            --counts[l];
        }
    }
    return false;
}

bool Surface::can_be_cut(int submesh_count, int count_difference) const {
    std::vector<int> labels(mesh_.faces.size(), 0);
    std::vector<int> counts(submesh_count, 0);
    return place(labels, counts, 0, 0, count_difference);
}

} // namespace spheroseg::fuzz
