// SPDX-License-Identifier: GPL-3.0-or-later
#include "hierarchy.h"

#include "collapse_mesh.h"
#include "subdivision.h"
#include "threads.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <numeric>

namespace spheroseg {

namespace {

/// Vertices or faces of a round that a thread should have.
constexpr int kItemsPerThread = 2048;
constexpr int kSelectionPasses = 2;
/// Faces that fit in a cache wherever they lie.
constexpr std::size_t kLeastToMove = 8192;
/// While subdivisions are undone, vertices of more faces are targets only for what is left then:
/// for each collapse all faces of the target are looked at.
constexpr int kMaxTargetDegree = 64;
/// Holes may close where there are fewer faces for each face of a cap.
constexpr int kFacesPerCapFace = 40;

/// Which vertices a round may remove. Looser after a round that removed few.
struct Limits {
    int max_degree = 8;
    /// Over the mean weight of a star.
    double max_weight_ratio = 1.5;
    bool may_close_holes = false;

    void loosen() {
        may_close_holes = true;
        max_degree += std::min(max_degree / 2, std::numeric_limits<int>::max() - max_degree);
        max_weight_ratio *= 1.5;
    }
};

std::uint32_t mix(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7FEB352DU;
    x = (x ^ (x >> 15)) * 0x846CA68BU;
    return x ^ (x >> 16);
}

/// Rank of a vertex that is not to be removed in the running round.
constexpr std::uint64_t kClosed = std::numeric_limits<std::uint64_t>::max();

class Builder {
public:
    Builder(const TriangleMesh& mesh, const DualGraph& dual_graph, int thread_count)
        : threads_(thread_count), mesh_(mesh, dual_graph, thread_count),
          face_count_(mesh.face_count()), all_faces_(static_cast<double>(mesh_.faces.size())),
          keys_(mesh_.vertices.size()), is_selected_(mesh_.vertices.size(), 0),
          is_loser_(mesh_.vertices.size(), 0), stuck_at_(mesh_.vertices.size(), -1),
          live_faces_(mesh_.faces.size()) {
        std::iota(live_faces_.begin(), live_faces_.end(), 0);
        for (int v = 0; v < static_cast<int>(mesh_.vertices.size()); ++v) {
            if (mesh_.vertices[v].degree > 0) {
                alive_.push_back(v);
            }
        }
        result_.star_begin = {0};
        result_.round_begin = {0};
    }

    CollapseHierarchy build(const Progress& progress);

private:
    bool undo_subdivision(const Progress& progress);
    void spread_weight();
    void report(const Progress& progress) const;
    int do_round(bool may_close_holes);
    bool rank_vertices(const Limits& limits);
    void mark_losers();
    void select_winners();
    void cover_neighbors();
    void select_vertices();
    int append_round();
    void drop_removed();
    void close_ranks();
    int threads_for_items(const std::vector<int>& items) const {
        return threads_for(threads_, static_cast<std::int64_t>(items.size()), kItemsPerThread);
    }
    bool has_many_holes() const;
    void collect_base();

    int threads_;
    CollapseMesh mesh_;
    int face_count_;
    double all_faces_;
    std::vector<int> alive_;
    /// Rank of a vertex in the running round: weight of its star, then a hash; or closed.
    std::vector<std::uint64_t> keys_;
    std::vector<unsigned char> is_selected_;
    std::vector<unsigned char> is_loser_;
    /// The number of rounds done when a vertex had no target: until the next one it must not keep
    /// its neighbours from being removed.
    std::vector<int> stuck_at_;
    std::vector<int> live_faces_;
    CollapseRound round_;
    CollapseHierarchy result_;
};

/// Sets keys, and selects none; true when every vertex that is not fixed was admitted.
bool Builder::rank_vertices(const Limits& limits) {
    const int count = static_cast<int>(alive_.size());
    const double mean_weight = 3.0 * face_count_ / count;
    const double scale = 16.0 / mean_weight;
    const std::uint32_t salt = mix(static_cast<std::uint32_t>(result_.round_begin.size()));
    std::atomic<bool> complete{true};
    for_each_item(count, threads_for(threads_, count, kItemsPerThread), [&](int i) {
        const int v = alive_[i];
        const CollapseMesh::Vertex& vertex = mesh_.vertices[v];
        const bool fits = vertex.degree <= limits.max_degree &&
            vertex.weight <= limits.max_weight_ratio * mean_weight;
        const bool is_removable = mesh_.is_removable(v);
        if (!fits && is_removable) {
            complete.store(false, std::memory_order_relaxed);
        }
        is_selected_[v] = 0;
        keys_[v] = kClosed;
        if (fits && is_removable && stuck_at_[v] != result_.round_count()) {
            const std::uint64_t cost = static_cast<std::uint64_t>(vertex.weight * scale);
            keys_[v] = cost << 32 | mix(static_cast<std::uint32_t>(mesh_.vertex_name(v)) ^ salt);
        }
    });
    return complete;
}

/// Marks the open vertices that have an open neighbour of smaller key.
void Builder::mark_losers() {
    const int count = static_cast<int>(live_faces_.size());
    for_each_item(count, threads_for(threads_, count, kItemsPerThread), [&](int i) {
        const Triangle& t = mesh_.faces[live_faces_[i]].vertices;
        const std::uint64_t least = std::min({keys_[t[0]], keys_[t[1]], keys_[t[2]]});
        for (int v : t) {
            if (keys_[v] != least && keys_[v] != kClosed) {
#pragma omp atomic write
                is_loser_[v] = 1;
            }
        }
    });
}

/// Selects the open vertices that are not marked, and takes the marks away.
void Builder::select_winners() {
    const int count = static_cast<int>(alive_.size());
    for_each_item(count, threads_for(threads_, count, kItemsPerThread), [&](int i) {
        const int v = alive_[i];
        is_selected_[v] |= keys_[v] != kClosed && !is_loser_[v];
        is_loser_[v] = 0;
    });
}

/// Closes the neighbours of selected vertices.
void Builder::cover_neighbors() {
    const int count = static_cast<int>(live_faces_.size());
    for_each_item(count, threads_for(threads_, count, kItemsPerThread), [&](int i) {
        const Triangle& t = mesh_.faces[live_faces_[i]].vertices;
        if (is_selected_[t[0]] || is_selected_[t[1]] || is_selected_[t[2]]) {
            for (int v : t) {
                if (!is_selected_[v]) {
#pragma omp atomic write
                    keys_[v] = kClosed;
                }
            }
        }
    });
}

/// Puts an independent set of vertices into the round.
void Builder::select_vertices() {
    for (int pass = 0; pass < kSelectionPasses; ++pass) {
        if (pass > 0) {
            cover_neighbors();
        }
        mark_losers();
        select_winners();
    }
    round_.vertex = alive_;
    keep_items(round_.vertex, threads_for_items(alive_), [&](int v) { return is_selected_[v]; });
}

/// Appends the round's collapses to the result; returns how many there are.
int Builder::append_round() {
    const int first = result_.step_count();
    const int count = round_.size();
    std::vector<int> step_of(count, -1);
    for (int i = 0; i < count; ++i) {
        if (round_.target[i] >= 0) {
            step_of[i] = result_.step_count();
            result_.vertex.push_back(mesh_.vertex_name(round_.vertex[i]));
            result_.target.push_back(mesh_.vertex_name(round_.target[i]));
            result_.star_begin.push_back(result_.star_begin.back() + round_.star_begin[i + 1] -
                                         round_.star_begin[i]);
        }
    }
    result_.ring_vertices.resize(result_.star_begin.back());
    result_.star_faces.resize(result_.star_begin.back());
    for_each_item(count, threads_for(threads_, count, kItemsPerThread), [&](int i) {
        if (step_of[i] >= 0) {
            int to = result_.star_begin[step_of[i]];
            for (int j = round_.star_begin[i]; j < round_.star_begin[i + 1]; ++j, ++to) {
                result_.ring_vertices[to] = mesh_.vertex_name(round_.ring_vertices[j]);
                result_.star_faces[to] = mesh_.face_name(round_.star_faces[j]);
            }
            mesh_.vertices[round_.vertex[i]].degree = 0;
        }
    });
    if (result_.step_count() > first) {
        result_.round_begin.push_back(result_.step_count());
    }
    return result_.step_count() - first;
}

void Builder::drop_removed() {
    keep_items(
        alive_, threads_for_items(alive_), [&](int v) { return mesh_.vertices[v].degree > 0; });
    keep_items(live_faces_, threads_for_items(live_faces_), [&](int f) {
        return mesh_.faces[f].heir < 0;
    });
}

/// Where most faces are gone, the others move together.
void Builder::close_ranks() {
    if (mesh_.faces.size() < kLeastToMove || 2 * live_faces_.size() > mesh_.faces.size()) {
        return;
    }
    mesh_.keep(live_faces_, alive_, threads_);
    for (std::size_t i = 0; i < alive_.size(); ++i) {
        stuck_at_[i] = stuck_at_[alive_[i]];
    }
    std::iota(live_faces_.begin(), live_faces_.end(), 0);
    std::iota(alive_.begin(), alive_.end(), 0);
}

bool Builder::has_many_holes() const {
    const std::size_t cap_faces = live_faces_.size() - mesh_.count_mesh_faces(live_faces_);
    return cap_faces * kFacesPerCapFace > live_faces_.size();
}

void Builder::collect_base() {
    for (int f : live_faces_) {
        if (f >= mesh_.first_cap_face) {
            continue;
        }
        result_.base_faces.push_back(mesh_.face_name(f));
        Triangle triangle = mesh_.faces[f].vertices;
        for (int& v : triangle) {
            v = mesh_.vertex_name(v);
        }
        result_.base_triangles.push_back(triangle);
    }
}

void Builder::report(const Progress& progress) const {
    report_progress(progress,
                    1.0 - static_cast<double>(live_faces_.size()) / all_faces_,
                    "Simplifying the mesh");
}

/// Removes an independent set of ranked vertices; returns how many.
int Builder::do_round(bool may_close_holes) {
    select_vertices();
    plan_collapses(mesh_, round_, keys_, may_close_holes, threads_);
    apply_collapses(mesh_, round_, threads_);
    const int removed = append_round();
    drop_removed();
    const bool step_aside = removed == 0 || !mesh_.ends.empty();
    for (int i = 0; i < round_.size() && step_aside; ++i) {
        if (round_.target[i] < 0) {
            stuck_at_[round_.vertex[i]] = result_.round_count();
        }
    }
    return removed;
}

/// Removes the vertices that a subdivision has put on edges. False where there is none, or not all
/// of them could be removed, because some are fixed or the mesh before was none: then the rounds
/// count as any others.
bool Builder::undo_subdivision(const Progress& progress) {
    close_ranks();
    mesh_.ends = find_subdivision(mesh_, live_faces_, alive_);
    if (mesh_.ends.empty()) {
        return false;
    }
    Limits any;
    any.max_degree = std::numeric_limits<int>::max();
    any.max_weight_ratio = std::numeric_limits<double>::max();
    auto left =
        std::count_if(alive_.begin(), alive_.end(), [&](int v) { return mesh_.ends[v][0] >= 0; });
    for (int max_degree : {kMaxTargetDegree, any.max_degree}) {
        mesh_.max_target_degree = max_degree;
        // A vertex without a target gets one once a neighbour is gone, so none is left out for
        // ever.
        bool were_any = true;
        while (left > 0 && were_any) {
            report(progress);
            rank_vertices(any);
            left -= do_round(false);
            were_any = round_.size() > 0;
        }
        std::fill(stuck_at_.begin(), stuck_at_.end(), -1);
    }
    mesh_.ends.clear();
    if (left > 0) {
        return false;
    }
    spread_weight();
    result_.quartered_rounds.push_back(result_.round_count());
    return true;
}

/// Where each face stands for as many of the input.
void Builder::spread_weight() {
    for (int v : alive_) {
        mesh_.vertices[v].weight = 0;
    }
    const int count = mesh_.count_mesh_faces(live_faces_);
    for (int i = 0; i < count; ++i) {
        CollapseMesh::Face& face = mesh_.faces[live_faces_[i]];
        face.weight = face_count_ / count;
        for (int v : face.vertices) {
            mesh_.vertices[v].weight += face.weight;
        }
    }
}

CollapseHierarchy Builder::build(const Progress& progress) {
    const Limits strict;
    Limits limits;
    while (undo_subdivision(progress)) {
    }
    while (live_faces_.size() > 4) {
        report(progress);
        close_ranks();
        limits.may_close_holes = limits.may_close_holes || has_many_holes();
        const bool complete = rank_vertices(limits);
        const int vertex_count = static_cast<int>(alive_.size());
        const int removed = do_round(limits.may_close_holes);
        if (round_.vertex.empty() && complete && limits.may_close_holes) {
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
