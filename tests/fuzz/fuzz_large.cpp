// SPDX-License-Identifier: GPL-3.0-or-later
#include "fuzz_large.h"

#include "../engine/test_meshes.h"
#include "fuzz_changes.h"
#include "fuzz_shapes.h"
#include "random.h"

namespace spheroseg::fuzz {

namespace {

constexpr int kMaxParts = 4;
constexpr int kMaxWounds = 5;

int random_face(const TriangleMesh& mesh, Random& random) {
    return static_cast<int>(random.below(static_cast<std::uint32_t>(mesh.face_count())));
}

int random_vertex(const TriangleMesh& mesh, Random& random) {
    return mesh.faces[random_face(mesh, random)][random.below(3)];
}

/// Any small shape, which may be pinched or not orientable, with each face cut into four until
/// there are enough.
TriangleMesh subdivided_shape(ByteReader& bytes, int face_count) {
    TriangleMesh mesh = read_shape(bytes);
    while (2 * mesh.face_count() < face_count) {
        mesh = test::subdivide(mesh);
    }
    return mesh;
}

/// About `face_count` faces.
TriangleMesh large_shape(ByteReader& bytes, int face_count) {
    const int kind = bytes.below(12);
    const int detail = bytes.byte();
    const auto seed = static_cast<std::uint64_t>(detail);
    switch (kind) {
    case 0:
        return test::displaced_sphere(face_count < 800 ? 2 : 3, detail % 8 / 10.0, seed);
    case 1: {
        const int across = 3 + detail % 24;
        return test::torus(std::max(3, face_count / 2 / across), across);
    }
    case 2: {
        const int around = 3 + detail % 14;
        return test::long_thin_limb(around, std::max(1, face_count / 2 / around));
    }
    case 3:
        return test::flipped_sphere(face_count < 800 ? 2 : 3, 16 * detail, seed);
    case 4:
        return test::slivers(face_count / 2, detail % 4 == 0, seed);
    case 5:
        return test::bipyramid(face_count / 2);
    case 6:
        return test::limbed_figure(face_count < 800 ? 2 : 3, detail % 10);
    case 7:
        if (detail % 4 == 0) {
            return strip(face_count);
        } else if (detail % 4 == 1) {
            Random choices(seed);
            return triangle_tree(choices, face_count);
        }
        return fan(face_count, detail % 4 == 2);
    case 8:
    case 9:
        return subdivided_shape(bytes, face_count);
    default: {
        const int rows = 1 + detail % 32;
        const int glue = bytes.below(9);
        return glued_grid(std::max(1, face_count / 2 / rows), rows, glue % 3, glue / 3);
    }
    }
}

/// Takes two faces out and joins their edges by a tube of six faces: a handle, or a bridge where
/// they are in different components.
void join_by_tube(TriangleMesh& mesh, int first, int second) {
    const Triangle a = mesh.faces[first];
    const Triangle b = mesh.faces[second];
    for (int v : a) {
        if (std::find(b.begin(), b.end(), v) != b.end()) {
            return;
        }
    }
    // Along the tube b is met the other way round.
    const Triangle c = {b[0], b[2], b[1]};
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        mesh.faces.push_back({a[i], a[j], c[i]});
        mesh.faces.push_back({a[j], c[j], c[i]});
    }
    mesh.faces.erase(mesh.faces.begin() + std::max(first, second));
    mesh.faces.erase(mesh.faces.begin() + std::min(first, second));
}

/// Removes the faces that a plane cuts: a gap between two parts, or two borders.
void saw_through(TriangleMesh& mesh, const Vec3& normal, double height) {
    const auto is_cut = [&](const Triangle& t) {
        int above = 0;
        for (int v : t) {
            above += dot(mesh.positions[v], normal) > height;
        }
        return above == 1 || above == 2;
    };
    mesh.faces.erase(std::remove_if(mesh.faces.begin(), mesh.faces.end(), is_cut),
                     mesh.faces.end());
}

/// Numbers faces and vertices anew, at random.
void shuffle(TriangleMesh& mesh, Random& random) {
    std::vector<int> place(mesh.positions.size());
    for (std::size_t v = 0; v < place.size(); ++v) {
        place[v] = static_cast<int>(v);
        std::swap(place[v], place[random.below(static_cast<std::uint32_t>(v + 1))]);
    }
    const std::vector<Vec3> positions = mesh.positions;
    for (std::size_t v = 0; v < place.size(); ++v) {
        mesh.positions[place[v]] = positions[v];
    }
    for (Triangle& t : mesh.faces) {
        t = {place[t[0]], place[t[1]], place[t[2]]};
        std::rotate(t.begin(), t.begin() + random.below(3), t.end());
        std::swap(t, mesh.faces[random_face(mesh, random)]);
    }
}

/// One of the kinds that leave a surface a surface, or seldom do not.
void wound_once(TriangleMesh& mesh, int kind, Random& random) {
    const int face = random_face(mesh, random);
    const int corner = static_cast<int>(random.below(3));
    Triangle& t = mesh.faces[face];
    switch (kind) {
    case 0:
    case 1:
        mesh.faces.erase(mesh.faces.begin() + face);
        break;
    case 2:
    case 3:
        flip_edge(mesh, face, corner, true);
        break;
    case 4:
        std::swap(t[0], t[1]);
        break;
    case 5:
        cut_hole(mesh, t[corner]);
        break;
    case 6:
        detach_corner(mesh, face, corner);
        break;
    case 7:
        split_face(mesh, face);
        break;
    case 8:
        // New vertices gather in the last faces.
        split_face(mesh, std::max(0, mesh.face_count() - 1 - static_cast<int>(random.below(3))));
        break;
    case 9:
        mesh.positions[t[corner]] = mesh.positions[random_vertex(mesh, random)];
        break;
    case 10:
        mesh.positions[t[corner]] = mesh.positions[t[corner]] * std::exp(40.0 * random.uniform());
        break;
    default:
        join_by_tube(mesh, face, random_face(mesh, random));
        break;
    }
}

/// Wounds of one kind at up to 255 places, or one that is about the whole mesh.
void wound(TriangleMesh& mesh, ByteReader& bytes) {
    const int kind = bytes.below(16);
    const int amount = bytes.byte();
    Random random(static_cast<std::uint64_t>(bytes.byte()));
    const double height = 2.0 * random.uniform() - 1.0;
    switch (kind) {
    case 12:
        saw_through(mesh, {random.uniform(), random.uniform(), random.uniform()}, height);
        break;
    case 13:
        shuffle(mesh, random);
        break;
    case 14:
        for (int i = 0; i <= amount % 4; ++i) {
            replace_vertex(mesh, random_vertex(mesh, random), random_vertex(mesh, random));
        }
        break;
    case 15:
        if (amount % 8 == 0) {
            mesh.faces.push_back(mesh.faces[random_face(mesh, random)]);
        }
        for (Vec3& p : mesh.positions) {
            p.z *= amount % 3;
        }
        break;
    default:
        for (int i = 0; i < amount && mesh.face_count() > 1; ++i) {
            wound_once(mesh, kind, random);
        }
        break;
    }
}

} // namespace

TriangleMesh read_large_mesh(ByteReader& bytes) {
    TriangleMesh mesh;
    const int part_count = std::max(1, bytes.below(2 * kMaxParts) - kMaxParts + 1);
    for (int part = 0; part < part_count; ++part) {
        const int size = bytes.byte();
        TriangleMesh next = large_shape(bytes, 120 + size * size / 36);
        for (Vec3& p : next.positions) {
            p.x += 0.5 * part;
        }
        test::append(mesh, next);
    }
    const int wound_count = bytes.below(kMaxWounds + 1);
    for (int i = 0; i < wound_count && !mesh.faces.empty(); ++i) {
        mesh.faces.resize(std::min<std::size_t>(mesh.faces.size(), kMaxLargeFaces));
        wound(mesh, bytes);
    }
    return mesh;
}

} // namespace spheroseg::fuzz
