// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "history.h"
#include "patchwork.h"
#include "progress.h"

#include <cmath>

namespace spheroseg {

class AnnealDevice;

/// Simulated annealing of the boundaries (Kirkpatrick, Gelatt, Vecchi: Optimization by Simulated
/// Annealing, 1983). The energy is the number of boundary edges plus, for every sub-mesh,
/// balance_weight * ((load - mean load) / mean face weight)^2.
struct AnnealSchedule {
    /// Moves tried per face that touches a boundary, over all phases (of a round, if there are
    /// any).
    double proposals_per_face = 100.0;
    int phase_count = 24;
    /// At least so many proposals over all phases, however few boundary faces there are; not in
    /// rounds.
    double least_proposals = 0.0;
    /// For anneal_balanced and anneal_below only. 0: each phase draws new groups of sub-meshes.
    /// Else the number of rounds: each round draws groups and runs all phases on them; then the
    /// groups whose inner boundaries got longer are reset to their labels before the round. So what
    /// is gained in one place is kept while the search goes on elsewhere.
    int round_count = 0;
    /// In boundary edges; falls geometrically over the phases.
    double temperature_begin = 0.6;
    double temperature_end = 0.15;
    /// Rises geometrically over the phases.
    double balance_weight_begin = 0.01;
    double balance_weight_end = 0.3;
    std::uint64_t seed = 0;
    int thread_count = 0;

    /// Of a phase in [0, phase_count).
    double temperature(int phase) const {
        return between(temperature_begin, temperature_end, phase);
    }
    /// Per squared unit of load.
    double balance_weight(int phase, double mean_face_weight) const {
        return between(balance_weight_begin, balance_weight_end, phase) /
            (mean_face_weight * mean_face_weight);
    }

private:
    double between(double begin, double end, int phase) const {
        const double at = phase_count > 1 ? static_cast<double>(phase) / (phase_count - 1) : 1.0;
        return begin * std::pow(end / begin, at);
    }
};

/// What limits a run over phases, and where it reports to.
struct AnnealControl {
    /// May be null. Stops early, between two phases, when it has expired.
    const Deadline* deadline = nullptr;
    /// At most so many phases of the schedule, or rounds, are run.
    int max_phases = 1 << 30;
    Progress progress;
    /// May be null. Anneals the groups instead of the cores, with the same result.
    AnnealDevice* device = nullptr;
    /// May be null. Each phase, or round, is added to it.
    History* history = nullptr;
};

/// Moves faces between neighbouring sub-meshes; all stay connected and free of bowties. In each
/// phase the sub-meshes are parted into groups of neighbours, other ones every time; the groups
/// are worked on in parallel, and the result does not depend on the number of threads.
/// Throws Cancelled when the progress callback asks for it, DeviceError when a device fails.
void anneal(Patchwork& patchwork, const AnnealSchedule& schedule, const AnnealControl& control);

/// Annealing at exact balance, on a patchwork of unit weights whose loads differ by at most one: a
/// move is made only when that stays so, by itself or together with a move back from the other
/// sub-mesh. The balance weights of the schedule are not used.
void anneal_balanced(Patchwork& patchwork,
                     const AnnealSchedule& schedule,
                     const AnnealControl& control);

/// The same on a patchwork of any weights: a move is made only when both loads are at or below
/// `limit` afterwards, by itself or together with a move back.
void anneal_below(Patchwork& patchwork,
                  int limit,
                  const AnnealSchedule& schedule,
                  const AnnealControl& control);

} // namespace spheroseg
