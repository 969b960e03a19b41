// SPDX-License-Identifier: GPL-3.0-or-later
#include "soundness.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace spheroseg {
namespace {

using namespace test;

/// How many groups these faces make when those are joined for which `joined` is true.
template <typename Joined> int count_groups(const std::vector<int>& faces, Joined joined) {
    std::set<int> left(faces.begin(), faces.end());
    int count = 0;
    for (; !left.empty(); ++count) {
        std::vector<int> stack{*left.begin()};
        left.erase(left.begin());
        while (!stack.empty()) {
            const int face = stack.back();
            stack.pop_back();
            for (auto other = left.begin(); other != left.end();) {
                if (joined(face, *other)) {
                    stack.push_back(*other);
                    other = left.erase(other);
                } else {
                    ++other;
                }
            }
        }
    }
    return count;
}

/// By the definition, on vertices: one piece, and one fan around each vertex.
bool is_sound_by_definition(const Levels& levels, const std::vector<int>& faces) {
    const auto share_an_edge = [&](int f, int g) {
        const std::array<int, 3>& neighbors = levels.graph.neighbors[f];
        return std::find(neighbors.begin(), neighbors.end(), g) != neighbors.end();
    };
    std::map<int, std::vector<int>> faces_at;
    for (int f : faces) {
        for (int v : levels.mesh.faces[f]) {
            faces_at[v].push_back(f);
        }
    }
    return count_groups(faces, share_an_edge) == 1 &&
        std::all_of(faces_at.begin(), faces_at.end(), [&](const auto& at) {
               const auto share_an_edge_there = [&](int f, int g) {
                   const auto side = [&](int c) { return levels.graph.neighbors[f][c] == g; };
                   const int corner = corner_of(levels.mesh.faces[f], at.first);
                   return side(corner) || side(previous_corner(corner));
               };
               return count_groups(at.second, share_an_edge_there) == 1;
           });
}

TEST(Soundness, IsThatOfTheDefinition) {
    int sound_count = 0;
    int unsound_count = 0;
    for (const TriangleMesh& mesh : {displaced_sphere(1),
                                     bipyramid(30),
                                     torus(8, 5),
                                     open_grid(6),
                                     grid_with_holes(7),
                                     moebius_strip(9, 2),
                                     stacked(60, 2)}) {
        const Levels levels(mesh);
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            const int k = 2 + static_cast<int>(seed);
            Patchwork patchwork = levels.multilevel.coarsen(mesh.face_count(), k);
            bisect(patchwork, k, seed, 1);
            Random random(seed);
            for (int i = 0; i < 6; ++i) { // some faces pass to a neighbour, wherever that leads
                const auto f =
                    static_cast<int>(random.below(static_cast<std::uint32_t>(mesh.face_count())));
                const int across = patchwork.label_across(f, static_cast<int>(random.below(3)));
                patchwork.set_label(f, across < 0 ? patchwork.label(f) : across);
            }
            const std::vector<int> labels = levels.multilevel.labels(patchwork);
            std::vector<std::vector<int>> faces(k);
            for (int f = 0; f < mesh.face_count(); ++f) {
                faces[labels[f]].push_back(f);
            }
            const std::vector<std::uint8_t> sound = sound_submeshes(patchwork);
            const int unsound_before = unsound_count;
            for (int l = 0; l < k; ++l) {
                EXPECT_EQ(sound[l] != 0, is_sound_by_definition(levels, faces[l]))
                    << mesh.face_count() << " faces, seed " << seed << ", sub-mesh " << l;
                (sound[l] != 0 ? sound_count : unsound_count) += 1;
            }
            EXPECT_EQ(is_sound(patchwork), unsound_count == unsound_before);
        }
    }
    EXPECT_GT(sound_count, 500);
    EXPECT_GT(unsound_count, 100);
}

} // namespace
} // namespace spheroseg
