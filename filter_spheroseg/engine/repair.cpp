// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair.h"

#include "soundness.h"

#include <algorithm>
#include <deque>
#include <utility>

namespace spheroseg {

namespace {

class Repair {
public:
    /// Sub-meshes with a non-zero entry in `sound` keep all their faces.
    Repair(Patchwork& patchwork, const std::vector<std::uint8_t>& sound)
        : patchwork_(patchwork), sound_(sound) {}

    int run() {
        keep_cores();
        fill_empty();
        grow();
        return force_rest();
    }

private:
    // While a core grows, faces that may still join sub-mesh l have the label -3 - l; -2 is what
    // lies across an open border.
    static int candidate(int label) { return -3 - label; }

    void keep_cores() {
        const int submesh_count = patchwork_.submesh_count();
        const int face_count = patchwork_.face_count();
        std::vector<int> begin(submesh_count + 1, 0);
        for (const Cell& cell : patchwork_.cells) {
            ++begin[cell.label + 1];
        }
        for (int l = 0; l < submesh_count; ++l) {
            begin[l + 1] += begin[l];
        }
        std::vector<int> faces(face_count);
        std::vector<int> fill(begin.begin(), begin.end() - 1);
        for (int f = 0; f < face_count; ++f) {
            faces[fill[patchwork_.cells[f].label]++] = f;
        }
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
            const Cell& cell = patchwork_.cells[faces[i]];
            if (std::any_of(cell.across, cell.across + 3, [&](int across) {
                    return across != cell.label;
                })) {
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

    /// Single faces as far as they go; where fronts meet, around a limb or a hole, only fans of
    /// faces close the gap between them.
    void grow_core(int seed, int label) {
        queue_.assign(1, seed);
        refused_.clear();
        take(seed, label);
        std::size_t head = 0;
        do {
            for (; head < queue_.size(); ++head) {
                for (int neighbor : patchwork_.neighbors(queue_[head])) {
                    if (neighbor < 0 || patchwork_.cells[neighbor].label != candidate(label)) {
                        continue;
                    }
                    if (may_join(patchwork_, neighbor, label)) {
                        take(neighbor, label);
                        queue_.push_back(neighbor);
                    } else {
                        refused_.push_back(neighbor);
                    }
                }
            }
            close_gaps(label);
        } while (head < queue_.size());
    }

    /// Joins fans of refused faces to the core, and appends them to the queue.
    void close_gaps(int label) {
        if (!patchwork_.may_close_rings) {
            return;
        }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < refused_.size(); ++i) {
            const int face = refused_[i];
            if (patchwork_.cells[face].label == candidate(label)) {
                if (join_fan(face, label)) {
                    queue_.insert(
                        queue_.end(), fan_.move.faces, fan_.move.faces + fan_.move.face_count);
                } else {
                    refused_[kept++] = face;
                }
            }
        }
        refused_.resize(kept);
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
        std::vector<int> free_faces;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            if (patchwork_.cells[f].label == -1) {
                free_faces.push_back(f);
            }
        }
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
        std::deque<int> queue;
        for (int f = 0; f < patchwork_.face_count(); ++f) {
            if (patchwork_.cells[f].label == -1) {
                queue.push_back(f);
            }
        }
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
    const std::vector<std::uint8_t>& sound_;
    std::vector<int> queue_;
    /// Faces that could not join the core alone.
    std::vector<int> refused_;
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
