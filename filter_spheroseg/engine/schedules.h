// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "anneal.h"
#include "budget.h"

namespace spheroseg {

/// Makes the schedules of all annealings of `fast` from a budget.
struct Schedules {
    Budget budget;
    /// Are sub-meshes so small that fewer proposals per boundary face suffice?
    bool are_small = false;
    int thread_count = 0;
    /// Factor on the proposals of the levels: below 1 in trials, above 1 where one start gets the
    /// time of several.
    double share = 1.0;

    /// Per boundary face on the first level, without `share`.
    double first_proposals() const;
    /// Roughly the number of proposals on a further level with so many cells.
    double level_work(double cells, int submesh_count) const;
    /// The sum of level_work over all further levels, from a first one with `first_cells` up to one
    /// with `last_cells`.
    double further_proposals(double first_cells, double last_cells, int submesh_count) const;
    /// Number of exchanges at so many faces and boundary edges.
    double exchange_count(double face_count, double boundary_edges) const;

    /// On the first level.
    AnnealSchedule first(std::uint64_t seed) const;
    /// On a further level, that of the patchwork.
    AnnealSchedule next(const AnnealSchedule& schedule, const Patchwork& patchwork) const;
    /// Exchanges at exact balance, or below a limit of loads.
    AnnealSchedule exchanges(const Patchwork& patchwork, std::uint64_t seed) const;
    /// The same, so cool that boundaries stay where they are, for good ones that balancing has
    /// hurt.
    AnnealSchedule mending(const Patchwork& patchwork, std::uint64_t seed) const;
    /// Exchanges in rounds.
    AnnealSchedule rounds(std::uint64_t seed) const;
    /// For anneal_branches, where the annealing of single faces and fans is stuck out of balance.
    AnnealSchedule branches(const Patchwork& patchwork, std::uint64_t seed) const;
    /// Shakes boundaries with a strong pull towards balance.
    AnnealSchedule shaking(std::uint64_t seed) const;

private:
    AnnealSchedule schedule_with(std::uint64_t seed) const;
    /// Per boundary face of a further level. The boundaries of large sub-meshes are a small part of
    /// their cells, and there is more to straighten.
    double level_proposals(double cells_per_submesh) const;
    double exchange_proposals() const;
    double least_exchanges(double face_count) const;
};

/// Number of boundary edges of `submesh_count` hexagonal patches of equilateral triangles that have
/// `face_count` faces in all: sqrt(6 F k) / 2.
double hexagonal_edges(double face_count, int submesh_count);

/// Sets the balance weights of a schedule to `begin` and `end` over the mean number of cells of a
/// sub-mesh, so that the relative deviation of the loads does not depend on the size of the
/// sub-meshes: at 0.5 to 10 it is some per cent.
void set_balance(AnnealSchedule& schedule, const Patchwork& patchwork, double begin, double end);

} // namespace spheroseg
