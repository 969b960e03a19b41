// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <vector>

namespace spheroseg {

/// Looks for bowties in one set of faces after another, without walks around vertices.
class BowtieFinder {
public:
    /// O(F).
    explicit BowtieFinder(const Patchwork& patchwork);

    /// Has the set faces[begin, end) a bowtie? `ends(face, corner)` tells at how many of the two
    /// sides of a face at the vertex at `corner` the set ends: where it does so at more than two
    /// sides around one vertex, it has a bowtie there. O(end - begin).
    template <typename Ends>
    bool has_bowtie(const std::vector<int>& faces, std::size_t begin, std::size_t end, Ends ends) {
        bool found = false;
        for (std::size_t i = begin; i < end && !found; ++i) {
            for (int c = 0; c < 3; ++c) {
                int& sum = ends_[vertex_[3 * faces[i] + c]];
                sum += ends(faces[i], c);
                found = found || sum > 2;
            }
        }
        for (std::size_t i = begin; i < end; ++i) {
            for (int c = 0; c < 3; ++c) {
                ends_[vertex_[3 * faces[i] + c]] = 0;
            }
        }
        return found;
    }

private:
    /// For each corner (3 * face + corner) the number of its vertex.
    std::vector<int> vertex_;
    /// Sides at each vertex where the set that is looked at ends.
    std::vector<int> ends_;
};

} // namespace spheroseg
