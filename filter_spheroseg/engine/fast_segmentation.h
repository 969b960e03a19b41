// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "history.h"
#include "patchwork.h"
#include "segment.h"

namespace spheroseg {

class AnnealDevice;

/// What one component is to be cut into.
struct ComponentTask {
    int submesh_count = 1;
    /// Without weights: triangle counts that do not make the MTCD of the whole mesh larger than it
    /// has to be.
    LoadRange counts = {};
    /// One per face of the component, finite and >= 0; or empty: triangle counts are balanced.
    std::vector<double> weights;
    /// One per face, in [0, submesh_count), or -1 for none; or empty.
    std::vector<int> initial_labels;
    /// May be null. Does the annealing instead of the cores, with the same result; but not that of
    /// the trials from which the first start is chosen, nor that between tries to balance.
    AnnealDevice* device = nullptr;
};

/// The times of the stages, as they are reported.
struct StageSeconds {
    /// All that does not depend on k: the levels, and the map to the sphere where one is used.
    double parametrization = 0.0;
    /// Starts, with their trials.
    double cohesion = 0.0;
    /// Annealing and balance.
    double refinement = 0.0;

    double sum() const { return parametrization + cohesion + refinement; }
    StageSeconds& operator+=(const StageSeconds& other) {
        parametrization += other.parametrization;
        cohesion += other.cohesion;
        refinement += other.refinement;
        return *this;
    }
    StageSeconds& operator*=(double factor) {
        parametrization *= factor;
        cohesion *= factor;
        refinement *= factor;
        return *this;
    }
};

struct ComponentResult {
    /// One in [0, task.submesh_count) per face of the component.
    std::vector<int> labels;
    /// The iterations of the start whose labels these are.
    History history;
    StageSeconds seconds;
    /// All sub-meshes are connected and free of bowties and, without weights, have a triangle count
    /// that was asked for.
    bool is_valid = false;
    /// False where no cut into any number of connected sub-meshes has triangle counts that were
    /// asked for, as parts of the component hang on the rest by single edges (least_misplaced);
    /// known only where a balance was not found.
    bool may_be_as_asked = true;
};

/// The method `fast` on one component: a start on a coarse version of the mesh by recursive
/// bisection and Lloyd's relaxation of the dual graph (of few sub-meshes, the best of several
/// starts of different kinds), annealing of the boundaries on every level, exact balance by chains
/// of moves and by cutting regions anew, and exchanges at exact balance. Uses only the connectivity
/// of the mesh, never its coordinates. Every sub-mesh stays connected and free of bowties at every
/// moment; when the balance can not be reached, it is tried again from other starts, and the best
/// result is kept. With weights, the heaviest load is lowered (balance_by_weight) instead of the
/// exact balance. With initial labels, the first start is these, adopted (adopt_labels) and refined
/// on the finest level; if they are valid and balanced already, they also compete with the results.
/// Sub-meshes get the numbers that many of their faces had (rename_like).
///
/// The time limit cuts the annealing short; where there is no valid result then, one is made as
/// `draft` makes it, and its balance is searched for in up to ten times the time that it took. With
/// weights, what the limit cuts short gets a balance of twice the time that it took; where that is
/// not near, that of such a draft competes with it.
/// `whole` is the mesh that the component is where that can be mapped to the sphere, else null.
/// Throws Cancelled, DeviceError.
ComponentResult segment_component(Component& component,
                                  PreparedMesh* whole,
                                  const SegmentOptions& options,
                                  const ComponentTask& task,
                                  const Deadline& deadline,
                                  const Progress& progress);

} // namespace spheroseg
