// SPDX-License-Identifier: GPL-3.0-or-later
#include "measures.h"

#include "errors.h"
#include "random.h"
#include "test_meshes.h"
#include "validity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>

namespace spheroseg {
namespace {

using namespace test;

Measures measure_labels(const TriangleMesh& mesh, const std::vector<int>& labels, int k) {
    return measure(mesh, build_dual_graph(mesh), labels, k, 2);
}

void expect_same(const Measures& found, const Measures& expected) {
    EXPECT_EQ(found.boundary_edge_count, expected.boundary_edge_count);
    EXPECT_EQ(found.bowtie_count, expected.bowtie_count);
    EXPECT_EQ(found.disconnected_submesh_count, expected.disconnected_submesh_count);
    EXPECT_EQ(found.disk_count, expected.disk_count);
    EXPECT_EQ(found.submesh_triangles, expected.submesh_triangles);
}

/// Number of classes of `items` under the relation given by `related`, by repeated relabelling.
template <typename Related>
int count_classes(const std::vector<int>& items, const Related& related) {
    std::vector<int> class_of(items.size());
    std::iota(class_of.begin(), class_of.end(), 0);
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t i = 0; i < items.size(); ++i) {
            for (std::size_t j = 0; j < items.size(); ++j) {
                if (class_of[i] > class_of[j] && related(items[i], items[j])) {
                    class_of[i] = class_of[j];
                    changed = true;
                }
            }
        }
    }
    return static_cast<int>(std::set<int>(class_of.begin(), class_of.end()).size());
}

bool names(const Triangle& face, int vertex) {
    return face[0] == vertex || face[1] == vertex || face[2] == vertex;
}

/// Recounts everything from the definitions, with maps and sets and without the dual graph.
struct Recount {
    Recount(const TriangleMesh& mesh, const std::vector<int>& labels, int submesh_count) {
        std::map<std::set<int>, std::vector<int>> faces_of_edge;
        for (int f = 0; f < mesh.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                faces_of_edge[{mesh.faces[f][c], mesh.faces[f][(c + 1) % 3]}].push_back(f);
            }
        }
        for (const auto& [edge, faces] : faces_of_edge) {
            boundary_edges += faces.size() == 2 && labels[faces[0]] != labels[faces[1]];
        }
        edge_count = static_cast<int>(faces_of_edge.size());
        for (int s = 0; s < submesh_count; ++s) {
            count_submesh(mesh, labels, s);
        }
    }

    void count_submesh(const TriangleMesh& mesh, const std::vector<int>& labels, int s) {
        std::vector<int> faces;
        std::set<int> vertices;
        std::map<std::set<int>, int> edges;
        for (int f = 0; f < mesh.face_count(); ++f) {
            if (labels[f] != s) {
                continue;
            }
            faces.push_back(f);
            for (int c = 0; c < 3; ++c) {
                vertices.insert(mesh.faces[f][c]);
                ++edges[{mesh.faces[f][c], mesh.faces[f][(c + 1) % 3]}];
            }
        }
        const auto shared = [&](int f, int g) {
            std::vector<int> result;
            for (int v : mesh.faces[f]) {
                if (names(mesh.faces[g], v)) {
                    result.push_back(v);
                }
            }
            return result;
        };
        int submesh_bowties = 0;
        for (int v : vertices) {
            std::vector<int> star;
            std::copy_if(faces.begin(), faces.end(), std::back_inserter(star), [&](int f) {
                return names(mesh.faces[f], v);
            });
            submesh_bowties +=
                count_classes(star,
                              [&](int f, int g) { return f != g && shared(f, g).size() == 2; }) -
                1;
        }
        bowties += submesh_bowties;
        const int components =
            count_classes(faces, [&](int f, int g) { return f != g && shared(f, g).size() == 2; });
        disconnected += components > 1;
        std::vector<int> boundary_vertices;
        std::set<std::set<int>> boundary;
        std::set<int> seen;
        for (const auto& [edge, count] : edges) {
            if (count == 1) {
                boundary.insert(edge);
                seen.insert(edge.begin(), edge.end());
            }
        }
        boundary_vertices.assign(seen.begin(), seen.end());
        const int loops = count_classes(boundary_vertices, [&](int u, int v) {
            return boundary.count({u, v}) > 0;
        });
        const int euler = static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) +
            static_cast<int>(faces.size());
        disks += submesh_bowties == 0 && components == 1 && euler == 1 && loops == 1;
    }

    int boundary_edges = 0;
    int edge_count = 0;
    int bowties = 0;
    int disconnected = 0;
    int disks = 0;
};

TEST(Measures, OneSubmeshOfAClosedMeshHasNoBoundaryAndIsNoDisk) {
    const Measures m = measure_labels(octahedron(), std::vector<int>(8, 0), 1);
    EXPECT_EQ(m.boundary_edge_count, 0);
    EXPECT_EQ(m.boundary_edge_ratio, 0.0);
    EXPECT_EQ(m.bowtie_count, 0);
    EXPECT_EQ(m.disconnected_submesh_count, 0);
    EXPECT_EQ(m.disk_count, 0);
    EXPECT_EQ(m.coefficient_of_variation, 0.0);
    EXPECT_TRUE(m.is_valid());
}

TEST(Measures, HalvesOfAnOctahedronAreTwoDisksWithFourBoundaryEdges) {
    const Measures m = measure_labels(octahedron(), {0, 0, 0, 0, 1, 1, 1, 1}, 2);
    EXPECT_EQ(m.boundary_edge_count, 4);
    EXPECT_DOUBLE_EQ(m.boundary_edge_ratio, 4.0 / 12.0);
    EXPECT_EQ(m.disk_count, 2);
    EXPECT_EQ(m.max_triangle_count_difference, 0);
    EXPECT_TRUE(m.is_valid());
}

TEST(Measures, OppositeFacesOfAnOctahedronsUpperHalfMakeABowtieAndTwoComponents) {
    // Label 1: faces 0 and 2, which meet in the apex (vertex 4) alone. Label 0: the lower half
    // and faces 1 and 3: connected, and around the apex two fans.
    const Measures m = measure_labels(octahedron(), {1, 0, 1, 0, 0, 0, 0, 0}, 2);
    EXPECT_EQ(m.boundary_edge_count, 6);
    EXPECT_EQ(m.bowtie_count, 2);
    EXPECT_EQ(m.disconnected_submesh_count, 1);
    EXPECT_EQ(m.disk_count, 0);
    EXPECT_EQ(m.min_submesh_triangles, 2);
    EXPECT_EQ(m.max_submesh_triangles, 6);
    EXPECT_EQ(m.max_triangle_count_difference, 4);
    EXPECT_DOUBLE_EQ(m.coefficient_of_variation, 0.5); // counts 2 and 6: mean 4, deviation 2
    EXPECT_EQ(m.submesh_triangles, (std::vector<int>{6, 2}));
    EXPECT_FALSE(m.is_valid());
}

TEST(Measures, ARingAroundATubeIsConnectedButNoDisk) {
    // Three bands of a closed tube: two caps (disks) and a ring (annulus) between them.
    const TriangleMesh mesh = long_thin_limb(6, 3);
    std::vector<int> labels;
    for (const Triangle& face : mesh.faces) {
        double z = 0.0;
        for (int v : face) {
            z += mesh.positions[v].z / 3.0;
        }
        labels.push_back(z < 0.0 ? 0 : z < 1.0 ? 1 : 2);
    }
    const Measures m = measure_labels(mesh, labels, 3);
    EXPECT_EQ(m.disk_count, 2);
    EXPECT_EQ(m.boundary_edge_count, 12);
    EXPECT_EQ(m.bowtie_count, 0);
    EXPECT_EQ(m.disconnected_submesh_count, 0);
    EXPECT_EQ(m.submesh_triangles, (std::vector<int>{6, 24, 6}));
}

TEST(Measures, AProjectivePlaneHasTheEulerCharacteristicOfADiskAndIsNone) {
    // Six vertices, each pair of them an edge.
    TriangleMesh mesh;
    mesh.positions.resize(6);
    for (int i = 0; i < 5; ++i) {
        const auto rim = [&](int step) { return 1 + (i + step) % 5; };
        mesh.faces.push_back({0, rim(0), rim(1)});
        mesh.faces.push_back({rim(0), rim(1), rim(3)});
    }
    const Measures m = measure_labels(mesh, std::vector<int>(10, 0), 1);
    EXPECT_EQ(m.boundary_edge_count, 0);
    EXPECT_EQ(m.bowtie_count, 0);
    EXPECT_EQ(m.disconnected_submesh_count, 0);
    EXPECT_EQ(m.disk_count, 0);
}

TEST(Measures, OpenBorderEdgesDoNotCountAsBoundaryEdges) {
    const TriangleMesh mesh = open_grid(1);
    const Measures whole = measure_labels(mesh, {0, 0}, 1);
    EXPECT_EQ(whole.boundary_edge_count, 0);
    EXPECT_EQ(whole.disk_count, 1);
    const Measures split = measure_labels(mesh, {0, 1}, 2);
    EXPECT_EQ(split.boundary_edge_count, 1);
    EXPECT_EQ(count_boundary_edges(build_dual_graph(mesh), {0, 1}), 1);
    EXPECT_DOUBLE_EQ(split.boundary_edge_ratio, 1.0 / 5.0);
    EXPECT_EQ(split.disk_count, 2);
}

TEST(Measures, AnEdgeWithThreeFacesIsOneEdgeOfTheMesh) {
    const TriangleMesh mesh = tetrahedron_with_fin();
    // Face 0 touches three others; across one of its edges lie two faces, and none is its
    // neighbour.
    const Measures m = measure_labels(mesh, {0, 1, 1, 1, 1}, 2);
    EXPECT_EQ(m.boundary_edge_count, 2);
    EXPECT_DOUBLE_EQ(m.boundary_edge_ratio, 2.0 / 8.0);
}

TEST(Measures, AnEmptySubmeshCountsInTheBalanceButIsNeitherDiskNorDisconnected) {
    const Measures m = measure_labels(tetrahedron(), {0, 0, 2, 2}, 3);
    EXPECT_EQ(m.min_submesh_triangles, 0);
    EXPECT_EQ(m.max_triangle_count_difference, 2);
    EXPECT_EQ(m.disk_count, 2);
    EXPECT_EQ(m.disconnected_submesh_count, 0);
    EXPECT_FALSE(m.is_valid());
}

/// They share vertex 0.
TriangleMesh two_tetrahedra_at_a_vertex() {
    TriangleMesh mesh = tetrahedron();
    const TriangleMesh second = tetrahedron();
    for (int v = 1; v < 4; ++v) {
        mesh.positions.push_back(second.positions[v]);
    }
    for (Triangle face : second.faces) {
        for (int& v : face) {
            v = v == 0 ? 0 : v + 3;
        }
        mesh.faces.push_back(face);
    }
    return mesh;
}

TEST(Measures, APinchOfTheInputIsNoBowtieButALostPieceIsMeasured) {
    // Of the second one only two faces have label 0.
    const TriangleMesh mesh = two_tetrahedra_at_a_vertex();
    const Measures m = measure_labels(mesh, {0, 0, 0, 0, 0, 0, 1, 1}, 2);
    EXPECT_EQ(m.bowtie_count, 0);
    EXPECT_EQ(m.disconnected_submesh_count, 1);
    EXPECT_EQ(m.disk_count, 1);
}

TEST(Measures, ADiskOfWhichTwoBorderVerticesAreOneIsStillADisk) {
    TriangleMesh mesh = open_grid(3);
    const int last = mesh.vertex_count() - 1;
    for (Triangle& face : mesh.faces) {
        std::replace(face.begin(), face.end(), last, 0);
    }
    const Measures m = measure_labels(mesh, std::vector<int>(mesh.face_count(), 0), 1);
    EXPECT_EQ(m.bowtie_count, 0);
    EXPECT_EQ(m.disk_count, 1);
}

TEST(Measures, NoFacesGiveZeros) {
    const Measures m = measure_labels({}, {}, 0);
    EXPECT_EQ(m.submesh_count, 0);
    EXPECT_EQ(m.boundary_edge_count, 0);
    const Measures empty = measure_labels({}, {}, 2);
    EXPECT_EQ(empty.coefficient_of_variation, 0.0);
    EXPECT_EQ(empty.boundary_edge_ratio, 0.0);
}

TEST(Measures, WrongSizesAndLabelsAreNamed) {
    const TriangleMesh mesh = tetrahedron();
    const DualGraph graph = build_dual_graph(mesh);
    EXPECT_THROW(measure(mesh, graph, {0, 0, 0}, 1, 1), InvalidInput);
    EXPECT_THROW(measure(mesh, graph, {0, 0, -1, 0}, 1, 1), InvalidInput);
    try {
        measure(mesh, graph, {0, 1, 2, 0}, 2, 1);
        FAIL() << "label 2 of 2 sub-meshes was accepted";
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("face 2 has label 2"), std::string::npos);
    }
}

TEST(Measures, AgreeWithARecountOnRandomLabels) {
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        if (mesh.face_count() > 700) {
            continue;
        }
        for (int k : {1, 2, 7}) {
            Random random(k);
            std::vector<int> labels(mesh.face_count());
            std::generate(labels.begin(), labels.end(), [&] { return random.below(k); });
            const Measures m = measure_labels(mesh, labels, k);
            const Recount expected(mesh, labels, k);
            SCOPED_TRACE(name + ", k = " + std::to_string(k));
            EXPECT_EQ(m.boundary_edge_count, expected.boundary_edges);
            EXPECT_EQ(count_boundary_edges(build_dual_graph(mesh), labels),
                      expected.boundary_edges);
            EXPECT_DOUBLE_EQ(m.boundary_edge_ratio,
                             static_cast<double>(expected.boundary_edges) / expected.edge_count);
            EXPECT_EQ(m.bowtie_count, expected.bowties);
            EXPECT_EQ(m.disconnected_submesh_count, expected.disconnected);
            EXPECT_EQ(m.disk_count, expected.disks);
        }
    }
}

TEST(Measures, AgreeWithARecountOnCoherentLabels) {
    // Slabs and octants: mostly disks and rings, as a segmentation has them.
    const TriangleMesh mesh = subdivide(subdivide(icosahedron()));
    for (int k : {2, 8}) {
        std::vector<int> labels;
        for (const Triangle& face : mesh.faces) {
            const Vec3& p = mesh.positions[face[0]];
            labels.push_back(k == 2 ? std::abs(p.z) < 0.5
                                    : (p.x > 0) + 2 * (p.y > 0.1) + 4 * (p.z > 0));
        }
        const Measures m = measure_labels(mesh, labels, k);
        const Recount expected(mesh, labels, k);
        EXPECT_EQ(m.boundary_edge_count, expected.boundary_edges);
        EXPECT_EQ(m.bowtie_count, expected.bowties);
        EXPECT_EQ(m.disconnected_submesh_count, expected.disconnected);
        EXPECT_EQ(m.disk_count, expected.disks);
    }
}

TEST(Measures, AreTheSameWhereOneFanPerVertexIsKnown) {
    std::vector<TriangleMesh> meshes = {torus(9, 4), grid_with_holes(12), moebius_strip(30, 5)};
    for (const auto& [name, mesh] : genus_zero_meshes()) {
        meshes.push_back(mesh);
    }
    for (const TriangleMesh& mesh : meshes) {
        const DualGraph graph = build_dual_graph(mesh);
        ASSERT_EQ(inspect(mesh, graph).fans_per_vertex(), VertexFanCount::one);
        for (int k : {1, 2, 7}) {
            Random random(k);
            std::vector<int> scattered(mesh.face_count());
            std::generate(scattered.begin(), scattered.end(), [&] { return random.below(k); });
            for (const std::vector<int>& labels :
                 {scattered, labels_by_number(mesh.face_count(), k)}) {
                expect_same(measure(mesh, graph, labels, k, 1, VertexFanCount::one),
                            measure(mesh, graph, labels, k, 1));
            }
        }
    }
}

TEST(Measures, OneFanPerVertexIsKnownOfNoPinchedMesh) {
    const TriangleMesh pinched = two_tetrahedra_at_a_vertex();
    TriangleMesh degenerate = tetrahedron();
    degenerate.faces.push_back({0, 1, 1});
    for (const TriangleMesh& mesh : {pinched, tetrahedron_with_fin(), degenerate}) {
        EXPECT_EQ(inspect(mesh, build_dual_graph(mesh)).fans_per_vertex(), VertexFanCount::unknown);
    }
}

} // namespace
} // namespace spheroseg
