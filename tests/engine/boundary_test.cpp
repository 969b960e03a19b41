// SPDX-License-Identifier: GPL-3.0-or-later
#include "boundary.h"

#include "patchwork_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

namespace spheroseg {
namespace {

using namespace test;

bool touches_another(const Patchwork& patchwork, int face) {
    const int label = patchwork.label(face);
    bool found = false;
    for (int c = 0; c < 3; ++c) {
        const int across = patchwork.label_across(face, c);
        found = found || (across != kOpenBorder && across != label);
    }
    return found;
}

TEST(Boundary, HasTheFacesThatTouchOtherSubmeshesAtFirst) {
    for (const TriangleMesh& mesh : {displaced_sphere(5), open_grid(100)}) {
        const Levels levels(mesh);
        const Patchwork patchwork = rough_patchwork(levels, 40, 3);
        std::vector<int> expected;
        for (int f = 0; f < patchwork.face_count(); ++f) {
            if (touches_another(patchwork, f)) {
                expected.push_back(f);
            }
        }
        for (int threads : {1, 3}) {
            EXPECT_EQ(BoundaryFaces(patchwork, threads).faces(), expected);
            EXPECT_EQ(count_boundary_edges(patchwork, threads),
                      measures_of(levels, patchwork).boundary_edge_count);
        }
    }
}

TEST(Boundary, EveryFaceThatComesToTheBoundaryIsListed) {
    const Levels levels(flipped_sphere(3, 100));
    Patchwork patchwork = ragged_patchwork(levels, 20, 7);
    BoundaryFaces boundary(patchwork, 1);
    int moved_faces = 0;
    for (int i = 0; i < 6 * patchwork.face_count(); ++i) {
        Fan fan;
        if (!describe_shorter_fan(patchwork, i / 6, i % 3, (i / 3) % 2 != 0, fan) ||
            !fan_is_allowed(patchwork, fan)) {
            continue;
        }
        const Move& move = fan.move;
        apply(patchwork, move);
        for (int j = 0; j < move.face_count; ++j) {
            boundary.list_around(patchwork, move.faces[j], move.from, boundary.faces());
        }
        moved_faces += move.face_count > 2 ? move.face_count : 0;
    }
    EXPECT_GT(moved_faces, 100);
    std::vector<int> listed = boundary.faces();
    std::sort(listed.begin(), listed.end());
    EXPECT_EQ(std::adjacent_find(listed.begin(), listed.end()), listed.end());
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (touches_another(patchwork, f)) {
            EXPECT_TRUE(std::binary_search(listed.begin(), listed.end(), f)) << f;
        }
    }
}

/// Its groups are made of sub-meshes that touch one another, across other sub-meshes of the group.
void expect_connected_groups(const Patchwork& patchwork, const Grouping& grouping) {
    const std::vector<int>& group_of = grouping.group_of_label();
    ASSERT_EQ(group_of.size(), patchwork.load.size());
    std::set<std::pair<int, int>> touching;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        for (int c = 0; c < 3; ++c) {
            touching.emplace(patchwork.label(f), patchwork.label_across(f, c));
        }
    }
    std::vector<char> reached(group_of.size(), 0);
    std::set<int> groups;
    for (std::size_t first = 0; first < group_of.size(); ++first) {
        ASSERT_GE(group_of[first], 0);
        ASSERT_LT(group_of[first], grouping.group_count());
        if (reached[first]) {
            continue;
        }
        EXPECT_TRUE(groups.insert(group_of[first]).second) << "two parts of one group";
        std::vector<std::size_t> queue = {first};
        reached[first] = 1;
        for (std::size_t head = 0; head < queue.size(); ++head) {
            for (std::size_t l = 0; l < group_of.size(); ++l) {
                if (!reached[l] && group_of[l] == group_of[first] &&
                    touching.count({static_cast<int>(queue[head]), static_cast<int>(l)})) {
                    reached[l] = 1;
                    queue.push_back(l);
                }
            }
        }
    }
}

/// Per group the faces that touch another sub-mesh of their group.
std::vector<std::set<int>> faces_inside_groups(const Patchwork& patchwork,
                                               const Grouping& grouping) {
    const std::vector<int>& group_of = grouping.group_of_label();
    std::vector<std::set<int>> faces(grouping.group_count());
    for (int f = 0; f < patchwork.face_count(); ++f) {
        const int label = patchwork.label(f);
        for (int c = 0; c < 3; ++c) {
            const int across = patchwork.label_across(f, c);
            if (across != label && group_of[across] == group_of[label]) {
                faces[group_of[label]].insert(f);
            }
        }
    }
    return faces;
}

TEST(Grouping, PartsSubmeshesAndBoundaryFaces) {
    // Closed, of two components: where there are several groups, none is on both.
    TriangleMesh mesh = displaced_sphere(5);
    append(mesh, displaced_sphere(3));
    const Levels levels(mesh);
    for (int submesh_count : {20, 150, 1000}) {
        Patchwork patchwork = rough_patchwork(levels, submesh_count, 5);
        for (int threads : {1, 3}) {
            BoundaryFaces boundary(patchwork, threads);
            // Faces that left the boundary since they were listed.
            for (int f = 0; f < patchwork.face_count(); f += 7) {
                if (!boundary.listed()[f]) {
                    boundary.listed()[f] = 1;
                    boundary.faces().push_back(f);
                }
            }
            Grouping grouping;
            for (std::uint64_t seed = 0; seed < 6; ++seed) {
                grouping.regroup(patchwork, boundary, seed, threads);
                EXPECT_EQ(grouping.group_count() == 1, submesh_count == 20);
                if (grouping.group_count() > 1) {
                    expect_connected_groups(patchwork, grouping);
                }
                const std::vector<std::set<int>> expected =
                    faces_inside_groups(patchwork, grouping);
                for (int f = 0; f < patchwork.face_count(); ++f) {
                    EXPECT_EQ(boundary.listed()[f] != 0, touches_another(patchwork, f)) << f;
                }
                std::vector<int> order = grouping.largest_first();
                for (std::size_t i = 1; i < order.size(); ++i) {
                    EXPECT_GE(grouping.faces(order[i - 1]).size(), grouping.faces(order[i]).size());
                }
                std::sort(order.begin(), order.end());
                for (int g = 0; g < grouping.group_count(); ++g) {
                    EXPECT_EQ(order[g], g);
                    std::vector<int> found = grouping.faces(g);
                    std::sort(found.begin(), found.end());
                    EXPECT_EQ(found, std::vector<int>(expected[g].begin(), expected[g].end()));
                }
                std::vector<int> loads = patchwork.load;
                for (int l = 0; l < submesh_count; ++l) {
                    EXPECT_EQ(grouping.load(l), loads[l]);
                    grouping.load(l) += l;
                    loads[l] += l;
                }
                std::vector<int> collected(submesh_count);
                grouping.collect(collected, boundary);
                EXPECT_EQ(collected, loads);
                std::vector<int> listed = boundary.faces();
                std::sort(listed.begin(), listed.end());
                EXPECT_EQ(listed, BoundaryFaces(patchwork, 1).faces());
            }
        }
    }
}

TEST(Grouping, ItsFacesDoNotDependOnTheNumberOfThreads) {
    const Levels levels(displaced_sphere(5));
    const Patchwork patchwork = rough_patchwork(levels, 1000, 5);
    const auto faces_of_groups = [&](int threads) {
        BoundaryFaces boundary(patchwork, threads);
        Grouping grouping;
        grouping.regroup(patchwork, boundary, 4, threads);
        std::vector<std::vector<int>> faces;
        for (int g = 0; g < grouping.group_count(); ++g) {
            faces.push_back(grouping.faces(g));
        }
        return faces;
    };
    EXPECT_EQ(faces_of_groups(1), faces_of_groups(3));
}

} // namespace
} // namespace spheroseg
