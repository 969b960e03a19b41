// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

namespace spheroseg {

/// The iterations of a start, those of its cohesion first.
struct History {
    /// Number of boundary edges after each iteration; those of a relaxation: before it.
    std::vector<double> boundary_edges;
    std::vector<double> seconds;
    int cohesion_iterations = 0;

    int count() const { return static_cast<int>(seconds.size()); }
    int refinement_iterations() const { return count() - cohesion_iterations; }

    void add(double edges, double seconds_taken) {
        boundary_edges.push_back(edges);
        seconds.push_back(seconds_taken);
    }
};

} // namespace spheroseg
