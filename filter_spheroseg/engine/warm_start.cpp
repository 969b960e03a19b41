// SPDX-License-Identifier: GPL-3.0-or-later
#include "warm_start.h"

#include "bisection.h"
#include "face_walk.h"
#include "repair.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <queue>
#include <tuple>

namespace spheroseg {

namespace {

/// Repairs and new shares take turns so many times at most.
constexpr int kMaxRounds = 4;
/// Loads within these factors of the mean are left to the refinement.
constexpr double kLightest = 0.5;
constexpr double kHeaviest = 2.0;
/// Load per sub-mesh where there is none.
constexpr double kDensest = 1e300;

bool is_even(const Patchwork& patchwork) {
    const double mean = mean_load(patchwork);
    return std::all_of(patchwork.load.begin(), patchwork.load.end(), [&](int load) {
        return load >= kLightest * mean && load <= kHeaviest * mean;
    });
}

/// Number of sub-meshes that the faces of each sub-mesh shall make up, k in all: near its load over
/// the mean, at most its number of faces; 0: it is dissolved.
std::vector<int> new_shares(const Patchwork& patchwork) {
    const int submesh_count = patchwork.submesh_count();
    const double mean = mean_load(patchwork);
    std::vector<int> face_counts(submesh_count, 0);
    for (const Cell& cell : patchwork.cells) {
        ++face_counts[cell.label];
    }
    std::vector<int> shares(submesh_count);
    for (int l = 0; l < submesh_count; ++l) {
        const double load = patchwork.load[l] / mean;
        // One that could be left as it is is left.
        shares[l] = load >= kLightest && load <= kHeaviest
            ? 1
            : std::min(static_cast<int>(std::lround(load)), face_counts[l]);
    }
    // One more where sub-meshes are heaviest, or one fewer where they are lightest.
    int sum = std::accumulate(shares.begin(), shares.end(), 0);
    const int step = sum < submesh_count ? 1 : -1;
    std::priority_queue<std::pair<double, int>> queue;
    const auto enter = [&](int l) {
        if (step > 0 ? shares[l] < face_counts[l] : shares[l] > 0) {
            const double density =
                shares[l] > 0 ? static_cast<double>(patchwork.load[l]) / shares[l] : kDensest;
            queue.emplace(step * density, -l);
        }
    };
    for (int l = 0; l < submesh_count; ++l) {
        enter(l);
    }
    for (; sum != submesh_count; sum += step) {
        const int l = -queue.top().second;
        queue.pop();
        shares[l] += step;
        enter(l);
    }
    return shares;
}

/// Gives every face with label -1 the label of the nearest face that has one; 0 where none has.
void spread_labels(Patchwork& patchwork) {
    std::vector<int> queue;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        if (patchwork.cells[f].label >= 0) {
            queue.push_back(f);
        }
    }
    walk_faces(patchwork, queue, [&](int face, int neighbor) {
        if (patchwork.label(neighbor) >= 0) {
            return false;
        }
        patchwork.set_own_label(neighbor, patchwork.label(face));
        return true;
    });
    for (int f = 0; f < patchwork.face_count(); ++f) {
        patchwork.set_own_label(f, std::max(patchwork.label(f), 0));
    }
    patchwork.tell_neighbors();
    sum_loads(patchwork);
}

/// Parts the faces of one sub-mesh into `labels.size()` sub-meshes with these labels.
void part_submesh(Patchwork& patchwork,
                  const std::vector<int>& faces,
                  const std::vector<int>& labels,
                  std::vector<int>& place,
                  std::uint64_t seed,
                  const Progress& progress) {
    Patchwork part;
    for (std::size_t i = 0; i < faces.size(); ++i) {
        place[faces[i]] = static_cast<int>(i);
    }
    for (int f : faces) {
        Cell cell = patchwork.cells[f];
        for (NeighborSide& side : cell.side) {
            const int at = side < 0 ? -1 : place[face_of(side)];
            side = at < 0 ? -1 : make_side(at, corner_of(side), is_turned(side));
        }
        part.cells.push_back(cell);
    }
    bisect(part, static_cast<int>(labels.size()), seed, 1, progress);
    for (std::size_t i = 0; i < faces.size(); ++i) {
        patchwork.set_own_label(faces[i], labels[part.label(static_cast<int>(i))]);
        place[faces[i]] = -1;
    }
}

/// Dissolves sub-meshes that are too light and parts those that are too heavy.
void share_anew(Patchwork& patchwork, std::uint64_t seed, const Progress& progress) {
    const int submesh_count = patchwork.submesh_count();
    const std::vector<int> shares = new_shares(patchwork);
    std::vector<std::vector<int>> to_part(submesh_count);
    for (int f = 0; f < patchwork.face_count(); ++f) {
        Cell& cell = patchwork.cells[f];
        if (shares[cell.label] > 1) {
            to_part[cell.label].push_back(f);
        }
    }
    std::vector<int> place(patchwork.face_count(), -1);
    int next_free = 0;
    for (int f = 0; f < patchwork.face_count(); ++f) {
        const int label = patchwork.label(f);
        patchwork.set_own_label(f, shares[label] > 0 ? label : -1);
    }
    for (int l = 0; l < submesh_count; ++l) {
        if (shares[l] < 2) {
            continue;
        }
        std::vector<int> labels(1, l);
        while (static_cast<int>(labels.size()) < shares[l]) {
            while (shares[next_free] > 0) {
                ++next_free;
            }
            labels.push_back(next_free++);
        }
        part_submesh(patchwork, to_part[l], labels, place, seed, progress);
    }
    spread_labels(patchwork);
}

/// In increasing order.
std::vector<int> distinct_labels(const std::vector<int>& labels) {
    std::vector<int> distinct;
    // Neighbours often follow each other, which leaves little to sort.
    std::unique_copy(labels.begin(), labels.end(), std::back_inserter(distinct));
    std::sort(distinct.begin(), distinct.end());
    distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
    return distinct;
}

/// The faces with one label in both of two labellings.
struct Overlap {
    int label;
    int name;
    int face_count;
};

/// Overlaps with at least one face. Faces whose name is negative are left out.
std::vector<Overlap> overlaps_of(const std::vector<int>& labels, const std::vector<int>& names) {
    // Neighbours often follow each other, so that these are much fewer than the faces.
    std::vector<Overlap> runs;
    for (std::size_t f = 0; f < labels.size(); ++f) {
        if (names[f] < 0) {
            continue;
        }
        if (runs.empty() || runs.back().label != labels[f] || runs.back().name != names[f]) {
            runs.push_back({labels[f], names[f], 0});
        }
        ++runs.back().face_count;
    }
    std::sort(runs.begin(), runs.end(), [](const Overlap& a, const Overlap& b) {
        return std::tie(a.label, a.name) < std::tie(b.label, b.name);
    });
    std::vector<Overlap> overlaps;
    for (const Overlap& run : runs) {
        if (overlaps.empty() || overlaps.back().label != run.label ||
            overlaps.back().name != run.name) {
            overlaps.push_back({run.label, run.name, 0});
        }
        overlaps.back().face_count += run.face_count;
    }
    return overlaps;
}

} // namespace

void adopt_labels(Patchwork& patchwork, std::uint64_t seed, const Progress& progress) {
    // How much there is to part and to repair shows only on the way.
    const Progress still = sub_progress(progress, 0.0, 0.0);
    const auto repair_next = [&] {
        report_progress(still, 0.0, "Initial labels");
        repair_unsound(patchwork);
        report_progress(still, 0.0, "Initial labels");
    };
    spread_labels(patchwork);
    if (*std::min_element(patchwork.load.begin(), patchwork.load.end()) == 0) {
        share_anew(patchwork, seed + kMaxRounds, still);
    }
    repair_next();
    for (int round = 0; round < kMaxRounds && !is_even(patchwork); ++round) {
        share_anew(patchwork, seed + static_cast<std::uint64_t>(round), still);
        repair_next();
    }
}

void rename_like(std::vector<int>& labels, const std::vector<int>& names, int submesh_count) {
    std::vector<Overlap> overlaps = overlaps_of(labels, names);
    // Of equal ones those first that are named so already, so that naming twice changes nothing.
    std::stable_sort(overlaps.begin(), overlaps.end(), [](const Overlap& a, const Overlap& b) {
        return a.face_count != b.face_count ? a.face_count > b.face_count
                                            : (a.label == a.name) > (b.label == b.name);
    });
    std::vector<int> name_of(submesh_count, -1);
    std::vector<std::uint8_t> used(submesh_count, 0);
    for (const auto& [label, name, face_count] : overlaps) {
        if (name_of[label] < 0 && !used[name]) {
            name_of[label] = name;
            used[name] = 1;
        }
    }
    int next_free = 0;
    for (int& name : name_of) {
        while (name < 0) {
            if (!used[next_free]) {
                name = next_free;
            }
            ++next_free;
        }
    }
    for (int& label : labels) {
        label = name_of[label];
    }
}

std::vector<int> compacted(const std::vector<int>& labels) {
    const std::vector<int> distinct = distinct_labels(labels);
    std::vector<int> result(labels.size());
    for (std::size_t f = 0; f < labels.size(); ++f) {
        result[f] = static_cast<int>(std::lower_bound(distinct.begin(), distinct.end(), labels[f]) -
                                     distinct.begin());
    }
    return result;
}

int distinct_label_count(const std::vector<int>& labels) {
    return static_cast<int>(distinct_labels(labels).size());
}

} // namespace spheroseg
