// SPDX-License-Identifier: GPL-3.0-or-later
#include "soundness.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// Sides at the vertex at `corner` of a face across which another label or an open border lies.
int fan_ends(const Patchwork& patchwork, int face, int corner) {
    const int label = patchwork.label(face);
    return (patchwork.label_across(face, corner) != label) +
        (patchwork.label_across(face, previous_corner(corner)) != label);
}

/// More than one fan of the face's sub-mesh lies around the vertex at `corner`.
bool has_bowtie_at(const Patchwork& patchwork, int face, int corner) {
    const int label = patchwork.label(face);
    int ends = fan_ends(patchwork, face, corner);
    for (int exit : {corner, previous_corner(corner)}) {
        Step step{face, corner, exit};
        while (patchwork.neighbor(step.face, step.exit) >= 0) {
            step = patchwork.step_from(step);
            if (step.face == face) {
                return ends > 2;
            }
            if (patchwork.label(step.face) == label) {
                ends += fan_ends(patchwork, step.face, step.at);
            }
        }
    }
    return ends > 2;
}

} // namespace

std::vector<std::uint8_t> sound_submeshes(const Patchwork& patchwork) {
    std::vector<int> pieces(patchwork.submesh_count(), 0);
    std::vector<std::uint8_t> seen(patchwork.cells.size(), 0);
    std::vector<int> queue;
    for (int start = 0; start < patchwork.face_count(); ++start) {
        if (seen[start]) {
            continue;
        }
        const int label = patchwork.cells[start].label;
        ++pieces[label];
        seen[start] = 1;
        queue.assign(1, start);
        while (!queue.empty()) {
            const int face = queue.back();
            queue.pop_back();
            for (int neighbor : patchwork.neighbors(face)) {
                if (neighbor >= 0 && !seen[neighbor] && patchwork.cells[neighbor].label == label) {
                    seen[neighbor] = 1;
                    queue.push_back(neighbor);
                }
            }
        }
    }
    std::vector<std::uint8_t> sound(patchwork.submesh_count());
    for (std::size_t l = 0; l < sound.size(); ++l) {
        sound[l] = pieces[l] == 1;
    }
    for (int f = 0; f < patchwork.face_count(); ++f) {
        const int label = patchwork.cells[f].label;
        for (int c = 0; c < 3 && sound[label]; ++c) {
            if (fan_ends(patchwork, f, c) > 0 && has_bowtie_at(patchwork, f, c)) {
                sound[label] = 0;
            }
        }
    }
    return sound;
}

bool are_all_sound(const std::vector<std::uint8_t>& sound_submeshes) {
    return std::find(sound_submeshes.begin(), sound_submeshes.end(), 0) == sound_submeshes.end();
}

bool is_sound(const Patchwork& patchwork) {
    return are_all_sound(sound_submeshes(patchwork));
}

} // namespace spheroseg
