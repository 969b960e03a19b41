// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "random.h"
#include "test_solids.h"

#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

/// Meshes for tests. Unless said otherwise: closed, manifold, genus 0, faces counter-clockwise seen
/// from outside, no unreferenced vertex.
namespace spheroseg::test {

/// Labels in [0, submesh_count) in the order of the faces, of nearly equally many each.
inline std::vector<int> labels_by_number(int face_count, int submesh_count) {
    std::vector<int> labels(face_count);
    for (int f = 0; f < face_count; ++f) {
        labels[f] = static_cast<int>(std::int64_t{submesh_count} * f / face_count);
    }
    return labels;
}

/// Icosphere whose vertices are moved along their radius by up to +-amplitude, at random.
inline TriangleMesh displaced_sphere(int level, double amplitude = 0.3, std::uint64_t seed = 1) {
    TriangleMesh mesh = icosphere(level);
    Random random(seed);
    for (Vec3& p : mesh.positions) {
        p = p * (1.0 + amplitude * (2.0 * random.uniform() - 1.0));
    }
    return mesh;
}

/// Icosphere with five limbs, each `limb_length` times as long as the body's radius.
inline TriangleMesh limbed_figure(int level, double limb_length = 6.0) {
    TriangleMesh mesh = icosphere(level);
    const Vec3 limbs[] = {
        {0, 0, 1}, {0.8, 0, 0.6}, {-0.8, 0, 0.6}, {0.6, 0, -0.8}, {-0.6, 0, -0.8}};
    for (Vec3& p : mesh.positions) {
        double radius = 1.0;
        for (const Vec3& limb : limbs) {
            radius += limb_length * std::exp(40.0 * (dot(p, limb) - 1.0));
        }
        p = p * radius;
    }
    return mesh;
}

/// Icosphere with 80 faces, on the first `tube_count` of which closed tubes of `ring_count` rings
/// of six faces stand, each ring a tenth farther out than the one below it. 6 * tube_count *
/// ring_count + 80 faces.
inline TriangleMesh tubes_on_sphere(int tube_count, int ring_count) {
    TriangleMesh mesh = icosphere(1);
    for (int tube = 0; tube < tube_count; ++tube) {
        Triangle ring = mesh.faces[tube];
        for (int r = 0; r < ring_count; ++r) {
            Triangle next;
            for (int i = 0; i < 3; ++i) {
                next[i] = static_cast<int>(mesh.positions.size());
                const Vec3 position = mesh.positions[ring[i]] * 1.1;
                mesh.positions.push_back(position);
            }
            for (int i = 0; i < 3; ++i) {
                const int j = (i + 1) % 3;
                mesh.faces.push_back({ring[i], ring[j], next[i]});
                mesh.faces.push_back({ring[j], next[j], next[i]});
            }
            ring = next;
        }
        mesh.faces[tube] = ring;
    }
    return mesh;
}

/// Closed tube along z: `ring_count` rings of `ring_size` vertices and two poles.
/// 2 * ring_size * ring_count faces. Long, thin and few around: the hardest limb.
inline TriangleMesh long_thin_limb(int ring_size, int ring_count, double ring_spacing = 0.5) {
    TriangleMesh mesh;
    for (int r = 0; r < ring_count; ++r) {
        for (int i = 0; i < ring_size; ++i) {
            const double angle = 2.0 * kPi * (i + 0.5 * (r % 2)) / ring_size;
            mesh.positions.push_back({std::cos(angle), std::sin(angle), r * ring_spacing});
        }
    }
    const int bottom = ring_size * ring_count;
    const int top = bottom + 1;
    mesh.positions.push_back({0, 0, -ring_spacing});
    mesh.positions.push_back({0, 0, ring_count * ring_spacing});
    const auto at = [&](int r, int i) { return r * ring_size + i % ring_size; };
    for (int i = 0; i < ring_size; ++i) {
        mesh.faces.push_back({bottom, at(0, i + 1), at(0, i)});
        mesh.faces.push_back({top, at(ring_count - 1, i), at(ring_count - 1, i + 1)});
        for (int r = 0; r + 1 < ring_count; ++r) {
            const int shift = r % 2;
            mesh.faces.push_back({at(r, i), at(r, i + 1), at(r + 1, i + shift)});
            mesh.faces.push_back({at(r, i + 1 - shift), at(r + 1, i + 1), at(r + 1, i)});
        }
    }
    return mesh;
}

/// 8,192 faces: about the fewest of which `high` makes a start on the sphere, with 50 sub-meshes.
inline TriangleMesh mesh_for_a_sphere_start() {
    TriangleMesh mesh = octahedron();
    for (int level = 0; level < 5; ++level) {
        mesh = subdivide(mesh);
    }
    return mesh;
}

/// Two apexes (vertices `valence` and `valence + 1`) over a ring. 2 * valence faces.
inline TriangleMesh bipyramid(int valence) {
    TriangleMesh mesh;
    for (int i = 0; i < valence; ++i) {
        const double angle = 2.0 * kPi * i / valence;
        mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.0});
    }
    mesh.positions.push_back({0, 0, 1});
    mesh.positions.push_back({0, 0, -1});
    for (int i = 0; i < valence; ++i) {
        const int next = (i + 1) % valence;
        mesh.faces.push_back({i, next, valence});
        mesh.faces.push_back({next, i, valence + 1});
    }
    return mesh;
}

/// Cylinder of `side_count` sides along z with caps that are fans around a vertex each. 4 *
/// side_count faces, or without the upper cap 3 * side_count and an open border.
inline TriangleMesh capped_cylinder(int side_count, bool has_upper_cap = true) {
    TriangleMesh mesh;
    for (double z : {0.0, 2.0}) {
        for (int i = 0; i < side_count; ++i) {
            const double angle = 2.0 * kPi * i / side_count;
            mesh.positions.push_back({std::cos(angle), std::sin(angle), z});
        }
    }
    const int lower = 2 * side_count;
    mesh.positions.push_back({0, 0, 0});
    if (has_upper_cap) {
        mesh.positions.push_back({0, 0, 2});
    }
    for (int i = 0; i < side_count; ++i) {
        const int next = (i + 1) % side_count;
        mesh.faces.push_back({i, next, side_count + i});
        mesh.faces.push_back({next, side_count + next, side_count + i});
        mesh.faces.push_back({next, i, lower});
        if (has_upper_cap) {
            mesh.faces.push_back({side_count + i, side_count + next, lower + 1});
        }
    }
    return mesh;
}

/// Faces in a row around vertex 0, which lies on the open border.
inline TriangleMesh open_fan(int face_count) {
    TriangleMesh mesh;
    mesh.positions.push_back({0, 0, 0});
    for (int i = 0; i <= face_count; ++i) {
        const double angle = kPi * i / face_count;
        mesh.positions.push_back({std::cos(angle), std::sin(angle), 0.0});
    }
    for (int i = 1; i <= face_count; ++i) {
        mesh.faces.push_back({0, i, i + 1});
    }
    return mesh;
}

/// Every `every`-th face the other way round, from the first one on: no common orientation.
inline TriangleMesh with_turned_faces(TriangleMesh mesh, int every) {
    for (int f = 0; f < mesh.face_count(); f += every) {
        std::swap(mesh.faces[f][0], mesh.faces[f][1]);
    }
    return mesh;
}

/// Tetrahedron with `split_count` vertices added, each inside a random face (`nested`: inside the
/// face made last), very near to one of its edges: slivers, nested separating triangles and
/// vertices of high valence. 4 + 2 * split_count faces.
inline TriangleMesh slivers(int split_count, bool nested = false, std::uint64_t seed = 1) {
    TriangleMesh mesh = tetrahedron();
    Random random(seed);
    for (int i = 0; i < split_count; ++i) {
        const int f = nested ? mesh.face_count() - 1 : random.below(mesh.face_count());
        const Triangle t = mesh.faces[f];
        const int v = mesh.vertex_count();
        mesh.positions.push_back(mesh.positions[t[0]] * 0.5 + mesh.positions[t[1]] * 0.499 +
                                 mesh.positions[t[2]] * 0.001);
        mesh.faces[f] = {t[0], t[1], v};
        mesh.faces.push_back({t[2], t[0], v});
        mesh.faces.push_back({t[1], t[2], v});
    }
    return mesh;
}

/// Icosphere after random edge flips that keep it a surface: degrees from 3 to dozens.
inline TriangleMesh flipped_sphere(int level, int flip_count, std::uint64_t seed = 1) {
    TriangleMesh mesh = icosphere(level);
    Random random(seed);
    std::map<std::pair<int, int>, int> face_of_side;
    const auto enter = [&](int f) {
        for (int c = 0; c < 3; ++c) {
            face_of_side[{mesh.faces[f][c], mesh.faces[f][(c + 1) % 3]}] = f;
        }
    };
    for (int f = 0; f < mesh.face_count(); ++f) {
        enter(f);
    }
    for (int i = 0; i < flip_count; ++i) {
        const int f = random.below(mesh.face_count());
        const int c = random.below(3);
        const int a = mesh.faces[f][c];
        const int b = mesh.faces[f][(c + 1) % 3];
        const int left = mesh.faces[f][(c + 2) % 3];
        const int g = face_of_side[{b, a}];
        const Triangle& t = mesh.faces[g];
        const int right = t[0] + t[1] + t[2] - a - b;
        if (face_of_side.count({left, right}) == 0) {
            face_of_side.erase({a, b});
            face_of_side.erase({b, a});
            mesh.faces[f] = {a, right, left};
            mesh.faces[g] = {b, left, right};
            enter(f);
            enter(g);
        }
    }
    return mesh;
}

/// Closed manifold of genus 1: 2 * around * across faces.
inline TriangleMesh torus(int around, int across) {
    TriangleMesh mesh;
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j < across; ++j) {
            const double u = 2.0 * kPi * i / around;
            const double v = 2.0 * kPi * j / across;
            const double radius = 2.0 + std::cos(v);
            mesh.positions.push_back({radius * std::cos(u), radius * std::sin(u), std::sin(v)});
            const auto at = [&](int di, int dj) {
                return (i + di) % around * across + (j + dj) % across;
            };
            mesh.faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
            mesh.faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
        }
    }
    return mesh;
}

/// The squares of a flat grid for which `is_there(x, y)` is true, two faces each. Open; keeps the
/// vertices of the others.
template <typename IsThere> TriangleMesh flat_squares(int width, int height, IsThere is_there) {
    TriangleMesh mesh;
    const auto at = [&](int x, int y) { return y * (width + 1) + x; };
    for (int y = 0; y <= height; ++y) {
        for (int x = 0; x <= width; ++x) {
            mesh.positions.push_back({static_cast<double>(x), static_cast<double>(y), 0.0});
            if (x < width && y < height && is_there(x, y)) {
                mesh.faces.push_back({at(x, y), at(x + 1, y), at(x + 1, y + 1)});
                mesh.faces.push_back({at(x, y), at(x + 1, y + 1), at(x, y + 1)});
            }
        }
    }
    return mesh;
}

/// Flat open square of 2 * side^2 faces; its 4 * side border edges are open.
inline TriangleMesh open_grid(int side) {
    return flat_squares(side, side, [](int, int) { return true; });
}

/// The same with square holes of 2 * 2 squares, two squares apart.
inline TriangleMesh grid_with_holes(int side) {
    return flat_squares(side, side, [](int x, int y) { return x % 4 / 2 == 0 || y % 4 / 2 == 0; });
}

/// Flat and open: a bar one square wide with teeth of `height` squares, two wide and one apart.
inline TriangleMesh flat_comb(int teeth, int height) {
    return flat_squares(
        3 * teeth - 1, height + 1, [](int x, int y) { return y == 0 || x % 3 < 2; });
}

/// Without every so many faces, none of which share a vertex.
inline TriangleMesh pinholed(const TriangleMesh& from, int every) {
    TriangleMesh mesh{from.positions, {}};
    std::set<int> used;
    for (int f = 0, since = 0; f < from.face_count(); ++f) {
        const Triangle& t = from.faces[f];
        const bool is_free = used.count(t[0]) + used.count(t[1]) + used.count(t[2]) == 0;
        if (++since >= every && is_free) {
            used.insert(t.begin(), t.end());
            since = 0;
        } else {
            mesh.faces.push_back(t);
        }
    }
    return mesh;
}

/// A band of 2 * around * across faces that is glued to itself the other way round: no common
/// orientation of all faces exists.
inline TriangleMesh moebius_strip(int around, int across) {
    TriangleMesh mesh;
    for (int i = 0; i < around; ++i) {
        for (int j = 0; j <= across; ++j) {
            const double turn = 2.0 * kPi * i / around;
            const double radius = 2.0 + (1.0 * j / across - 0.5) * std::cos(turn / 2.0);
            mesh.positions.push_back({radius * std::cos(turn),
                                      radius * std::sin(turn),
                                      (1.0 * j / across - 0.5) * std::sin(turn / 2.0)});
            const auto at = [&](int di, int dj) {
                return i + di < around ? (i + di) * (across + 1) + j + dj : across - j - dj;
            };
            if (j < across) {
                mesh.faces.push_back({at(0, 0), at(1, 0), at(1, 1)});
                mesh.faces.push_back({at(0, 0), at(1, 1), at(0, 1)});
            }
        }
    }
    return mesh;
}

/// A face with a strip of so many faces on each of its sides.
inline TriangleMesh star(const std::array<int, 3>& lengths) {
    TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    for (int side = 0; side < 3; ++side) {
        int a = side;
        int b = (side + 1) % 3;
        for (int i = 0; i < lengths[side]; ++i) {
            const int tip = mesh.vertex_count();
            mesh.positions.push_back({1.0 * side, 1.0 * i, 1.0});
            mesh.faces.push_back({b, a, tip});
            (i % 2 == 0 ? a : b) = tip;
        }
    }
    return mesh;
}

/// An open surface grown by gluing triangles to random open edges: its dual graph is a tree.
inline TriangleMesh random_tree(int face_count, std::uint64_t seed) {
    Random random(seed);
    TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.faces = {{0, 1, 2}};
    std::vector<std::pair<int, int>> open = {{1, 0}, {2, 1}, {0, 2}};
    while (mesh.face_count() < face_count) {
        const std::size_t at = random.below(static_cast<std::uint32_t>(open.size()));
        const auto [a, b] = open[at];
        const int tip = mesh.vertex_count();
        mesh.positions.push_back({1.0 * tip, 0.0, 0.0});
        mesh.faces.push_back({a, b, tip});
        open[at] = {tip, b};
        open.emplace_back(a, tip);
    }
    return mesh;
}

/// Replaces face f, and appends two, by three around a vertex in its middle.
inline void put_vertex_into(TriangleMesh& mesh, int f) {
    const auto [a, b, c] = mesh.faces[f];
    const int tip = mesh.vertex_count();
    mesh.positions.push_back((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) *
                             (1.0 / 3.0));
    mesh.faces[f] = {a, b, tip};
    mesh.faces.push_back({b, c, tip});
    mesh.faces.push_back({c, a, tip});
}

/// A stacked triangulation: vertices put into faces that chance chooses. Closed, of genus 0, and
/// with many vertices of valence 3 and some of a very large one.
inline TriangleMesh stacked(int face_count, std::uint64_t seed) {
    Random random(seed);
    TriangleMesh mesh = tetrahedron();
    while (mesh.face_count() < face_count) {
        const auto f =
            static_cast<int>(random.below(static_cast<std::uint32_t>(mesh.face_count())));
        put_vertex_into(mesh, f);
    }
    return mesh;
}

/// The same with a vertex put into each face that is there, one after another, so that of the three
/// new ones one stays as it is: nests of equal depth, each with two in it.
inline TriangleMesh evenly_stacked(int face_count) {
    TriangleMesh mesh = tetrahedron();
    for (int f = 0; mesh.face_count() < face_count; ++f) {
        put_vertex_into(mesh, f);
    }
    return mesh;
}

/// The surface of the unit cubes of a box for which `is_solid(x, y, z)` is true, two faces for each
/// of its squares. Where cubes meet they must have a side in common, or be joined by one around the
/// edge or corner where they meet.
template <typename IsSolid> TriangleMesh surface_of_cubes(const Triangle& box, IsSolid is_solid) {
    TriangleMesh mesh;
    std::map<Triangle, int> vertices;
    const auto vertex = [&](const Triangle& at) {
        const auto [found, is_new] = vertices.try_emplace(at, mesh.vertex_count());
        if (is_new) {
            mesh.positions.push_back({1.0 * at[0], 1.0 * at[1], 1.0 * at[2]});
        }
        return found->second;
    };
    const auto is_filled = [&](const Triangle& at) {
        for (int d = 0; d < 3; ++d) {
            if (at[d] < 0 || at[d] >= box[d]) {
                return false;
            }
        }
        return static_cast<bool>(is_solid(at[0], at[1], at[2]));
    };
    const auto add_square = [&](Triangle at, int axis, bool is_outside) {
        const int u = (axis + 1) % 3;
        const int v = (axis + 2) % 3;
        at[axis] += is_outside;
        std::array<int, 4> corners;
        for (int i = 0; i < 4; ++i) {
            Triangle corner = at;
            corner[u] += i == 1 || i == 2;
            corner[v] += i >= 2;
            corners[is_outside ? i : 3 - i] = vertex(corner);
        }
        mesh.faces.push_back({corners[0], corners[1], corners[2]});
        mesh.faces.push_back({corners[0], corners[2], corners[3]});
    };
    for (int x = 0; x < box[0]; ++x) {
        for (int y = 0; y < box[1]; ++y) {
            for (int z = 0; z < box[2]; ++z) {
                for (int axis = 0; axis < 3 && is_filled({x, y, z}); ++axis) {
                    for (bool is_outside : {false, true}) {
                        Triangle next = {x, y, z};
                        next[axis] += is_outside ? 1 : -1;
                        if (!is_filled(next)) {
                            add_square({x, y, z}, axis, is_outside);
                        }
                    }
                }
            }
        }
    }
    return mesh;
}

/// A cubic grid of struts with `nodes` nodes along each axis. Of genus
/// 3 nodes^2 (nodes - 1) - nodes^3 + 1: hardly anything but handles.
inline TriangleMesh lattice(int nodes) {
    const int side = 2 * nodes - 1;
    return surface_of_cubes({side, side, side},
                            [](int x, int y, int z) { return x % 2 + y % 2 + z % 2 <= 1; });
}

/// A bar with teeth of `height` cubes, two wide and two apart. Of genus 0.
inline TriangleMesh comb(int teeth, int height) {
    return surface_of_cubes({4 * teeth - 2, height + 2, 2},
                            [](int x, int y, int) { return y < 2 || x % 4 < 2; });
}

/// How a mesh is made. As the parameter of a test it costs nothing in the processes of other tests.
struct MeshRecipe {
    const char* name;
    TriangleMesh (*make)();
};

/// Small closed genus-0 meshes of every kind above, for property tests; at most 5,120 faces.
inline const std::vector<MeshRecipe>& genus_zero_recipes() {
    static const std::vector<MeshRecipe> recipes = {
        {"tetrahedron", [] { return tetrahedron(); }},
        {"octahedron", [] { return octahedron(); }},
        {"icosahedron", [] { return icosahedron(); }},
        {"icosphere", [] { return icosphere(4); }},
        {"displaced_sphere", [] { return displaced_sphere(4); }},
        {"limbed_figure", [] { return limbed_figure(4); }},
        {"long_thin_limb", [] { return long_thin_limb(6, 300); }},
        {"needle", [] { return long_thin_limb(3, 500); }},
        {"bipyramid", [] { return bipyramid(500); }},
        {"three_sided_bipyramid", [] { return bipyramid(3); }},
        {"flipped_sphere", [] { return flipped_sphere(4, 30000); }},
        {"slivers", [] { return slivers(1000); }},
        {"nested_slivers", [] { return slivers(300, true); }}};
    return recipes;
}

struct NamedMesh {
    std::string name;
    TriangleMesh mesh;
};

inline std::vector<NamedMesh> genus_zero_meshes() {
    std::vector<NamedMesh> meshes;
    for (const MeshRecipe& recipe : genus_zero_recipes()) {
        meshes.push_back({recipe.name, recipe.make()});
    }
    return meshes;
}

} // namespace spheroseg::test
