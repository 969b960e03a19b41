// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair.h"

#include "disks.h"
#include "faults.h"
#include "soundness.h"

#include <algorithm>
#include <deque>
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
            free_faults(patchwork_, sound_);
        } else {
            shrink_to_disks(patchwork_, sound_);
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
        free_faults(patchwork_, sound_);
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
                    for_each_around(patchwork_, faces[begin], c, [&](int face, int) {
                        const int label = patchwork_.label(face);
                        if (label >= 0) {
                            sound_[label] = 0;
                            patchwork_.set_label(face, -1);
                            faces.push_back(face);
                        }
                    });
                }
            }
        }
    }

    void take(int face, int label) {
        patchwork_.set_label(face, label);
        patchwork_.load[label] += patchwork_.cells[face].weight;
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
            } else if (patchwork_.may_close_rings && join_fan(face)) {
                for (int i = 0; i < fan_.move.face_count; ++i) {
                    list_free_neighbors(fan_.move.faces[i], queue);
                }
            }
        }
    }

    /// Gives a sub-mesh that touches the face all free faces around a vertex, from this one on, if
    /// that makes no bowtie: `fan_`.
    bool join_fan(int face) {
        for (int c = 0; c < 3; ++c) {
            for (bool forward : {false, true}) {
                if (describe_fan(patchwork_, face, c, forward, fan_) && fan_may_join(fan_)) {
                    for (int i = 0; i < fan_.move.face_count; ++i) {
                        take(fan_.move.faces[i], fan_.move.to);
                    }
                    return true;
                }
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
