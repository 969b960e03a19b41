// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"

#include <vector>

namespace spheroseg {

/// The iterations of a start, those of its cohesion first.
struct History {
    std::vector<double> boundary_edges;
    std::vector<double> seconds;
    int cohesion_iterations = 0;
    /// The first ones, which ran on the cores whatever the device.
    int on_cores = 0;

    int count() const { return static_cast<int>(seconds.size()); }
    int refinement_iterations() const { return count() - cohesion_iterations; }

    /// Has a run over phases append its iterations here.
    void record(AnnealControl& control) {
        control.boundary_edges = &boundary_edges;
        control.seconds = &seconds;
    }
};

} // namespace spheroseg
