// SPDX-License-Identifier: GPL-3.0-or-later
#include "recut.h"

#include "exact_cut.h"
#include "face_walk.h"
#include "submesh_faces.h"
#include "threads.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace spheroseg {

namespace {

constexpr std::uint32_t kMostSubmeshes = 5;
/// Of five steps this many lead to where others can make up for what is off.
constexpr std::uint32_t kDirectedOfFive = 4;
constexpr int kCutsPerWalk = 16;
/// A walk does not go back to the sub-meshes of so many steps before: where the ways are few, as in
/// nests of faces with one way in, it would go to and fro between two.
constexpr std::size_t kStepsRemembered = 3;
/// One of so many even cuts of smaller regions is found by a search: it takes dead ends first,
/// which random trees rarely meet. In larger ones a search is hopeless.
constexpr std::uint32_t kSearchOneOf = 8;
constexpr std::size_t kMostFacesToSearch = 200;
constexpr int kStepsPerSearch = 200;
/// A cut of a larger region counts as several.
constexpr int kFacesPerCut = 1000;
/// Distances are measured anew, which looks at all faces, between two rounds with as many faces in
/// the cuts, where a small cut counts as this many: that takes less time than the cuts.
constexpr std::int64_t kFacesOfSmallCut = 16;
/// Sub-meshes that are off meet after a number of cuts that goes as the sub-meshes per one that is
/// off; where a balance was found it rarely took more than 100 times that many. But what is close
/// to where it could be made up for, and still off after so many cuts, hardly ever gets there: on
/// long limbs it is far, elsewhere close. Of very many sub-meshes it may: the next try, which
/// shakes all of them, would take as long as ten cuts for each. Where many are off, each is to have
/// two walks on top.
constexpr std::int64_t kPatience = 100;
constexpr std::int64_t kPatienceWhenClose = 50000;
constexpr std::int64_t kPatiencePerSubmesh = 4;
constexpr std::int64_t kPatiencePerStep = 200;
constexpr std::int64_t kIdleWalks = 2;
/// Sub-meshes change places when they are cut anew, so what counts them leads astray on a way as
/// long as this, in faces; then every other walk goes by the faces, which stay where they are.
constexpr int kFar = 100;
/// About a millisecond.
constexpr std::int64_t kFacesPerReport = 20000;

class Recut {
public:
    Recut(Patchwork& patchwork,
          std::int64_t& cuts_left,
          TreeTurns turns,
          const Deadline* deadline,
          const Progress& progress,
          std::int64_t least_misplaced)
        : patchwork_(patchwork), cuts_left_(cuts_left), deadline_(deadline), progress_(progress),
          least_misplaced_(least_misplaced), even_(even_loads(patchwork)),
          tree_cut_(patchwork, turns), faces_of_(patchwork),
          unmeasured_faces_(patchwork.face_count()), is_listed_(patchwork.submesh_count(), 0) {}

    bool run() {
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            list_if_off(l);
        }
        for (std::vector<int> round = take_off(); !round.empty(); round = take_off()) {
            if (unmeasured_faces_ >= patchwork_.face_count()) {
                unmeasured_faces_ = 0;
                measure_distances(true);
                measure_distances(false);
            }
            if (cuts_left_ <= 0 || idle_cuts_ > patience(round) ||
                deviation(round) <= least_misplaced_) {
                return false;
            }
            for (int label : round) {
                if (unreported_faces_ >= kFacesPerReport) {
                    unreported_faces_ = 0;
                    report_progress(progress_, 0.0, "Balancing");
                    if (deadline_ && deadline_->expired()) {
                        return false;
                    }
                }
                walk(label);
                list_if_off(label);
            }
        }
        return true;
    }

private:
    /// Cuts that may go by without progress while these sub-meshes are off.
    std::int64_t patience(const std::vector<int>& off) const {
        std::int64_t steps = 0;
        for (int label : off) {
            steps += std::max(0, distance_[is_heavy(label)][label]);
        }
        const auto count = static_cast<std::int64_t>(off.size());
        const std::int64_t all = patchwork_.submesh_count();
        return std::min(kPatience * all / count,
                        std::max(kPatienceWhenClose, kPatiencePerSubmesh * all) +
                            kPatiencePerStep * steps) +
            kIdleWalks * kCutsPerWalk * count;
    }

    bool is_heavy(int label) const { return patchwork_.load[label] > even_.ceiling; }

    /// From a sub-mesh that is off to where that can be made up for; -1 where that can not be
    /// reached.
    int distance_in_faces(int label) const {
        const std::vector<int>& distance = face_distance_[is_heavy(label)];
        const std::vector<int>& faces = faces_of_[label];
        return distance[*std::min_element(
            faces.begin(), faces.end(), [&](int f, int g) { return distance[f] < distance[g]; })];
    }

    void list_if_off(int label) {
        if (deviation(label) > 0 && !is_listed_[label]) {
            is_listed_[label] = 1;
            listed_.push_back(label);
        }
    }

    /// The sub-meshes that are off. The list of them is empty then.
    std::vector<int> take_off() {
        std::vector<int> off;
        for (int label : listed_) {
            is_listed_[label] = 0;
            if (deviation(label) > 0) {
                off.push_back(label);
            }
        }
        listed_.clear();
        return off;
    }

    /// Faces that a sub-mesh has too many or too few.
    int deviation(int label) const { return even_.deviation(patchwork_.load[label]); }

    int deviation(const std::vector<int>& labels) const {
        int sum = 0;
        for (int label : labels) {
            sum += deviation(label);
        }
        return sum;
    }

    void walk(int label) {
        goes_by_faces_ = distance_in_faces(label) > kFar && random_.below(2) == 0;
        steps_before_.fill(-1);
        for (int i = 0; i < kCutsPerWalk && label >= 0 && deviation(label) > 0 &&
             unreported_faces_ < kFacesPerReport;
             ++i) {
            const int next = step(label);
            steps_before_[i % kStepsRemembered] = label;
            label = next;
        }
    }

    /// Cuts a sub-mesh and some beside it anew. Returns one of them that is off then; -1 if none
    /// is.
    int step(int label) {
        Region region;
        add(region, label);
        if (random_.below(5) < kDirectedOfFive && relieve(region)) {
            return one_that_is_off(region);
        }
        const std::size_t count = 2 + random_.below(kMostSubmeshes - 1);
        while (region.labels.size() < count && add(region, neighbor_of(region))) {
        }
        if (region.labels.size() > 1) {
            cut_anew(region, [&] { return cut_evenly(region); });
        } else {
            cuts_left_ = 0; // It is all there is.
        }
        return one_that_is_off(region);
    }

    int one_that_is_off(const Region& region) const {
        const auto found = std::find_if(region.labels.begin(), region.labels.end(), [&](int label) {
            return deviation(label) > 0;
        });
        return found == region.labels.end() ? -1 : *found;
    }

    /// Gives what a sub-mesh is off, or a part of it, to the neighbour that is nearest to where it
    /// can be made up for. Where the two can not be cut like that, the next one on the way gets all
    /// of it. Adds them to the region. False when neither was possible.
    bool relieve(Region& region) {
        const int label = region.labels.front();
        if (!add(region, nearest_to_goal(region))) {
            return false;
        }
        const int load = patchwork_.load[label];
        const int wanted = std::clamp(load, even_.floor, even_.ceiling);
        const int limit = load > wanted ? load - 1 : load + 1;
        if (cut_anew(region,
                     [&] { return tree_cut_.cut_in_two(region, wanted, limit, random_); })) {
            return true;
        }
        const int between = region.labels.back();
        if (!add(region, nearest_to_goal(region))) {
            return false;
        }
        const std::vector<int> sizes = {wanted,
                                        patchwork_.load[between],
                                        patchwork_.load[region.labels.back()] + load - wanted};
        return sizes.back() > 0 &&
            cut_anew(region, [&] { return tree_cut_.cut(region, sizes, random_); });
    }

    static bool has(const Region& region, int label) {
        return std::find(region.labels.begin(), region.labels.end(), label) != region.labels.end();
    }

    /// False when there is none (-1).
    bool add(Region& region, int label) {
        if (label >= 0) {
            faces_of_.add_to(region, label);
        }
        return label >= 0;
    }

    bool cut_evenly(const Region& region) {
        const bool searches =
            region.faces.size() <= kMostFacesToSearch && random_.below(kSearchOneOf) == 0;
        return (searches && spheroseg::cut_evenly(patchwork_, region, kStepsPerSearch, random_)) ||
            tree_cut_.cut(region, even_sizes(region), random_);
    }

    static std::vector<int> even_sizes(const Region& region) {
        const auto count = static_cast<int>(region.labels.size());
        std::vector<int> sizes;
        for (int i = 0; i < count; ++i) {
            sizes.push_back(share_begin(i + 1, count, static_cast<int>(region.faces.size())) -
                            share_begin(i, count, static_cast<int>(region.faces.size())));
        }
        return sizes;
    }

    template <typename Cut> bool cut_anew(const Region& region, Cut cut) {
        const auto face_count = static_cast<std::int64_t>(region.faces.size());
        const std::int64_t cuts = 1 + face_count / kFacesPerCut;
        cuts_left_ -= cuts;
        idle_cuts_ += cuts;
        unmeasured_faces_ += std::max(face_count, kFacesOfSmallCut);
        unreported_faces_ += face_count;
        const int before = deviation(region.labels);
        if (!cut()) {
            for (int label : region.labels) {
                for (int f : faces_of_[label]) {
                    patchwork_.set_label(f, label);
                }
                patchwork_.load[label] = static_cast<int>(faces_of_[label].size());
            }
            return false;
        }
        faces_of_.update(region);
        for (int label : region.labels) {
            list_if_off(label);
        }
        if (deviation(region.labels) < before) {
            idle_cuts_ = 0;
        }
        return true;
    }

    /// From each sub-mesh to the nearest one that can take a face (`outward`) or spare one, in
    /// sub-meshes; and from each face to the nearest one of those, in faces. They change while
    /// sub-meshes are cut anew, but not much.
    void measure_distances(bool outward) {
        std::vector<int>& distance = distance_[outward];
        distance.assign(patchwork_.submesh_count(), -1);
        std::vector<int> queue;
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            if (even_.room(patchwork_.load[l], outward) > 0) {
                distance[l] = 0;
                queue.push_back(l);
            }
        }
        for (std::size_t head = 0; head < queue.size(); ++head) {
            const int at = queue[head];
            for_each_face_across(at, [&](int face) {
                const int neighbor = patchwork_.label(face);
                if (distance[neighbor] < 0) {
                    distance[neighbor] = distance[at] + 1;
                    queue.push_back(neighbor);
                }
            });
        }
        std::vector<int>& of_face = face_distance_[outward];
        of_face.assign(patchwork_.face_count(), -1);
        queue.clear();
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            if (distance[patchwork_.label(f)] == 0) {
                of_face[f] = 0;
                queue.push_back(f);
            }
        }
        walk_faces(patchwork_, queue, [&](int face, int neighbor) {
            if (of_face[neighbor] >= 0) {
                return false;
            }
            of_face[neighbor] = of_face[face] + 1;
            return true;
        });
    }

    /// Each face beyond a side of a sub-mesh, for each such side.
    template <typename Visit> void for_each_face_across(int label, Visit visit) const {
        for (int f : faces_of_[label]) {
            for (const NeighborSide across : patchwork_.cells[f].side) {
                if (across >= 0 && patchwork_.label(face_of(across)) != label) {
                    visit(face_of(across));
                }
            }
        }
    }

    bool was_just_left(int label) const {
        return std::find(steps_before_.begin(), steps_before_.end(), label) != steps_before_.end();
    }

    /// Of the sub-meshes beside the last one of a region, but those that the walk has just left,
    /// the one that is nearest to where what the first one is off can be made up for; of several
    /// any; -1 when there is none.
    int nearest_to_goal(const Region& region) {
        const bool outward = is_heavy(region.labels.front());
        int nearest = -1;
        int least = 0;
        std::uint32_t count = 0;
        for_each_face_across(region.labels.back(), [&](int face) {
            const int label = patchwork_.label(face);
            if (has(region, label) || was_just_left(label)) {
                return;
            }
            const int distance =
                goes_by_faces_ ? face_distance_[outward][face] : distance_[outward][label];
            if (nearest < 0 || distance < least) {
                least = distance;
                count = 0;
            }
            if (distance == least) {
                nearest = random_.below(++count) == 0 ? label : nearest;
            }
        });
        return nearest;
    }

    /// Any sub-mesh beside a region; -1 when there is none.
    int neighbor_of(const Region& region) {
        int chosen = -1;
        std::uint32_t count = 0;
        for (int label : region.labels) {
            for_each_face_across(label, [&](int face) {
                const int neighbor = patchwork_.label(face);
                if (!has(region, neighbor) && random_.below(++count) == 0) {
                    chosen = neighbor;
                }
            });
        }
        return chosen;
    }

    Patchwork& patchwork_;
    std::int64_t& cuts_left_;
    const Deadline* const deadline_;
    const Progress& progress_;
    const std::int64_t least_misplaced_;
    const LoadRange even_;
    TreeCut tree_cut_;
    SubmeshFaces faces_of_;
    std::vector<int> distance_[2];
    std::vector<int> face_distance_[2];
    /// Does the walk?
    bool goes_by_faces_ = false;
    /// Where the walk was, in a ring; -1: nowhere.
    std::array<int, kStepsRemembered> steps_before_{};
    /// Cuts since one of them made the sub-meshes less off.
    std::int64_t idle_cuts_ = 0;
    /// Faces that were cut since the distances were measured; at first those that are due.
    std::int64_t unmeasured_faces_;
    /// Faces that were cut since progress was reported; at first those that are due.
    std::int64_t unreported_faces_ = kFacesPerReport;
    /// Sub-meshes that were off after a cut in this round.
    std::vector<int> listed_;
    std::vector<std::uint8_t> is_listed_;
    Random random_{0x7265637574ULL};
};

} // namespace

bool recut_to_balance(Patchwork& patchwork,
                      std::int64_t& cuts_left,
                      TreeTurns turns,
                      const Deadline* deadline,
                      const Progress& progress,
                      std::int64_t least_misplaced) {
    return Recut(patchwork, cuts_left, turns, deadline, progress, least_misplaced).run();
}

} // namespace spheroseg
