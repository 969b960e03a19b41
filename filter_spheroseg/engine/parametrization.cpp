// SPDX-License-Identifier: GPL-3.0-or-later
#include "parametrization.h"

#include "errors.h"
#include "parallel_failure.h"
#include "refining_mesh.h"
#include "ring_energy.h"
#include "threads.h"

#include <algorithm>
#include <atomic>
#include <string>

namespace spheroseg {

namespace {

/// Vertices of a round that a thread should have.
constexpr int kVerticesPerThread = 512;

/// How hard a map is tried for. A larger area weight keeps triangles farther from vanishing, and
/// the map farther from conformal. The first weight lets areas vary by about 10^4, which is still
/// far from the limits of single precision; stretch, not density, spoils what is built on the map.
struct Attempt {
    double area_weight;
    int sweep_factor;
};
constexpr Attempt kAttempts[] = {{1e-8, 1}, {1e-4, 2}, {1.0, 4}};

constexpr int kInsertionRetries = 3;
constexpr int kRetrySweeps = 10;
constexpr int kInsertionIterations = 2;
constexpr double kOvershoot = 1.7;

/// Sweeps over all vertices after a round; a coarse map is cheap, and what is wrong there stays.
int sweep_count(int face_count) {
    return face_count < 4000 ? 12 : face_count < 40000 ? 6 : face_count < 400000 ? 4 : 3;
}

/// Re-inserts the vertices of a hierarchy on the sphere.
class Mapper {
public:
    Mapper(const TriangleMesh& mesh,
           const CollapseHierarchy& hierarchy,
           int thread_count,
           const Progress& progress)
        : hierarchy_(hierarchy), threads_(thread_count), progress_(progress),
          mesh_(hierarchy, mesh.face_count(), mesh.vertex_count()),
          positions_(mesh.vertex_count(), Vec3{0.0, 0.0, 1.0}) {}

    /// Returns false when some vertex found no room.
    bool run(const Attempt& attempt);
    std::vector<Vec3>& positions() { return positions_; }

private:
    /// Calls work(i, ring) for i in [begin, end), with a ring of the running thread.
    template <typename Work> void for_each_vertex(int begin, int end, const Work& work) const {
        const int threads = threads_for(threads_, end - begin, kVerticesPerThread);
        ParallelFailure failure;
        for_each_chunk(end - begin, threads, [&](int first, int last) {
            failure.guard([&] {
                VertexRing ring;
                for (int i = begin + first; i < begin + last; ++i) {
                    work(i, ring);
                }
            });
        });
        failure.rethrow();
    }

    void place_base();
    bool insert_round(int round);
    bool insert_vertex(int step, VertexRing& ring);
    void gather_rings();
    void move_vertex(int index, VertexRing& ring);
    void sweep(int count);
    void report() const {
        report_progress(progress_,
                        mesh_.live_face_count() / static_cast<double>(mesh_.faces().size()),
                        "Mapping to the sphere");
    }

    const CollapseHierarchy& hierarchy_;
    int threads_;
    const Progress& progress_;
    RefiningMesh mesh_;
    std::vector<Vec3> positions_;
    /// The removed vertices in the order of the hierarchy, then those of the base.
    std::vector<int> sweep_order_;
    std::vector<int> ring_begin_;
    std::vector<int> ring_vertices_;
    DistortionWeights weights_;
};

/// The base faces as a regular tetrahedron.
void Mapper::place_base() {
    const double s = std::sqrt(1.0 / 3.0);
    const Triangle& t = hierarchy_.base_triangles[0];
    positions_[t[0]] = {s, s, s};
    positions_[t[1]] = {s, -s, -s};
    positions_[t[2]] = {-s, s, -s};
    sweep_order_ = hierarchy_.vertex;
    sweep_order_.insert(sweep_order_.end(), t.begin(), t.end());
    for (int v : hierarchy_.base_triangles[1]) {
        if (std::find(t.begin(), t.end(), v) == t.end()) {
            positions_[v] = {-s, -s, s};
            sweep_order_.push_back(v);
        }
    }
}

bool Mapper::insert_vertex(int step, VertexRing& ring) {
    ring.clear();
    for (int j = hierarchy_.star_begin[step]; j < hierarchy_.star_begin[step + 1]; ++j) {
        ring.add(positions_[hierarchy_.ring_vertices[j]]);
    }
    Vec3& v = positions_[hierarchy_.vertex[step]];
    if (!ring.find_start(v)) {
        return false;
    }
    ring.minimize(v, weights_, kInsertionIterations);
    return true;
}

/// The stars of a round share no face, and no vertex of the round lies in another's ring.
bool Mapper::insert_round(int round) {
    const int begin = hierarchy_.round_begin[round];
    const int end = hierarchy_.round_begin[round + 1];
    std::atomic<bool> complete{true};
    for_each_vertex(begin, end, [&](int i, VertexRing& ring) {
        if (!insert_vertex(i, ring)) {
            complete = false;
        }
    });
    return complete;
}

/// Lists the neighbours of all vertices, in the order in which they are swept: walking from face to
/// face again in each sweep would cost more.
void Mapper::gather_rings() {
    const int first = hierarchy_.round_begin[mesh_.round()];
    const int count = static_cast<int>(sweep_order_.size());
    ring_begin_.resize(count + 1);
    ring_begin_[first] = 0;
    for (int i = first; i < count; ++i) {
        ring_begin_[i + 1] = ring_begin_[i] + mesh_.degree(sweep_order_[i]);
    }
    ring_vertices_.resize(ring_begin_[count]);
    for_each_item(
        count - first, threads_for(threads_, count - first, kVerticesPerThread), [&](int i) {
            int* next = &ring_vertices_[ring_begin_[first + i]];
            mesh_.for_each_in_star(sweep_order_[first + i], [&](int, int r) { *next++ = r; });
        });
}

void Mapper::move_vertex(int index, VertexRing& ring) {
    ring.clear();
    for (int j = ring_begin_[index]; j < ring_begin_[index + 1]; ++j) {
        ring.add(positions_[ring_vertices_[j]]);
    }
    ring.minimize(positions_[sweep_order_[index]], weights_, 1, kOvershoot);
}

/// Moves every vertex `count` times. Vertices that were inserted in the same round are never
/// neighbours, so that a round can be moved in parallel, with one outcome.
void Mapper::sweep(int count) {
    weights_.target_area = kSphereArea / mesh_.live_face_count();
    gather_rings();
    VertexRing base_ring;
    for (int s = 0; s < count; ++s) {
        report();
        for (int r = mesh_.round(); r < hierarchy_.round_count(); ++r) {
            const int begin = hierarchy_.round_begin[r];
            const int end = hierarchy_.round_begin[r + 1];
            for_each_vertex(begin, end, [&](int i, VertexRing& ring) { move_vertex(i, ring); });
        }
        for (std::size_t i = hierarchy_.vertex.size(); i < sweep_order_.size(); ++i) {
            move_vertex(static_cast<int>(i), base_ring);
        }
    }
}

bool Mapper::run(const Attempt& attempt) {
    weights_.area_weight = attempt.area_weight;
    place_base();
    while (mesh_.round() > 0) {
        report();
        const int next = mesh_.round() - 1;
        const int next_face_count = mesh_.live_face_count() +
            2 * (hierarchy_.round_begin[next + 1] - hierarchy_.round_begin[next]);
        weights_.target_area = kSphereArea / next_face_count;
        bool complete = insert_round(next);
        for (int i = 0; i < kInsertionRetries && !complete; ++i) {
            sweep(kRetrySweeps);
            complete = insert_round(next);
        }
        if (!complete) {
            return false;
        }
        mesh_.undo_round(threads_);
        sweep(sweep_count(mesh_.live_face_count()) * attempt.sweep_factor);
    }
    return true;
}

/// Four faces without an open side on four vertices: a tetrahedron.
bool is_tetrahedron(const std::vector<Triangle>& triangles) {
    std::vector<int> vertices;
    for (const Triangle& t : triangles) {
        vertices.insert(vertices.end(), t.begin(), t.end());
    }
    std::sort(vertices.begin(), vertices.end());
    for (const Triangle& t : triangles) {
        for (int c = 0; c < 3; ++c) {
            const auto is_opposite = [&](const Triangle& other) {
                return (other[0] == t[(c + 1) % 3] && other[1] == t[c]) ||
                    (other[1] == t[(c + 1) % 3] && other[2] == t[c]) ||
                    (other[2] == t[(c + 1) % 3] && other[0] == t[c]);
            };
            if (std::none_of(triangles.begin(), triangles.end(), is_opposite)) {
                return false;
            }
        }
    }
    return triangles.size() == 4 &&
        std::unique(vertices.begin(), vertices.end()) - vertices.begin() == 4;
}

void check_base(const CollapseHierarchy& hierarchy, int face_count) {
    // Where holes were closed there are more steps.
    const bool was_closed = face_count - 2 * hierarchy.step_count() == 4;
    if (!was_closed || !is_tetrahedron(hierarchy.base_triangles)) {
        throw InvalidInput("Expected one closed surface of genus 0, which collapses to a "
                           "tetrahedron; " +
                           std::to_string(hierarchy.base_faces.size()) +
                           " faces are left of it. Close holes, and keep one component without "
                           "handles.");
    }
}

} // namespace

Parametrization parametrize(const TriangleMesh& mesh,
                            const CollapseHierarchy& hierarchy,
                            int thread_count,
                            const Progress& progress) {
    check_base(hierarchy, mesh.face_count());
    const int threads = resolve_thread_count(thread_count);
    const Progress rising = rising_progress(progress);
    for (const Attempt& attempt : kAttempts) {
        Mapper mapper(mesh, hierarchy, threads, rising);
        if (mapper.run(attempt) && is_valid_parametrization(mesh, mapper.positions())) {
            return {std::move(mapper.positions())};
        }
    }
    throw InvalidInput("Expected a mesh that fits on the sphere in double precision; its " +
                       std::to_string(mesh.face_count()) +
                       " faces need triangles too thin for it. Simplify or remesh the mesh.");
}

} // namespace spheroseg
