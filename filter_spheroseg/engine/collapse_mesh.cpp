// SPDX-License-Identifier: GPL-3.0-or-later
#include "collapse_mesh.h"

#include "hole_caps.h"
#include "threads.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace spheroseg {

namespace {

/// Stars that a thread should have.
constexpr int kStarsPerThread = 512;

/// Calls work(i) for i in [0, items), with as many threads as are worth waking.
template <typename Work> void for_each_of(int items, int thread_count, const Work& work) {
    for_each_item(items, threads_for(thread_count, items, kFacesPerThread), work);
}

/// True when `v` has one closed fan that holds all its faces, oriented alike.
bool has_closed_fan(const CollapseMesh& mesh, int v) {
    const int degree = mesh.vertices[v].degree;
    const int first = mesh.vertices[v].face;
    if (degree < 3) {
        return false;
    }
    int f = first;
    for (int i = 0; i < degree; ++i) {
        const int c = mesh.corner_of(f, v);
        const int shared = mesh.faces[f].vertices[(c + 2) % 3];
        f = mesh.faces[f].neighbors[(c + 2) % 3];
        if (f < 0 || mesh.faces[f].vertices[(mesh.corner_of(f, v) + 1) % 3] != shared) {
            return false;
        }
        if (f == first) {
            return i + 1 == degree;
        }
    }
    return false;
}

/// True when collapsing the star with this ring into ring[t] makes no edge that exists already, and
/// the surface is not a tetrahedron: the one where two vertices of degree three are neighbours.
bool satisfies_link_condition(const CollapseMesh& mesh, const int* ring, int degree, int t) {
    if (degree == 3) {
        return mesh.vertices[ring[t]].degree > 3;
    }
    const int before = ring[(t + degree - 1) % degree];
    const int after = ring[(t + 1) % degree];
    bool satisfied = true;
    mesh.for_each_in_star(ring[t], [&](int, int r) {
        satisfied = r == before || r == after || std::find(ring, ring + degree, r) == ring + degree;
        return satisfied;
    });
    return satisfied;
}

/// Where a subdivision is undone: false when collapsing into ring[t] would leave another vertex of
/// the subdivision with a single face in a triangle of the coarse mesh, beside the coarse edge that
/// the vertex lies on. Removing that vertex would make a face of another triangle the heir.
bool keeps_triangles(const CollapseMesh& mesh, const int* ring, int degree, int t) {
    if (mesh.ends.empty()) {
        return true;
    }
    const auto lies_between = [&](int middle, int a, int b) {
        return mesh.ends[middle] == std::array<int, 2>{a, b} ||
            mesh.ends[middle] == std::array<int, 2>{b, a};
    };
    const auto at = [&](int i) { return ring[(t + i + degree) % degree]; };
    return !(lies_between(at(1), at(0), at(2)) || lies_between(at(2), at(0), at(1)) ||
             lies_between(at(-1), at(0), at(-2)) || lies_between(at(-2), at(0), at(-1)));
}

/// Position in the ring of the allowed target of least degree, then least weight; or -1. A vertex
/// on a border collapses along a border only, and a face of the input has an heir that is one too.
int choose_target(const CollapseMesh& mesh,
                  int v,
                  const int* ring,
                  const int* faces,
                  int degree,
                  bool may_close_holes) {
    const auto is_cap = [&](int i) { return faces[(i + degree) % degree] >= mesh.first_cap_face; };
    const bool on_border =
        std::any_of(faces, faces + degree, [&](int f) { return f >= mesh.first_cap_face; });
    // A cap face whose heir is a face of the input is the last of its cap: the hole closes.
    const auto can_vanish = [&](int i, int heir) {
        return is_cap(i) ? is_cap(heir) || may_close_holes : !is_cap(heir);
    };
    const auto keeps_border = [&](int t) {
        return !on_border ||
            ((is_cap(t) || is_cap(t - 1)) && can_vanish(t, t + 1) && can_vanish(t - 1, t - 2));
    };
    // By degree, weight, number.
    using Rank = std::pair<std::int64_t, int>;
    Rank last = {-1, -1};
    // The cheap conditions: the link condition looks at the star of the target, too.
    const auto may_be_target = [&](int t) {
        return mesh.may_take(ring[t], v) && keeps_border(t) &&
            keeps_triangles(mesh, ring, degree, t);
    };
    for (;;) {
        int best = -1;
        Rank best_rank;
        for (int j = 0; j < degree; ++j) {
            const CollapseMesh::Vertex& r = mesh.vertices[ring[j]];
            const Rank rank = {static_cast<std::int64_t>(r.degree) << 32 | r.weight, ring[j]};
            if (rank > last && (best < 0 || rank < best_rank) && may_be_target(j)) {
                best = j;
                best_rank = rank;
            }
        }
        if (best < 0 || satisfies_link_condition(mesh, ring, degree, best)) {
            return best;
        }
        last = best_rank;
    }
}

/// Gathers the star of collapse i, rotated to its target.
void plan_star(CollapseMesh& mesh, CollapseRound& round, bool may_close_holes, int i) {
    const int v = round.vertex[i];
    int* const ring = &round.ring_vertices[round.star_begin[i]];
    int* const faces = &round.star_faces[round.star_begin[i]];
    int degree = 0;
    mesh.for_each_in_star(v, [&](int f, int r) {
        ring[degree] = r;
        faces[degree] = f;
        ++degree;
        return true;
    });
    const int t = choose_target(mesh, v, ring, faces, degree, may_close_holes);
    if (t < 0) {
        round.target[i] = -1;
        return;
    }
    std::rotate(ring, ring + t, ring + degree);
    std::rotate(faces, faces + t, faces + degree);
    round.target[i] = ring[0];
}

/// True when a collapse of smaller key makes an edge that collapse i would make too. Both removed
/// vertices are then neighbours of both ends of that edge, so that the other one is in the ring of
/// this one's target. Also true when both have degree three and the same ring: with both removed,
/// two faces with the same vertices would be left.
bool loses_conflict(const CollapseMesh& mesh,
                    const CollapseRound& round,
                    const std::vector<std::uint64_t>& keys,
                    int i) {
    const int t = round.target[i];
    const int degree = round.star_begin[i + 1] - round.star_begin[i];
    if (t < 0) {
        return false;
    }
    // The new edges join the target to the ring vertices except the first (the target itself), the
    // second and the last (its neighbours already).
    const int* const ring = &round.ring_vertices[round.star_begin[i]];
    bool loses = false;
    mesh.for_each_in_star(t, [&](int, int u) {
        const int other = mesh.vertices[u].slot;
        if (other < 0 || other == i || round.target[other] < 0 || keys[u] > keys[round.vertex[i]]) {
            return true;
        }
        const int other_target = round.target[other];
        const int* const begin = &round.ring_vertices[round.star_begin[other]];
        const int* const end = begin + round.star_begin[other + 1] - round.star_begin[other];
        if (degree == 3) {
            loses = end - begin == 3 && std::is_permutation(begin, end, ring);
        } else if (other_target == t) {
            loses = std::find_first_of(begin, end, ring + 2, ring + degree - 1) != end;
        } else {
            loses = std::find(ring + 2, ring + degree - 1, other_target) != ring + degree - 1;
        }
        return !loses;
    });
    return loses;
}

/// Where the two faces that a collapse removes are to be replaced as neighbours: the faces beyond
/// their outer edges, and the sides of those (-1: that face vanishes too, and its heir is meant).
struct Seam {
    std::array<int, 2> beyond;
    std::array<int, 2> side;
};

Seam find_seam(const CollapseMesh& mesh, const CollapseRound& round, int i) {
    Seam seam;
    const std::array<int, 2> vanishing = {round.star_faces[round.star_begin[i]],
                                          round.star_faces[round.star_begin[i + 1] - 1]};
    for (int k = 0; k < 2; ++k) {
        const int f = vanishing[k];
        const int g = mesh.faces[f].neighbors[(mesh.corner_of(f, round.vertex[i]) + 1) % 3];
        if (g < 0) {
            seam.beyond[k] = -1;
            seam.side[k] = -1;
        } else if (mesh.faces[g].heir >= 0) {
            seam.beyond[k] = mesh.faces[g].heir;
            seam.side[k] = -1;
        } else {
            const auto& n = mesh.faces[g].neighbors;
            seam.beyond[k] = g;
            seam.side[k] = n[0] == f ? 0 : n[1] == f ? 1 : 2;
        }
    }
    return seam;
}

void add_to_vertex(CollapseMesh& mesh, int v, int degree, int weight) {
#pragma omp atomic
    mesh.vertices[v].degree += degree;
#pragma omp atomic
    mesh.vertices[v].weight += weight;
}

/// Shares the weight of the two vanishing faces evenly among the faces that stay.
void share_weight(CollapseMesh& mesh, const int* ring, const int* faces, int degree) {
    const std::int64_t freed = mesh.faces[faces[0]].weight + mesh.faces[faces[degree - 1]].weight;
    const auto is_cap = [&](int f) { return f >= mesh.first_cap_face; };
    const auto heirs = degree - 2 - std::count_if(faces + 1, faces + degree - 1, is_cap);
    std::int64_t heir = 0;
    int kept_weight = 0;
    add_to_vertex(mesh, ring[1], -1, -mesh.faces[faces[0]].weight);
    add_to_vertex(mesh, ring[degree - 1], -1, -mesh.faces[faces[degree - 1]].weight);
    for (int j = 1; j + 1 < degree; ++j) {
        if (is_cap(faces[j])) {
            continue;
        }
        ++heir;
        const int share = static_cast<int>(freed * heir / heirs - freed * (heir - 1) / heirs);
        kept_weight += mesh.faces[faces[j]].weight;
        mesh.faces[faces[j]].weight += share;
        add_to_vertex(mesh, ring[j], 0, share);
        add_to_vertex(mesh, ring[j + 1], 0, share);
    }
    add_to_vertex(mesh, ring[0], degree - 4, kept_weight);
}

/// Atomic, as another star of the round may write to the same vertex; either face will do.
void set_face(CollapseMesh& mesh, int v, int f) {
#pragma omp atomic write
    mesh.vertices[v].face = f;
}

void apply_collapse(CollapseMesh& mesh, const CollapseRound& round, const Seam& seam, int i) {
    const int v = round.vertex[i];
    const int t = round.target[i];
    const int degree = round.star_begin[i + 1] - round.star_begin[i];
    const int* const ring = &round.ring_vertices[round.star_begin[i]];
    const int* const faces = &round.star_faces[round.star_begin[i]];
    share_weight(mesh, ring, faces, degree);
    const std::array<int, 2> heirs = {faces[1], faces[degree - 2]};
    for (int k = 0; k < 2; ++k) {
        const int c = mesh.corner_of(heirs[k], v);
        mesh.faces[heirs[k]].neighbors[k == 0 ? c : (c + 2) % 3] = seam.beyond[k];
        if (seam.side[k] >= 0) {
            mesh.faces[seam.beyond[k]].neighbors[seam.side[k]] = heirs[k];
        }
    }
    for (int j = 1; j + 1 < degree; ++j) {
        mesh.faces[faces[j]].vertices[mesh.corner_of(faces[j], v)] = t;
    }
    set_face(mesh, t, heirs[0]);
    set_face(mesh, ring[1], heirs[0]);
    set_face(mesh, ring[degree - 1], heirs[1]);
}

} // namespace

CollapseMesh::CollapseMesh(const TriangleMesh& mesh,
                           const DualGraph& dual_graph,
                           int thread_count) {
    const int face_count = mesh.face_count();
    const int vertex_count = mesh.vertex_count();
    first_cap_vertex = vertex_count;
    first_cap_face = face_count;
    faces.resize(face_count);
    vertices.assign(vertex_count, {-1, 0, 0, -1});
    for_each_of(face_count, thread_count, [&](int f) {
        faces[f] = {mesh.faces[f], dual_graph.neighbors[f], 1, -1};
    });
    for (int f = 0; f < face_count; ++f) {
        for (int v : faces[f].vertices) {
            vertices[v].face = f;
            ++vertices[v].degree;
            ++vertices[v].weight;
        }
    }
    close_holes(*this);
    is_fixed.assign(vertices.size(), 0);
    for_each_of(static_cast<int>(vertices.size()), thread_count, [&](int v) {
        is_fixed[v] = !has_closed_fan(*this, v);
    });
}

void CollapseMesh::keep(const std::vector<int>& live_faces,
                        const std::vector<int>& live_vertices,
                        int thread_count) {
    const auto kept_faces = static_cast<int>(live_faces.size());
    const auto kept_vertices = static_cast<int>(live_vertices.size());
    std::vector<int> new_face(faces.size());
    std::vector<int> new_vertex(vertices.size());
    for_each_of(kept_faces, thread_count, [&](int i) { new_face[live_faces[i]] = i; });
    for_each_of(kept_vertices, thread_count, [&](int i) { new_vertex[live_vertices[i]] = i; });

    std::vector<Face> old_faces(kept_faces);
    std::vector<int> names(kept_faces);
    old_faces.swap(faces);
    for_each_of(kept_faces, thread_count, [&](int i) {
        Face& face = faces[i] = old_faces[live_faces[i]];
        for (int& v : face.vertices) {
            v = new_vertex[v];
        }
        for (int& f : face.neighbors) {
            f = f < 0 ? f : new_face[f];
        }
        names[i] = face_name(live_faces[i]);
    });
    face_names.swap(names);

    std::vector<Vertex> old_vertices(kept_vertices);
    std::vector<char> was_fixed(kept_vertices);
    names.resize(kept_vertices);
    old_vertices.swap(vertices);
    was_fixed.swap(is_fixed);
    for_each_of(kept_vertices, thread_count, [&](int i) {
        Vertex& vertex = vertices[i] = old_vertices[live_vertices[i]];
        vertex.face = new_face[vertex.face];
        is_fixed[i] = was_fixed[live_vertices[i]];
        names[i] = vertex_name(live_vertices[i]);
    });
    vertex_names.swap(names);

    const auto count_below = [](const std::vector<int>& items, int end) {
        return static_cast<int>(std::lower_bound(items.begin(), items.end(), end) - items.begin());
    };
    first_cap_face = count_below(live_faces, first_cap_face);
    first_cap_vertex = count_below(live_vertices, first_cap_vertex);
}

void plan_collapses(CollapseMesh& mesh,
                    CollapseRound& round,
                    const std::vector<std::uint64_t>& keys,
                    bool may_close_holes,
                    int thread_count) {
    const int count = round.size();
    round.target.resize(count);
    round.star_begin.resize(count + 1);
    round.star_begin[0] = 0;
    const int threads = threads_for(thread_count, count, kStarsPerThread);
    for_each_item(count, threads, [&](int i) {
        CollapseMesh::Vertex& vertex = mesh.vertices[round.vertex[i]];
        vertex.slot = i;
        round.star_begin[i + 1] = vertex.degree;
    });
    std::partial_sum(round.star_begin.begin(), round.star_begin.end(), round.star_begin.begin());
    round.ring_vertices.resize(round.star_begin[count]);
    round.star_faces.resize(round.star_begin[count]);
    std::vector<char> loses(count);
    for_each_item(count, threads, [&](int i) { plan_star(mesh, round, may_close_holes, i); });
    for_each_item(count, threads, [&](int i) { loses[i] = loses_conflict(mesh, round, keys, i); });
    for_each_item(count, threads, [&](int i) {
        round.target[i] = loses[i] ? -1 : round.target[i];
        mesh.vertices[round.vertex[i]].slot = -1;
    });
}

void apply_collapses(CollapseMesh& mesh, const CollapseRound& round, int thread_count) {
    const int count = round.size();
    std::vector<Seam> seams(count);
    const int threads = threads_for(thread_count, count, kStarsPerThread);
    const auto each_collapse = [&](const auto& work) {
        for_each_item(count, threads, [&](int i) {
            if (round.target[i] >= 0) {
                work(i);
            }
        });
    };
    // Three steps, since the stars of two collapses may share edges: a vanishing face may lie
    // beside one that vanishes with another star.
    each_collapse([&](int i) {
        const int* const begin = &round.star_faces[round.star_begin[i]];
        const int* const end = begin + round.star_begin[i + 1] - round.star_begin[i];
        mesh.faces[begin[0]].heir = begin[1];
        mesh.faces[end[-1]].heir = end[-2];
    });
    each_collapse([&](int i) { seams[i] = find_seam(mesh, round, i); });
    each_collapse([&](int i) { apply_collapse(mesh, round, seams[i], i); });
}

} // namespace spheroseg
