// SPDX-License-Identifier: GPL-3.0-or-later
#include "validity.h"

#include "parallel_failure.h"
#include "threads.h"
#include "union_find.h"
#include "vertex_fans.h"

#include <algorithm>
#include <atomic>
#include <numeric>

namespace spheroseg {

namespace {

/// A side that the dual graph joins to nothing: of an open or over-full edge.
struct LooseSide {
    int lower_vertex;
    int upper_vertex;
    int side; // 3 * face + corner

    bool same_edge(const LooseSide& other) const {
        return lower_vertex == other.lower_vertex && upper_vertex == other.upper_vertex;
    }
};

/// The corners of a vertex: how many there are, and one of them.
struct Corners {
    int last = -1;
    int count = 0;
};

bool is_degenerate(const Triangle& face) {
    return face[0] == face[1] || face[1] == face[2] || face[2] == face[0];
}

/// True when the face has an edge from vertex a to vertex b, in this direction.
bool runs_along(const Triangle& face, int a, int b) {
    return (face[0] == a && face[1] == b) || (face[1] == a && face[2] == b) ||
        (face[2] == a && face[0] == b);
}

void note(int& count, int& first, int index) {
    if (count++ == 0 || index < first) {
        first = index;
    }
}

/// Collects what `inspect` reports; each method fills one group of fields.
class Inspection {
public:
    Inspection(const TriangleMesh& mesh, const DualGraph& dual_graph)
        : mesh_(mesh), dual_graph_(dual_graph) {}

    MeshReport run(int thread_count) {
        report_.face_count = mesh_.face_count();
        const int threads = threads_for(thread_count, mesh_.face_count(), kFacesPerThread / 4);
        ParallelFailure failure;
#pragma omp parallel sections num_threads(std::min(threads, 2))
        {
#pragma omp section
            failure.guard([&] {
                examine_faces();
                examine_vertices();
                collect_loose_sides();
                count_duplicates();
            });
#pragma omp section
            failure.guard([&] { components_ = face_components(dual_graph_); });
        }
        failure.rethrow();
        if (!have_one_fan_each(threads)) {
            number_fans();
        }
        examine_loose_edges();
        count_non_manifold_vertices();
        finish();
        return report_;
    }

private:
    void examine_faces() {
        corners_of_vertex_.assign(mesh_.positions.size(), {});
        for (int f = 0; f < mesh_.face_count(); ++f) {
            const Triangle& face = mesh_.faces[f];
            for (int c = 0; c < 3; ++c) {
                Corners& corners = corners_of_vertex_[face[c]];
                corners.last = 3 * f + c;
                ++corners.count;
            }
            if (is_degenerate(face)) {
                note(report_.degenerate_face_count, report_.first_degenerate_face, f);
            }
        }
    }

    /// Are the faces around each vertex one fan? False where a face names a vertex twice, too.
    bool have_one_fan_each(int threads) const {
        std::atomic<bool> are_single{report_.degenerate_face_count == 0};
        for_each_chunk(are_single ? mesh_.vertex_count() : 0, threads, [&](int begin, int end) {
            for (int v = begin; v < end; ++v) {
                if (!has_one_fan(corners_of_vertex_[v])) {
                    are_single = false;
                }
            }
        });
        return are_single;
    }

    /// Whether a walk around the vertex comes to all its corners.
    bool has_one_fan(const Corners& corners) const {
        if (corners.count == 0) {
            return true;
        }
        int met = 1;
        const auto follow = [&](int exit) {
            return follow_fan(mesh_, dual_graph_, corners.last, exit, [&](int) { ++met; });
        };
        const int corner = corners.last % 3;
        if (!follow(corner)) {
            follow((corner + 2) % 3);
        }
        return met == corners.count;
    }

    void examine_vertices() {
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            if (corners_of_vertex_[v].count == 0) {
                continue;
            }
            ++report_.referenced_vertex_count;
            const Vec3& p = mesh_.positions[v];
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
                note(report_.non_finite_vertex_count, report_.first_non_finite_vertex, v);
            }
        }
    }

    void collect_loose_sides() {
        int joined_sides = 0;
        for (int f = 0; f < mesh_.face_count(); ++f) {
            const Triangle& face = mesh_.faces[f];
            for (int c = 0; c < 3; ++c) {
                const int g = dual_graph_.neighbors[f][c];
                if (g >= 0) {
                    ++joined_sides;
                    if (f < g && runs_along(mesh_.faces[g], face[c], face[(c + 1) % 3])) {
                        note(report_.inconsistent_edge_count, report_.first_inconsistent_face, f);
                    }
                } else if (!is_degenerate(face)) {
                    const auto [lower, upper] = std::minmax(face[c], face[(c + 1) % 3]);
                    loose_sides_.push_back({lower, upper, 3 * f + c});
                }
            }
        }
        report_.edge_count = joined_sides / 2;
        std::sort(
            loose_sides_.begin(), loose_sides_.end(), [](const LooseSide& a, const LooseSide& b) {
                return std::array{a.lower_vertex, a.upper_vertex, a.side} <
                    std::array{b.lower_vertex, b.upper_vertex, b.side};
            });
    }

    int corner_of(int face, int vertex) const {
        return 3 * face + spheroseg::corner_of(mesh_.faces[face], vertex);
    }

    /// Numbers the fans that the dual graph joins around each vertex. Where each vertex has one,
    /// nobody asks for them: an edge with more than two faces has several at either end.
    void number_fans() {
        fan_of_corner_.assign(3 * mesh_.faces.size(), -1);
        extra_fans_.assign(mesh_.positions.size(), -1);
        VertexFans fans(mesh_, dual_graph_);
        VertexFans::Fan fan;
        for (int start = 0; start < static_cast<int>(fan_of_corner_.size()); ++start) {
            if (is_degenerate(mesh_.faces[start / 3]) || !fans.collect(start, fan)) {
                continue;
            }
            for (int corner : fan.corners) {
                fan_of_corner_[corner] = fan_count_;
            }
            ++extra_fans_[mesh_.faces[start / 3][start % 3]];
            ++fan_count_;
        }
    }

    void examine_loose_edges() {
        UnionFind components(components_.count());
        // A degenerate face is joined to no other: a component that does not count.
        report_.component_count = components_.count() - report_.degenerate_face_count;
        UnionFind fans(fan_count_);
        for (auto run = loose_sides_.begin(); run != loose_sides_.end();) {
            const auto same = [&](const LooseSide& s) { return s.same_edge(*run); };
            const auto run_end = std::find_if_not(run, loose_sides_.end(), same);
            ++report_.edge_count;
            const int face = run->side / 3;
            if (run_end - run == 1) {
                note(report_.boundary_edge_count, report_.first_boundary_face, face);
            } else if (run_end - run > 2) {
                note(report_.non_manifold_edge_count, report_.first_non_manifold_face, face);
            }
            for (auto other = run + 1; other != run_end; ++other) {
                const int other_face = other->side / 3;
                report_.component_count -=
                    components.join(components_.of_face[face], components_.of_face[other_face]);
                for (int v : {run->lower_vertex, run->upper_vertex}) {
                    extra_fans_[v] -= fans.join(fan_of_corner_[corner_of(face, v)],
                                                fan_of_corner_[corner_of(other_face, v)]);
                }
            }
            run = run_end;
        }
    }

    /// Two faces with the same vertices share three edges, and each of these joins them or is
    /// loose: two of a face's three neighbours are the same, or none. So few faces need to be
    /// compared.
    void count_duplicates() {
        std::vector<std::pair<Triangle, int>> candidates;
        for (int f = 0; f < mesh_.face_count(); ++f) {
            const auto& [a, b, c] = dual_graph_.neighbors[f];
            if (a == b || b == c || c == a) {
                Triangle vertices = mesh_.faces[f];
                std::sort(vertices.begin(), vertices.end());
                candidates.emplace_back(vertices, f);
            }
        }
        std::sort(candidates.begin(), candidates.end());
        for (std::size_t i = 1; i < candidates.size(); ++i) {
            if (candidates[i].first == candidates[i - 1].first) {
                note(report_.duplicate_face_count,
                     report_.first_duplicate_face,
                     candidates[i].second);
            }
        }
    }

    void count_non_manifold_vertices() {
        for (int v = 0; v < static_cast<int>(extra_fans_.size()); ++v) {
            if (extra_fans_[v] > 0) {
                note(report_.non_manifold_vertex_count, report_.first_non_manifold_vertex, v);
            }
        }
    }

    void finish() {
        report_.euler_characteristic = report_.referenced_vertex_count - report_.edge_count +
            report_.face_count - report_.degenerate_face_count;
        const bool surface = report_.boundary_edge_count + report_.non_manifold_edge_count +
                report_.inconsistent_edge_count + report_.non_manifold_vertex_count +
                report_.degenerate_face_count ==
            0;
        if (surface && report_.face_count > 0) {
            report_.genus = report_.component_count - report_.euler_characteristic / 2;
        }
    }

    const TriangleMesh& mesh_;
    const DualGraph& dual_graph_;
    MeshReport report_;
    std::vector<Corners> corners_of_vertex_;
    std::vector<LooseSide> loose_sides_;
    std::vector<int> fan_of_corner_;
    int fan_count_ = 0;
    /// Per vertex fans - 1; empty where all have one.
    std::vector<int> extra_fans_;
    /// Those that the dual graph joins.
    FaceComponents components_;
};

std::string counted(int count, const std::string& singular, const std::string& plural) {
    return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

std::string first_face(int face) {
    return " (first: face " + std::to_string(face) + ")";
}

std::string first_vertex(int vertex) {
    return " (first: vertex " + std::to_string(vertex) + ")";
}

/// What keeps the faces from making surfaces, and what to do; the worst first.
std::string describe_dirt(const MeshReport& r) {
    if (r.face_count == 0) {
        return "no faces. Load a triangle mesh, or make one from a point cloud with \"Surface "
               "Reconstruction: Screened Poisson\".";
    }
    if (r.non_finite_vertex_count > 0) {
        return counted(r.non_finite_vertex_count, "vertex", "vertices") +
            " with a NaN or infinite coordinate" + first_vertex(r.first_non_finite_vertex) +
            ". Delete or correct them, then apply \"Close Holes\".";
    }
    if (r.degenerate_face_count > 0) {
        return counted(r.degenerate_face_count, "face that names", "faces that name") +
            " a vertex twice" + first_face(r.first_degenerate_face) +
            ". Apply \"Remove Zero Area Faces\".";
    }
    if (r.non_manifold_edge_count > 0 && r.duplicate_face_count > 0) {
        return counted(r.duplicate_face_count, "face", "faces") +
            " with the same vertices as an earlier face" + first_face(r.first_duplicate_face) +
            ". Apply \"Remove Duplicate Faces\".";
    }
    if (r.non_manifold_edge_count > 0) {
        return counted(r.non_manifold_edge_count, "edge", "edges") + " with more than two faces" +
            first_face(r.first_non_manifold_face) + ". Apply \"Repair non Manifold Edges\".";
    }
    return {};
}

/// What keeps surfaces from being one closed one of genus 0, and what to do; the worst first.
std::string describe_shape(const MeshReport& r) {
    if (r.duplicate_face_count > 0) {
        return counted(r.duplicate_face_count, "face", "faces") +
            " with the same vertices as an earlier face" + first_face(r.first_duplicate_face) +
            ". Apply \"Remove Duplicate Faces\".";
    }
    if (r.inconsistent_edge_count > 0) {
        return counted(r.inconsistent_edge_count, "edge", "edges") +
            " between faces of opposite orientation" + first_face(r.first_inconsistent_face) +
            ". Apply \"Re-Orient all faces coherently\".";
    }
    if (r.non_manifold_vertex_count > 0) {
        return counted(r.non_manifold_vertex_count, "vertex", "vertices") +
            " where separate fans of faces touch" + first_vertex(r.first_non_manifold_vertex) +
            ". Apply \"Repair non Manifold Vertices by splitting\".";
    }
    if (r.boundary_edge_count > 0) {
        return counted(r.boundary_edge_count, "open border edge", "open border edges") +
            first_face(r.first_boundary_face) +
            ". Apply \"Merge Close Vertices\" if vertices are doubled, else \"Close Holes\".";
    }
    if (r.component_count > 1) {
        return std::to_string(r.component_count) +
            " components. Apply \"Remove Isolated pieces (wrt Face Num.)\", or segment each "
            "component as a layer of its own (\"Split in Connected Components\").";
    }
    return "genus " + std::to_string(r.genus) + " (Euler characteristic " +
        std::to_string(r.euler_characteristic) +
        ", expected 2). Cut or fill the handles and apply \"Close Holes\".";
}

} // namespace

bool MeshReport::is_closed_genus_zero() const {
    return face_count > 0 && non_finite_vertex_count == 0 && degenerate_face_count == 0 &&
        duplicate_face_count == 0 && non_manifold_edge_count == 0 && inconsistent_edge_count == 0 &&
        non_manifold_vertex_count == 0 && boundary_edge_count == 0 && component_count == 1 &&
        genus == 0;
}

VertexFanCount MeshReport::fans_per_vertex() const {
    // Fans that meet at an edge with more than two faces count as one there.
    return non_manifold_vertex_count + non_manifold_edge_count + degenerate_face_count == 0
        ? VertexFanCount::one
        : VertexFanCount::unknown;
}

MeshReport inspect(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count) {
    return Inspection(mesh, dual_graph).run(thread_count);
}

std::string closed_genus_zero_error(const MeshReport& report) {
    if (report.is_closed_genus_zero()) {
        return {};
    }
    const std::string dirt = describe_dirt(report);
    if (!dirt.empty()) {
        return "Expected one closed, consistently oriented, manifold surface of genus 0; found " +
            dirt;
    }
    return "Expected one closed, consistently oriented, manifold surface of genus 0; found " +
        describe_shape(report) + " A segmentation with method \"fast\" takes this mesh as it is.";
}

std::string surface_error(const MeshReport& report) {
    const std::string dirt = describe_dirt(report);
    return dirt.empty()
        ? dirt
        : "Expected triangles with finite corners that meet along edges of two faces at most; "
          "found " +
            dirt;
}

std::string too_many_components_error(const MeshReport& report, int submesh_count) {
    const std::string found = report.component_count == report.face_count && report.face_count > 1
        ? "a triangle soup: none of the " + std::to_string(report.face_count) +
            " faces shares an edge with another"
        : std::to_string(report.component_count) + " components";
    return "Expected at most as many components as sub-meshes (" + std::to_string(submesh_count) +
        "), since each sub-mesh is connected; found " + found +
        ". Apply \"Merge Close Vertices\" if vertices are doubled and \"Remove Isolated pieces "
        "(wrt Face Num.)\" to drop small components, or ask for more sub-meshes.";
}

} // namespace spheroseg
