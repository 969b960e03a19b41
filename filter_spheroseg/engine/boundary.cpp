// SPDX-License-Identifier: GPL-3.0-or-later
#include "boundary.h"

#include "random.h"
#include "threads.h"

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>

namespace spheroseg {

namespace {

/// Sub-meshes in a group: enough that most boundaries lie inside one, few enough to feed threads.
constexpr int kMinLabelsPerGroup = 24;
constexpr int kMaxLabelsPerGroup = 96;
constexpr int kWantedGroups = 32;
/// Numbers that different threads write are kept so far apart that they share no cache line.
constexpr int kIntsPerLine = 16;
/// Phases that use one graph of sub-meshes: which ones are neighbours changes little in between.
constexpr int kPhasesPerGraph = 4;
/// The place of a listed face that touches no other label.
constexpr int kNowhere = -1;

/// The number of sides of a face beyond which another sub-mesh lies.
int boundary_sides(const Patchwork& patchwork, int face) {
    const int label = patchwork.label(face);
    int sides = 0;
    for (int c = 0; c < 3; ++c) {
        const int across = patchwork.label_across(face, c);
        sides += across != label && across != kOpenBorder;
    }
    return sides;
}

SubmeshGraph build_submesh_graph(const Patchwork& patchwork, const std::vector<int>& faces) {
    const int submesh_count = patchwork.submesh_count();
    // So that each label's neighbours are met together.
    const FacesByLabel sorted = sort_by_label(patchwork, faces);
    SubmeshGraph graph;
    graph.begin.reserve(submesh_count + 1);
    graph.begin.push_back(0);
    std::vector<int> seen(submesh_count, -1);
    for (int l = 0; l < submesh_count; ++l) {
        seen[l] = l;
        for (int i = sorted.begin[l]; i < sorted.begin[l + 1]; ++i) {
            fetch_ahead(patchwork, sorted.faces, i);
            for (int c = 0; c < 3; ++c) {
                const int other = patchwork.label_across(sorted.faces[i], c);
                if (other != kOpenBorder && seen[other] != l) {
                    seen[other] = l;
                    graph.neighbors.push_back(other);
                }
            }
        }
        graph.begin.push_back(static_cast<int>(graph.neighbors.size()));
    }
    return graph;
}

} // namespace

BoundaryFaces::BoundaryFaces(const Patchwork& patchwork, int thread_count)
    : listed_(patchwork.face_count(), 0) {
    const int face_count = patchwork.face_count();
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
    for_each_share(face_count, threads, [&](int begin, int end) {
        for (int f = begin; f < end; ++f) {
            listed_[f] = boundary_sides(patchwork, f) > 0;
        }
    });
    for (int f = 0; f < face_count; ++f) {
        if (listed_[f]) {
            faces_.push_back(f);
        }
    }
}

std::int64_t count_boundary_edges(const Patchwork& patchwork, int thread_count) {
    std::atomic<std::int64_t> sides{0};
    const int face_count = patchwork.face_count();
    const int threads = threads_for(thread_count, face_count, kFacesPerThread);
    for_each_share(face_count, threads, [&](int begin, int end) {
        std::int64_t own = 0;
        for (int f = begin; f < end; ++f) {
            own += boundary_sides(patchwork, f);
        }
        sides += own;
    });
    return sides / 2;
}

void Grouping::regroup(const Patchwork& patchwork,
                       BoundaryFaces& boundary,
                       std::uint64_t seed,
                       int thread_count) {
    const int group_count = draw_groups(patchwork, boundary, seed);
    place_loads(patchwork.load, group_count);
    place_faces(patchwork, boundary, group_count, thread_count);
}

int Grouping::draw_groups(const Patchwork& patchwork,
                          const BoundaryFaces& boundary,
                          std::uint64_t seed) {
    const int submesh_count = patchwork.submesh_count();
    const int labels_per_group =
        std::clamp(submesh_count / kWantedGroups, kMinLabelsPerGroup, kMaxLabelsPerGroup);
    const int wanted = std::max(1, submesh_count / labels_per_group);
    group_of_label_.assign(submesh_count, wanted == 1 ? 0 : -1);
    if (wanted == 1) {
        return 1;
    }
    if (phase_++ % kPhasesPerGraph == 0) {
        graph_ = build_submesh_graph(patchwork, boundary.faces());
    }
    Random random(seed, 0x67726f7570ULL);
    std::vector<int> queue;
    queue.reserve(submesh_count);
    for (int g = 0; g < wanted; ++g) {
        const int label = static_cast<int>(random.below(submesh_count));
        if (group_of_label_[label] < 0) {
            group_of_label_[label] = g;
            queue.push_back(label);
        }
    }
    grow_groups(queue);
    int group_count = wanted;
    for (int l = 0; l < submesh_count; ++l) {
        // On another component of the surface.
        if (group_of_label_[l] < 0) {
            group_of_label_[l] = group_count++;
            queue.push_back(l);
            grow_groups(queue);
        }
    }
    return group_count;
}

void Grouping::grow_groups(std::vector<int>& queue) {
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const int label = queue[head];
        for (int i = graph_.begin[label]; i < graph_.begin[label + 1]; ++i) {
            const int other = graph_.neighbors[i];
            if (group_of_label_[other] < 0) {
                group_of_label_[other] = group_of_label_[label];
                queue.push_back(other);
            }
        }
    }
    queue.clear();
}

int Grouping::place_of(const Patchwork& patchwork, int face, int idle) const {
    const int label = patchwork.label(face);
    const int group = group_of_label_[label];
    bool touches_another = false;
    bool touches_its_group = false;
    // Without branches: which sides touch what is unpredictable.
    for (int c = 0; c < 3; ++c) {
        const int across = patchwork.label_across(face, c);
        const int other = across == kOpenBorder ? label : across;
        const bool differs = other != label;
        touches_another |= differs;
        touches_its_group |= differs & (group_of_label_[other] == group);
    }
    const int elsewhere = touches_another ? idle : kNowhere;
    return touches_its_group ? group : elsewhere;
}

void Grouping::place_faces(const Patchwork& patchwork,
                           BoundaryFaces& boundary,
                           int group_count,
                           int thread_count) {
    const std::vector<int>& faces = boundary.faces();
    const auto face_count = static_cast<int>(faces.size());
    const int threads = threads_for(thread_count, face_count, kFacesPerThread / 4);
    places_.resize(faces.size());
    faces_.resize(group_count + 1);
    // Per thread and place how many faces it has there, then where the next of them goes; with room
    // between threads, so that they do not write to the same cache lines.
    std::vector<std::vector<int>> next(threads,
                                       std::vector<int>(group_count + 1 + kIntsPerLine, 0));
    for_each_task(threads, threads, [&](int t) {
        const int end = share_begin(t + 1, threads, face_count);
        for (int i = share_begin(t, threads, face_count); i < end; ++i) {
            fetch_ahead(patchwork, faces, i);
            places_[i] = place_of(patchwork, faces[i], group_count);
            if (places_[i] == kNowhere) {
                boundary.unlist(faces[i]);
            } else {
                ++next[t][places_[i]];
            }
        }
    });
    for (int place = 0; place <= group_count; ++place) {
        int total = 0;
        for (std::vector<int>& counts : next) {
            total += std::exchange(counts[place], total);
        }
        faces_[place].resize(total);
    }
    for_each_task(threads, threads, [&](int t) {
        const int end = share_begin(t + 1, threads, face_count);
        for (int i = share_begin(t, threads, face_count); i < end; ++i) {
            if (places_[i] != kNowhere) {
                faces_[places_[i]][next[t][places_[i]]++] = faces[i];
            }
        }
    });
}

void Grouping::place_loads(const std::vector<int>& loads, int group_count) {
    std::vector<int> next(group_count + 1, 0);
    for (int group : group_of_label_) {
        ++next[group + 1];
    }
    for (int g = 0; g < group_count; ++g) {
        const int used = (next[g + 1] + kIntsPerLine - 1) / kIntsPerLine * kIntsPerLine;
        next[g + 1] = next[g] + used + kIntsPerLine;
    }
    loads_.assign(next[group_count], 0);
    slot_of_label_.resize(group_of_label_.size());
    for (std::size_t l = 0; l < group_of_label_.size(); ++l) {
        slot_of_label_[l] = next[group_of_label_[l]]++;
        loads_[slot_of_label_[l]] = loads[l];
    }
}

std::vector<int> Grouping::largest_first() const {
    std::vector<int> groups(group_count());
    std::iota(groups.begin(), groups.end(), 0);
    std::stable_sort(groups.begin(), groups.end(), [this](int a, int b) {
        return faces_[a].size() > faces_[b].size();
    });
    return groups;
}

void Grouping::collect(std::vector<int>& loads, BoundaryFaces& boundary) {
    for (std::size_t l = 0; l < slot_of_label_.size(); ++l) {
        loads[l] = loads_[slot_of_label_[l]];
    }
    boundary.faces() = faces_.back();
    for (int g = 0; g < group_count(); ++g) {
        boundary.faces().insert(boundary.faces().end(), faces_[g].begin(), faces_[g].end());
    }
}

} // namespace spheroseg
