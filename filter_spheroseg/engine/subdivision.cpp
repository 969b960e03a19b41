// SPDX-License-Identifier: GPL-3.0-or-later
#include "subdivision.h"

#include <algorithm>
#include <cstdint>

namespace spheroseg {

namespace {

/// What a face is of the triangle that it was split from: the corner at its vertex 0, 1 or 2, or
/// the middle.
enum Role : std::int8_t { unknown = -1, middle = 3 };

class Finder {
public:
    explicit Finder(const CollapseMesh& mesh) : mesh_(mesh) {}

    /// True where all of the `face_count` faces have roles that fit each other when `seed` has this
    /// one.
    bool assign_from(int seed, int role, int face_count) {
        role_.assign(mesh_.first_cap_face, unknown);
        faces_.assign(1, seed);
        role_[seed] = static_cast<std::int8_t>(role);
        for (std::size_t head = 0; head < faces_.size(); ++head) {
            for (int side = 0; side < 3; ++side) {
                if (!assign_beyond(faces_[head], side)) {
                    return false;
                }
            }
        }
        return static_cast<int>(faces_.size()) == face_count;
    }

    /// Empty where some vertex does not lie on one edge.
    std::vector<std::array<int, 2>> ends(const std::vector<int>& live_vertices) const {
        std::vector<std::array<int, 2>> ends(mesh_.vertices.size(), {-1, -1});
        std::vector<char> is_old(mesh_.vertices.size(), 0);
        for (int f : faces_) {
            const int corner = role_[f];
            if (corner == middle) {
                continue;
            }
            const Triangle& t = mesh_.faces[f].vertices;
            is_old[t[corner]] = 1;
            for (int v : {t[(corner + 1) % 3], t[(corner + 2) % 3]}) {
                std::array<int, 2>& of_edge = ends[v];
                const auto place = std::find_if(of_edge.begin(), of_edge.end(), [&](int old) {
                    return old < 0 || old == t[corner];
                });
                if (place == of_edge.end()) {
                    return {};
                }
                *place = t[corner];
            }
        }
        // A vertex of the old mesh has no ends; one on the border of a corner only has one.
        const bool fits = std::all_of(live_vertices.begin(), live_vertices.end(), [&](int v) {
            return v >= mesh_.first_cap_vertex || is_old[v] != (ends[v][1] >= 0);
        });
        return fits ? ends : std::vector<std::array<int, 2>>();
    }

private:
    /// True where the face beyond this side of `f`, if any, has the role that follows.
    bool assign_beyond(int f, int side) {
        const int role = role_[f];
        // Between new vertices, both faces are of one old triangle.
        const bool is_inside = role == middle || side == (role + 1) % 3;
        const int g = mesh_.faces[f].neighbors[side];
        if (g < 0 || g >= mesh_.first_cap_face) {
            return !is_inside;
        }
        const Triangle& t = mesh_.faces[f].vertices;
        int wanted = middle;
        if (role == middle) {
            const int begin = mesh_.corner_of(g, t[side]);
            const int end = mesh_.corner_of(g, t[(side + 1) % 3]);
            wanted = 3 - begin - end;
        } else if (!is_inside) {
            wanted = mesh_.corner_of(g, t[role]);
        }
        if (role_[g] == unknown) {
            role_[g] = static_cast<std::int8_t>(wanted);
            faces_.push_back(g);
        }
        return role_[g] == wanted;
    }

    const CollapseMesh& mesh_;
    /// Of each face of the mesh.
    std::vector<std::int8_t> role_;
    /// Those that have a role.
    std::vector<int> faces_;
};

/// May a subdivision have put the vertex on an edge, from the number of its faces?
bool may_be_new(const CollapseMesh& mesh, int v) {
    int faces = 0;
    bool on_border = false;
    mesh.for_each_in_star(v, [&](int f, int) {
        on_border |= f >= mesh.first_cap_face;
        faces += f < mesh.first_cap_face;
        return true;
    });
    return faces == (on_border ? 3 : 6);
}

} // namespace

std::vector<std::array<int, 2>> find_subdivision(const CollapseMesh& mesh,
                                                 const std::vector<int>& live_faces,
                                                 const std::vector<int>& live_vertices) {
    const int face_count = mesh.count_mesh_faces(live_faces);
    if (face_count == 0 || face_count % 4 != 0) {
        return {};
    }
    Finder finder(mesh);
    const auto old = std::find_if(live_vertices.begin(), live_vertices.end(), [&](int v) {
        return v < mesh.first_cap_vertex && !mesh.is_fixed[v] && !may_be_new(mesh, v);
    });
    // Where all vertices are regular, as on some tori, the first face may be anything.
    int seed = live_faces.front();
    int first_role = 0;
    int last_role = middle;
    if (old != live_vertices.end()) {
        mesh.for_each_in_star(*old, [&](int f, int) {
            seed = f;
            return f >= mesh.first_cap_face;
        });
        first_role = last_role = mesh.corner_of(seed, *old);
    }
    for (int role = first_role; role <= last_role; ++role) {
        if (finder.assign_from(seed, role, face_count)) {
            return finder.ends(live_vertices);
        }
    }
    return {};
}

} // namespace spheroseg
