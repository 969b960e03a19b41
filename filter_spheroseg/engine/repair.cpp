// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair.h"

#include "soundness.h"

#include <algorithm>
#include <deque>
#include <tuple>
#include <utility>

namespace spheroseg {

namespace {

class Repair {
public:
    /// Sub-meshes with a non-zero entry in `sound` keep all their faces, if the others can be
    /// repaired without.
    Repair(Patchwork& patchwork, std::vector<std::uint8_t> sound)
        : patchwork_(patchwork), sound_(std::move(sound)) {}

    int run() {
        keep_cores();
        fill_empty();
        grow();
        for (int rings = 1; rings <= kMostRings && patchwork_.may_close_rings; ++rings) {
            if (!grow_anew_around_stuck(rings)) {
                break;
            }
        }
        return force_rest();
    }

private:
    /// Of faces that are loosened.
    static constexpr int kMostRings = 3;

    void keep_cores() {
        if (patchwork_.may_close_rings) {
            keep_sound_parts();
        } else {
            keep_disks();
        }
    }

    /// Frees what hangs together with the largest piece of its sub-mesh by no edge, and the smaller
    /// fans around a vertex.
    void keep_sound_parts() {
        free_small_pieces();
        if (free_small_fans()) {
            free_small_pieces();
        }
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        for (const Cell& cell : patchwork_.cells) {
            if (cell.label >= 0) {
                patchwork_.load[cell.label] += cell.weight;
            }
        }
    }

    bool is_at_rim(int face) const {
        const Cell& cell = patchwork_.cells[face];
        return std::any_of(
            cell.across, cell.across + 3, [&](int across) { return across != cell.label; });
    }

    void free_small_pieces() {
        constexpr int kUnseen = -1;
        std::vector<int> piece(patchwork_.cells.size(), kUnseen);
        std::vector<int> sizes;
        std::vector<int> largest(patchwork_.submesh_count(), kUnseen);
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            const int label = patchwork_.label(f);
            if (piece[f] != kUnseen || label < 0) {
                continue;
            }
            const auto number = static_cast<int>(sizes.size());
            piece[f] = number;
            queue_.assign(1, f);
            for (std::size_t head = 0; head < queue_.size(); ++head) {
                for (int neighbor : patchwork_.neighbors(queue_[head])) {
                    if (neighbor >= 0 && piece[neighbor] == kUnseen &&
                        patchwork_.label(neighbor) == label) {
                        piece[neighbor] = number;
                        queue_.push_back(neighbor);
                    }
                }
            }
            sizes.push_back(static_cast<int>(queue_.size()));
            if (largest[label] == kUnseen || sizes[number] > sizes[largest[label]]) {
                largest[label] = number;
            }
        }
        queue_.clear();
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            const int label = patchwork_.label(f);
            if (label >= 0 && piece[f] != largest[label]) {
                patchwork_.set_label(f, -1);
            }
        }
    }

    /// False if there are none. Looks around each vertex once, and again where a face leaves.
    bool free_small_fans() {
        seen_corners_.assign(patchwork_.cells.size(), 0);
        queue_.clear();
        bool any = false;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            for (int c = 0; c < 3; ++c) {
                if ((seen_corners_[f] >> c & 1) == 0 && is_at_rim(f)) {
                    any = free_small_fans_around(f, c) || any;
                }
            }
        }
        while (!queue_.empty()) {
            const int face = queue_.back();
            queue_.pop_back();
            for (int c = 0; c < 3; ++c) {
                if ((seen_corners_[face] >> c & 1) == 0) {
                    free_small_fans_around(face, c);
                }
            }
        }
        return any;
    }

    /// Around the vertex at a corner of the face; queues what leaves, to look around its other
    /// vertices.
    bool free_small_fans_around(int face, int corner) {
        list_around(face, corner);
        fans_.clear();
        for (std::size_t i = 0; i < around_.size(); ++i) {
            const int label = patchwork_.label(around_[i].face);
            if (i > 0 && label == patchwork_.label(around_[i - 1].face)) {
                ++fans_.back().face_count;
            } else {
                fans_.push_back({label, static_cast<int>(i), 1});
            }
        }
        std::sort(fans_.begin(), fans_.end(), [](const RimFan& a, const RimFan& b) {
            return std::tie(a.label, b.face_count, a.begin) <
                std::tie(b.label, a.face_count, b.begin);
        });
        bool any = false;
        for (std::size_t i = 1; i < fans_.size(); ++i) {
            const RimFan& fan = fans_[i];
            if (fan.label == fans_[i - 1].label && fan.label >= 0 && !sound_[fan.label]) {
                for (int j = fan.begin; j < fan.begin + fan.face_count; ++j) {
                    const Corner& corner = around_[j];
                    patchwork_.set_label(corner.face, -1);
                    seen_corners_[corner.face] = 1 << corner.at;
                    queue_.push_back(corner.face);
                }
                any = true;
            }
        }
        return any;
    }

    /// The faces around the vertex at a corner of a face, one beside the other; the first and the
    /// last one lie on a border, or between them the label changes, if it does anywhere.
    void list_around(int face, int corner) {
        around_.clear();
        const auto list = [&](const Step& step) {
            around_.push_back({step.face, step.at});
            seen_corners_[step.face] |= 1 << step.at;
        };
        Step step{face, corner, corner};
        list(step);
        while (patchwork_.neighbor(step.face, step.exit) >= 0) {
            step = patchwork_.step_from(step);
            if (step.face == face) {
                const auto changes = std::adjacent_find(
                    around_.begin(), around_.end(), [&](const Corner& a, const Corner& b) {
                        return patchwork_.label(a.face) != patchwork_.label(b.face);
                    });
                if (changes != around_.end()) {
                    std::rotate(around_.begin(), changes + 1, around_.end());
                }
                return;
            }
            list(step);
        }
        std::reverse(around_.begin(), around_.end());
        step = {face, corner, previous_corner(corner)};
        while (patchwork_.neighbor(step.face, step.exit) >= 0) {
            step = patchwork_.step_from(step);
            list(step);
        }
    }

    /// Frees so many rings of faces around those that no sub-mesh could take, and grows the
    /// sub-meshes over them anew. False, with all as before, where that leaves no fewer such faces;
    /// and where there are none.
    bool grow_anew_around_stuck(int rings) {
        const std::vector<int> stuck = free_faces();
        if (stuck.empty()) {
            return false;
        }
        const Patchwork before = patchwork_;
        free_around(stuck, rings);
        keep_sound_parts();
        fill_empty();
        grow();
        if (free_faces().size() < stuck.size()) {
            return true;
        }
        patchwork_ = before;
        return false;
    }

    std::vector<int> free_faces() const {
        std::vector<int> faces;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            if (patchwork_.label(f) < 0) {
                faces.push_back(f);
            }
        }
        return faces;
    }

    void free_around(std::vector<int> faces, int rings) {
        std::size_t begin = 0;
        for (int ring = 0; ring < rings; ++ring) {
            for (const std::size_t end = faces.size(); begin < end; ++begin) {
                for (int c = 0; c < 3; ++c) {
                    list_around(faces[begin], c);
                    for (const Corner& corner : around_) {
                        const int label = patchwork_.label(corner.face);
                        if (label >= 0) {
                            sound_[label] = 0;
                            patchwork_.set_label(corner.face, -1);
                            faces.push_back(corner.face);
                        }
                    }
                }
            }
        }
    }

    // While a core grows, faces that may still join sub-mesh l have the label -3 - l; -2 is what
    // lies across an open border.
    static int candidate(int label) { return -3 - label; }

    /// What grows from the deepest face of each sub-mesh without closing a ring.
    void keep_disks() {
        const int submesh_count = patchwork_.submesh_count();
        const int face_count = patchwork_.face_count();
        const auto [begin, faces] = sort_by_label(patchwork_);
        std::vector<int> seeds(submesh_count, -1);
        std::vector<std::uint8_t> seen(face_count, 0);
        for (int l = 0; l < submesh_count; ++l) {
            if (!sound_[l]) {
                seeds[l] = deepest(faces, begin[l], begin[l + 1], seen);
            }
        }
        for (int f = 0; f < face_count; ++f) {
            patchwork_.set_own_label(f, candidate(patchwork_.label(f)));
        }
        patchwork_.tell_neighbors();
        std::fill(patchwork_.load.begin(), patchwork_.load.end(), 0);
        for (int l = 0; l < submesh_count; ++l) {
            if (seeds[l] >= 0) {
                grow_core(seeds[l], l);
            }
            for (int i = begin[l]; i < begin[l + 1] && sound_[l]; ++i) {
                take(faces[i], l);
            }
        }
        for (int f = 0; f < face_count; ++f) {
            patchwork_.set_own_label(f, std::max(patchwork_.label(f), -1));
        }
        patchwork_.tell_neighbors();
    }

    /// The face of a sub-mesh that is farthest from its boundary, of the component where that is
    /// largest; -1 when it is empty.
    int
    deepest(const std::vector<int>& faces, int begin, int end, std::vector<std::uint8_t>& seen) {
        queue_.clear();
        for (int i = begin; i < end; ++i) {
            if (is_at_rim(faces[i])) {
                seen[faces[i]] = 1;
                queue_.push_back(faces[i]);
            }
        }
        if (queue_.empty()) {
            return begin < end ? faces[begin] : -1;
        }
        for (std::size_t head = 0; head < queue_.size(); ++head) {
            const int label = patchwork_.label(queue_[head]);
            for (int neighbor : patchwork_.neighbors(queue_[head])) {
                if (neighbor >= 0 && !seen[neighbor] && patchwork_.label(neighbor) == label) {
                    seen[neighbor] = 1;
                    queue_.push_back(neighbor);
                }
            }
        }
        return queue_.back();
    }

    void take(int face, int label) {
        patchwork_.set_label(face, label);
        patchwork_.load[label] += patchwork_.cells[face].weight;
    }

    void grow_core(int seed, int label) {
        queue_.assign(1, seed);
        take(seed, label);
        for (std::size_t head = 0; head < queue_.size(); ++head) {
            for (int neighbor : patchwork_.neighbors(queue_[head])) {
                if (neighbor >= 0 && patchwork_.cells[neighbor].label == candidate(label) &&
                    may_join(patchwork_, neighbor, label)) {
                    take(neighbor, label);
                    queue_.push_back(neighbor);
                }
            }
        }
    }

    /// Gives sub-mesh `label` the faces around a vertex, from a face that touches it on, that have
    /// the label of that face, if that makes no bowtie.
    bool join_fan(int face, int label) {
        for (int c = 0; c < 3; ++c) {
            if (patchwork_.label_across(face, c) != label) {
                continue;
            }
            for (bool forward : {false, true}) {
                if (describe_fan(patchwork_, face, c, forward, fan_) && fan_may_join(fan_)) {
                    for (int i = 0; i < fan_.move.face_count; ++i) {
                        take(fan_.move.faces[i], label);
                    }
                    return true;
                }
            }
        }
        return false;
    }

    /// A vertex of the fan's rim that lies between two faces may touch the sub-mesh only next to
    /// an edge of the rim that does.
    bool fan_may_join(const Fan& fan) const {
        const int to = fan.move.to;
        bool previous_touches = true;
        for (int i = 0; i < fan.move.face_count; ++i) {
            const Step& step = fan.steps[i];
            const bool touches = patchwork_.label_across(step.face, next_corner(step.at)) == to;
            if (!touches && !previous_touches &&
                !no_label_around(patchwork_, step.face, step.from(), to)) {
                return false;
            }
            previous_touches = touches;
        }
        const Step& last = fan.steps[fan.move.face_count - 1];
        return previous_touches || patchwork_.label_across(last.face, last.exit) == to ||
            no_label_around(patchwork_, last.face, last.to(), to);
    }

    void fill_empty() {
        std::size_t next = 0;
        std::vector<int> free_faces = this->free_faces();
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            if (patchwork_.load[l] > 0) {
                continue;
            }
            if (next >= free_faces.size() && split_off_face(l)) {
                continue;
            }
            if (next >= free_faces.size()) {
                dissolve_largest(free_faces);
            }
            // Spread over the free faces.
            const std::size_t stride =
                std::max<std::size_t>(1, free_faces.size() / patchwork_.submesh_count());
            take(free_faces[next], l);
            next += stride;
        }
    }

    /// Frees all faces but one of the sub-mesh with the most faces.
    void dissolve_largest(std::vector<int>& free_faces) {
        std::vector<int> face_counts(patchwork_.submesh_count(), 0);
        for (const Cell& cell : patchwork_.cells) {
            if (cell.label >= 0) {
                ++face_counts[cell.label];
            }
        }
        const auto largest = static_cast<int>(
            std::max_element(face_counts.begin(), face_counts.end()) - face_counts.begin());
        bool is_first = true;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            if (patchwork_.cells[f].label == largest && !std::exchange(is_first, false)) {
                patchwork_.set_label(f, -1);
                patchwork_.load[largest] -= patchwork_.cells[f].weight;
                free_faces.push_back(f);
            }
        }
    }

    /// Gives an empty sub-mesh a face that another one can spare and stay whole. False when there
    /// is none, as in rings that are one face wide.
    bool split_off_face(int label) {
        for (int tries = 0; tries < patchwork_.face_count(); ++tries) {
            donor_ = (donor_ + 1) % patchwork_.face_count();
            if (can_spare(donor_)) {
                patchwork_.load[patchwork_.cells[donor_].label] -= patchwork_.cells[donor_].weight;
                take(donor_, label);
                return true;
            }
        }
        return false;
    }

    /// The face's sub-mesh has other faces, and at each corner where it lies between two of them
    /// they meet around the corner too.
    bool can_spare(int face) const {
        const int label = patchwork_.label(face);
        if (label < 0) {
            return false;
        }
        bool same[3];
        for (int c = 0; c < 3; ++c) {
            same[c] = patchwork_.label_across(face, c) == label;
        }
        for (int c = 0; c < 3; ++c) {
            if (same[c] && same[previous_corner(c)] &&
                !all_label_around(patchwork_, face, c, label)) {
                return false;
            }
        }
        return same[0] || same[1] || same[2];
    }

    void grow() {
        const std::vector<int> faces = free_faces();
        std::deque<int> queue(faces.begin(), faces.end());
        while (!queue.empty()) {
            const int face = queue.front();
            queue.pop_front();
            if (patchwork_.cells[face].label != -1) {
                continue;
            }
            int best = -1;
            for (int c = 0; c < 3; ++c) {
                const int label = patchwork_.label_across(face, c);
                if (label >= 0 && label != best && may_join(patchwork_, face, label) &&
                    (best < 0 || patchwork_.load[label] < patchwork_.load[best])) {
                    best = label;
                }
            }
            if (best >= 0) {
                take(face, best);
                list_free_neighbors(face, queue);
            } else if (patchwork_.may_close_rings && joins_any_fan(face)) {
                for (int i = 0; i < fan_.move.face_count; ++i) {
                    list_free_neighbors(fan_.move.faces[i], queue);
                }
            }
        }
    }

    bool joins_any_fan(int face) {
        for (int c = 0; c < 3; ++c) {
            const int label = patchwork_.label_across(face, c);
            if (label >= 0 && join_fan(face, label)) {
                return true;
            }
        }
        return false;
    }

    void list_free_neighbors(int face, std::deque<int>& queue) const {
        for (int neighbor : patchwork_.neighbors(face)) {
            if (neighbor >= 0 && patchwork_.cells[neighbor].label == -1) {
                queue.push_back(neighbor);
            }
        }
    }

    int force_rest() {
        int forced = 0;
        for (bool found = true; found;) {
            found = false;
            for (int f = 0; f < patchwork_.face_count(); ++f) {
                if (patchwork_.cells[f].label != -1) {
                    continue;
                }
                for (int c = 0; c < 3; ++c) {
                    const int label = patchwork_.label_across(f, c);
                    if (label >= 0) {
                        take(f, label);
                        ++forced;
                        found = true;
                        break;
                    }
                }
            }
        }
        return forced;
    }

    Patchwork& patchwork_;
    std::vector<std::uint8_t> sound_;
    std::vector<int> queue_;
    /// Bit c: fans around the vertex at corner c were looked at.
    std::vector<std::uint8_t> seen_corners_;
    /// Around a vertex.
    struct Corner {
        int face;
        int at;
    };
    std::vector<Corner> around_;
    struct RimFan {
        int label;
        /// In `around_`.
        int begin;
        int face_count;
    };
    std::vector<RimFan> fans_;
    Fan fan_;
    int donor_ = -1;
};

/// Returns false where they were allowed already.
bool allow_rings(Patchwork& patchwork) {
    return !std::exchange(patchwork.may_close_rings, true);
}

} // namespace

int repair(Patchwork& patchwork) {
    const std::vector<std::uint8_t> none(patchwork.submesh_count(), 0);
    const int forced = Repair(patchwork, none).run();
    patchwork.may_be_unsound = forced > 0;
    return forced > 0 && allow_rings(patchwork) ? repair(patchwork) : forced;
}

int repair_unsound(Patchwork& patchwork) {
    const std::vector<std::uint8_t> sound = sound_submeshes(patchwork);
    if (are_all_sound(sound)) {
        sum_loads(patchwork);
        patchwork.may_be_unsound = false;
        return 0;
    }
    const int forced = Repair(patchwork, sound).run();
    patchwork.may_be_unsound = forced > 0;
    return forced > 0 && allow_rings(patchwork) ? repair_unsound(patchwork) : forced;
}

} // namespace spheroseg
