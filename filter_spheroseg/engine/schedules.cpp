// SPDX-License-Identifier: GPL-3.0-or-later
#include "schedules.h"

#include "boundary.h"
#include "levels.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

/// Exchanges tried where boundaries are so short that it takes no time: on thin tubes a face more
/// or less in each ring decides. But no more than so many per face: a mesh may have thousands of
/// components of a few faces each.
constexpr double kLeastExchanges = 40000.0;
constexpr double kLeastExchangesPerFace = 50.0;
/// Where sub-meshes are large, up to so many times the proposals.
constexpr double kMostGrowth = 4.0;
/// So few boundary edges that these may begin hotter: they melt the boundaries, and then mend them
/// better than they were.
constexpr int kEdgesToMelt = 100;

} // namespace

double Schedules::first_proposals() const {
    return are_small ? budget.small_first_proposals : budget.first_proposals;
}

double Schedules::level_proposals(double cells_per_submesh) const {
    return share * budget.level_proposals *
        std::clamp(std::sqrt(cells_per_submesh / budget.large_submesh), 1.0, kMostGrowth);
}

double Schedules::level_work(double cells, int submesh_count) const {
    return level_proposals(cells / submesh_count) * hexagonal_edges(cells, submesh_count);
}

double
Schedules::further_proposals(double first_cells, double last_cells, int submesh_count) const {
    double proposals = 0.0;
    for (double cells = last_cells; cells > first_cells; cells *= MeshLevels::kLeastShare) {
        proposals += level_work(cells, submesh_count);
    }
    return proposals;
}

double Schedules::exchange_proposals() const {
    return are_small ? budget.small_exchange_proposals : budget.exchange_proposals;
}

double Schedules::least_exchanges(double face_count) const {
    return std::min(kLeastExchanges, kLeastExchangesPerFace * face_count);
}

double Schedules::exchange_count(double face_count, double boundary_edges) const {
    return std::max(least_exchanges(face_count), exchange_proposals() * boundary_edges);
}

AnnealSchedule Schedules::schedule_with(std::uint64_t seed) const {
    AnnealSchedule schedule;
    schedule.thread_count = thread_count;
    schedule.seed = seed;
    return schedule;
}

AnnealSchedule Schedules::first(std::uint64_t seed) const {
    AnnealSchedule schedule = schedule_with(seed);
    schedule.temperature_begin = 0.35;
    schedule.temperature_end = 0.15;
    schedule.proposals_per_face = share * first_proposals();
    schedule.phase_count = budget.first_phases;
    return schedule;
}

AnnealSchedule Schedules::next(const AnnealSchedule& schedule, const Patchwork& patchwork) const {
    AnnealSchedule next = schedule;
    next.thread_count = thread_count;
    ++next.seed;
    next.temperature_begin = 0.25;
    next.proposals_per_face = level_proposals(mean_cell_count(patchwork));
    next.phase_count = budget.level_phases;
    return next;
}

AnnealSchedule Schedules::exchanges(const Patchwork& patchwork, std::uint64_t seed) const {
    AnnealSchedule schedule = schedule_with(seed);
    schedule.temperature_begin =
        count_boundary_edges(patchwork, thread_count) < kEdgesToMelt ? 0.5 : 0.25;
    schedule.temperature_end = 0.08;
    schedule.proposals_per_face = exchange_proposals();
    schedule.least_proposals = least_exchanges(patchwork.face_count());
    schedule.phase_count = budget.level_phases;
    return schedule;
}

AnnealSchedule Schedules::mending(const Patchwork& patchwork, std::uint64_t seed) const {
    AnnealSchedule schedule = exchanges(patchwork, seed);
    schedule.temperature_begin = 0.15;
    return schedule;
}

AnnealSchedule Schedules::rounds(std::uint64_t seed) const {
    AnnealSchedule schedule = schedule_with(seed);
    schedule.temperature_begin = 0.25;
    schedule.temperature_end = 0.1;
    schedule.proposals_per_face = budget.round_proposals;
    schedule.phase_count = 8;
    schedule.round_count = budget.rounds;
    return schedule;
}

AnnealSchedule Schedules::shaking(std::uint64_t seed) const {
    AnnealSchedule schedule = schedule_with(seed);
    schedule.temperature_begin = 0.6;
    schedule.temperature_end = 0.2;
    schedule.balance_weight_begin = 0.1;
    schedule.balance_weight_end = 1.0;
    schedule.proposals_per_face = 100.0;
    schedule.phase_count = 12;
    return schedule;
}

AnnealSchedule Schedules::branches(const Patchwork& patchwork, std::uint64_t seed) const {
    AnnealSchedule schedule;
    schedule.seed = seed;
    schedule.temperature_begin = 0.3;
    schedule.temperature_end = 0.1;
    set_balance(schedule, patchwork, 10.0, 0.0);
    schedule.balance_weight_end = 1.0;
    schedule.proposals_per_face = share * budget.branch_proposals;
    schedule.phase_count = budget.level_phases;
    return schedule;
}

double hexagonal_edges(double face_count, int submesh_count) {
    return std::sqrt(1.5 * face_count * submesh_count);
}

void set_balance(AnnealSchedule& schedule, const Patchwork& patchwork, double begin, double end) {
    schedule.balance_weight_begin = begin / mean_cell_count(patchwork);
    schedule.balance_weight_end = end / mean_cell_count(patchwork);
}

} // namespace spheroseg
