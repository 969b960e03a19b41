// SPDX-License-Identifier: GPL-3.0-or-later
#include "hierarchy.h"

#include "collapse_mesh.h"
#include "threads.h"

#include <algorithm>
#include <cstdint>

namespace spheroseg {

namespace {

constexpr int kSerialSize = 4000;
constexpr int kSelectionPasses = 4;
/// With more vertices than this, a round of independent collapses leaves at least five: m vertices
/// span 2 m - 4 faces, each of which holds at most one removed vertex of degree three.
constexpr int kParallelVertexCount = 8;

/// Which vertices a round may remove. Looser after a round that removed few.
struct Limits {
    int max_degree = 8;
    /// Over the mean weight of a star.
    double max_weight_ratio = 1.5;

    void loosen() {
        max_degree += max_degree / 2;
        max_weight_ratio *= 1.5;
    }
};

std::uint32_t mix(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7FEB352DU;
    x = (x ^ (x >> 15)) * 0x846CA68BU;
    return x ^ (x >> 16);
}

enum : unsigned char { kOpen = 0, kExcluded = 255 };

class Builder {
public:
    Builder(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count)
        : threads_(thread_count), mesh_(mesh, dual_graph, thread_count),
          face_count_(mesh.face_count()), keys_(mesh.vertex_count()),
          states_(mesh.vertex_count(), kOpen) {
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            if (mesh_.vertices[v].degree > 0) {
                alive_.push_back(v);
            }
        }
        live_face_count_ = face_count_;
        result_.star_begin = {0};
        result_.round_begin = {0};
    }

    CollapseHierarchy build(const Progress& progress);

private:
    bool rank_vertices(const Limits& limits);
    void select_pass(unsigned char pass);
    void select_vertices();
    int append_round();
    void drop_removed_vertices();
    void collect_base();

    int threads_;
    CollapseMesh mesh_;
    int face_count_;
    int live_face_count_;
    std::vector<int> alive_;
    /// Rank of a vertex in the running round: weight of its star, then a hash.
    std::vector<std::uint64_t> keys_;
    /// kOpen, kExcluded, or 2 p + 1 (selected in pass p) or 2 p + 2 (next to a selected one).
    std::vector<unsigned char> states_;
    CollapseRound round_;
    CollapseHierarchy result_;
};

/// Sets keys and states; true when every vertex that is not fixed was admitted.
bool Builder::rank_vertices(const Limits& limits) {
    const int count = static_cast<int>(alive_.size());
    const double mean_weight = 3.0 * face_count_ / count;
    const double scale = 16.0 / mean_weight;
    const std::uint32_t salt = mix(static_cast<std::uint32_t>(result_.round_begin.size()));
    bool complete = true;
#pragma omp parallel for num_threads(threads_) if (count > kSerialSize) reduction(&& : complete)
    for (int i = 0; i < count; ++i) {
        const int v = alive_[i];
        CollapseMesh::Vertex& vertex = mesh_.vertices[v];
        while (mesh_.faces[vertex.face].heir >= 0) {
            vertex.face = mesh_.faces[vertex.face].heir;
        }
        const bool fits = vertex.degree <= limits.max_degree &&
            vertex.weight <= limits.max_weight_ratio * mean_weight;
        states_[v] = fits && !mesh_.is_fixed[v] ? kOpen : kExcluded;
        complete = complete && (fits || mesh_.is_fixed[v]);
        const std::uint64_t cost = static_cast<std::uint64_t>(vertex.weight * scale);
        keys_[v] = cost << 32 | mix(static_cast<std::uint32_t>(v) ^ salt);
    }
    return complete;
}

/// Selects the open vertices of least key among their open neighbours. What this pass itself has
/// decided counts as open, so that the outcome does not depend on the order of evaluation.
void Builder::select_pass(unsigned char pass) {
    const unsigned char selected = 2 * pass + 1;
    const unsigned char covered = 2 * pass + 2;
    const int count = static_cast<int>(alive_.size());
#pragma omp parallel for schedule(static) num_threads(threads_) if (count > kSerialSize)
    for (int i = 0; i < count; ++i) {
        const int v = alive_[i];
        if (states_[v] != kOpen) {
            continue;
        }
        unsigned char decision = selected;
        mesh_.for_each_in_star(v, [&](int, int r) {
            unsigned char state;
#pragma omp atomic read
            state = states_[r];
            if (state == kOpen || state == selected || state == covered) {
                if (keys_[r] < keys_[v] && decision == selected) {
                    decision = kOpen;
                }
            } else if (state % 2 == 1 && state != kExcluded) {
                decision = covered;
            }
            return decision != covered;
        });
        if (decision != kOpen) {
#pragma omp atomic write
            states_[v] = decision;
        }
    }
}

/// Puts an independent set of vertices into the round.
void Builder::select_vertices() {
    round_.vertex.clear();
    if (static_cast<int>(alive_.size()) <= kParallelVertexCount) {
        int best = -1;
        for (int v : alive_) {
            if (states_[v] == kOpen && (best < 0 || keys_[v] < keys_[best])) {
                best = v;
            }
        }
        if (best >= 0) {
            round_.vertex.push_back(best);
        }
        return;
    }
    for (int pass = 0; pass < kSelectionPasses; ++pass) {
        select_pass(static_cast<unsigned char>(pass));
    }
    for (int v : alive_) {
        if (states_[v] % 2 == 1 && states_[v] != kExcluded) {
            round_.vertex.push_back(v);
        }
    }
}

/// Appends the round's collapses to the result; returns how many there are.
int Builder::append_round() {
    const int first = result_.step_count();
    const int count = round_.size();
    std::vector<int> step_of(count, -1);
    for (int i = 0; i < count; ++i) {
        if (round_.target[i] >= 0) {
            step_of[i] = result_.step_count();
            result_.vertex.push_back(round_.vertex[i]);
            result_.target.push_back(round_.target[i]);
            result_.star_begin.push_back(result_.star_begin.back() + round_.star_begin[i + 1] -
                                         round_.star_begin[i]);
        }
    }
    result_.ring_vertices.resize(result_.star_begin.back());
    result_.star_faces.resize(result_.star_begin.back());
#pragma omp parallel for num_threads(threads_) if (count > kSerialSize)
    for (int i = 0; i < count; ++i) {
        if (step_of[i] >= 0) {
            const int from = round_.star_begin[i];
            const int degree = round_.star_begin[i + 1] - from;
            const int to = result_.star_begin[step_of[i]];
            std::copy_n(&round_.ring_vertices[from], degree, &result_.ring_vertices[to]);
            std::copy_n(&round_.star_faces[from], degree, &result_.star_faces[to]);
            mesh_.vertices[round_.vertex[i]].degree = 0;
        }
    }
    if (result_.step_count() > first) {
        result_.round_begin.push_back(result_.step_count());
    }
    return result_.step_count() - first;
}

void Builder::drop_removed_vertices() {
    alive_.erase(std::remove_if(alive_.begin(),
                                alive_.end(),
                                [&](int v) { return mesh_.vertices[v].degree == 0; }),
                 alive_.end());
}

void Builder::collect_base() {
    for (int f = 0; f < face_count_; ++f) {
        if (mesh_.faces[f].heir < 0) {
            result_.base_faces.push_back(f);
            result_.base_triangles.push_back(mesh_.faces[f].vertices);
        }
    }
}

CollapseHierarchy Builder::build(const Progress& progress) {
    const Limits strict;
    Limits limits;
    while (live_face_count_ > 4) {
        report_progress(progress,
                        1.0 - static_cast<double>(live_face_count_) / face_count_,
                        "Simplifying the mesh");
        const bool complete = rank_vertices(limits);
        select_vertices();
        plan_collapses(mesh_, round_, keys_, threads_);
        apply_collapses(mesh_, round_, threads_);
        const int vertex_count = static_cast<int>(alive_.size());
        const int removed = append_round();
        drop_removed_vertices();
        live_face_count_ -= 2 * removed;
        if (removed == 0 && complete) {
            break;
        }
        if (removed < vertex_count / 10 || removed == 0) {
            limits.loosen();
        } else {
            limits = strict;
        }
    }
    collect_base();
    return std::move(result_);
}

} // namespace

CollapseHierarchy build_hierarchy(const TriangleMesh& mesh,
                                  const DualGraph& dual_graph,
                                  int thread_count,
                                  const Progress& progress) {
    return Builder(mesh, dual_graph, resolve_thread_count(thread_count)).build(progress);
}

} // namespace spheroseg
