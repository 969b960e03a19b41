// SPDX-License-Identifier: GPL-3.0-or-later
#include "fast_plan.h"

#include "levels.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

/// The start is made on a mesh with about so many faces per sub-mesh ...
constexpr std::int64_t kCoarseFacesPerSubmesh = 60;
/// ... and at least so many in all, and so many for each face of the coarsest level, if there is
/// such a level. Where that has many faces, all of them are around handles, and hardly a sub-mesh
/// fits in between.
constexpr int kMinCoarseFaces = 240;
constexpr std::int64_t kFacesPerCoarsest = 2;
/// Per sub-mesh fewer do where that level is what undone subdivisions leave.
constexpr std::int64_t kQuarteredFacesPerSubmesh = 24;
/// Faces from which on a sub-mesh is not small.
constexpr int kSmallSubmesh = 86;
/// On a first level that has fewer than one of so many faces there is time for more relaxations, up
/// to so many times those of the budget.
constexpr std::int64_t kCoarsening = 4;
constexpr std::int64_t kMoreRelaxations = 4;
/// From here on the sphere is as good a start as the graph, and another one; below, limbs stretch
/// on the sphere too much.
constexpr int kManySubmeshes = 50;
/// Measured on two cores, in microseconds: building the levels, or the finest one alone, per face;
/// a proposal; an iteration of relaxation, carrying labels to finer levels, and what follows the
/// exchanges, per face.
constexpr double kAllLevels = 0.45;
constexpr double kFinestLevel = 0.15;
constexpr double kProposal = 0.1;
constexpr double kRelaxation = 0.02;
constexpr double kUncoarsening = 0.1;
constexpr double kFinish = 0.05;

} // namespace

FastPlan::FastPlan(int face_count,
                   int submesh_count,
                   bool by_weight,
                   bool has_sphere,
                   Effort effort,
                   int thread_count)
    : face_count_(face_count), submesh_count_(submesh_count), by_weight_(by_weight),
      has_sphere_(has_sphere), thread_count_(thread_count), first_face_count_(coarse_face_count()) {
    set_effort(effort);
}

void FastPlan::set_effort(Effort effort) {
    const bool are_small = face_count_ < std::int64_t{kSmallSubmesh} * submesh_count_;
    schedules_ = {
        budget_of(are_single_or_pairs() ? Effort::draft : effort), are_small, thread_count_};
    start_count_ = schedules_.budget.starts;
    const bool is_another_on_sphere = has_sphere_ && coarsens() && submesh_count_ >= kManySubmeshes;
    if (!is_another_on_sphere && !by_weight_) {
        schedules_.share = start_count_;
        start_count_ = 1;
    }
}

bool FastPlan::are_single_or_pairs() const {
    return !by_weight_ && face_count_ <= std::int64_t{2} * submesh_count_;
}

int FastPlan::coarse_face_count() const {
    return quartered_face_count_ > 0 ? quartered_face_count_
                                     : coarse_face_count(kCoarseFacesPerSubmesh);
}

int FastPlan::coarse_face_count(std::int64_t faces_per_submesh) const {
    return static_cast<int>(
        std::min<std::int64_t>(face_count_,
                               std::max<std::int64_t>({kMinCoarseFaces,
                                                       kFacesPerCoarsest * coarsest_face_count_,
                                                       faces_per_submesh * submesh_count_})));
}

bool FastPlan::coarsens() const {
    return coarse_face_count() < MeshLevels::kLeastShare * face_count_;
}

void FastPlan::set_levels(const Multilevel& multilevel) {
    coarsest_face_count_ = multilevel.level_count() > 1 ? multilevel.cell_count(1) : 0;
    quartered_face_count_ = 0;
    if (!by_weight_) {
        const int quartered =
            multilevel.quartered_cell_count(coarse_face_count(kQuarteredFacesPerSubmesh));
        if (quartered < multilevel.cell_count(coarse_face_count())) {
            quartered_face_count_ = quartered;
        }
    }
    const int cell_count = multilevel.cell_count(coarse_face_count());
    first_face_count_ =
        std::max(coarse_face_count(), static_cast<int>(MeshLevels::kLeastShare * cell_count));
}

int FastPlan::relaxations() const {
    const std::int64_t least = schedules_.budget.relaxations;
    return static_cast<int>(std::clamp(least * face_count_ / (kCoarsening * coarse_face_count()),
                                       least,
                                       kMoreRelaxations * least));
}

int FastPlan::trials() const {
    return trial_count(schedules_.budget, first_face_count_);
}

int FastPlan::most_phases() const {
    // Two levels on there are less than kLeastShare of the cells; and the finest level may be
    // annealed twice, before the exchanges.
    const double levels = 2.0 * std::log(face_count_) / -std::log(MeshLevels::kLeastShare) + 2.0;
    const Budget& budget = schedules_.budget;
    return budget.first_phases + static_cast<int>(levels + 2.0) * budget.level_phases +
        budget.rounds;
}

double FastPlan::cost_of_preparation() const {
    return (coarsens() ? kAllLevels : kFinestLevel) * face_count_;
}

StartCost FastPlan::cost_of_start(int trials) const {
    const double faces = face_count_;
    const double edges = hexagonal_edges(faces, submesh_count_);
    const double first_faces = coarsens() ? coarse_face_count() : faces;
    StartCost cost;
    double proposals = 0.0;
    double done_faces = first_faces;
    if (trials > 1) {
        const TrialWork work = trial_work(trial_plan(trials), face_count_);
        cost.start = kProposal * work.proposals();
        done_faces = work.face_count;
    } else {
        cost.start = kRelaxation * relaxations() * first_faces;
        proposals = schedules_.share * schedules_.first_proposals() *
            hexagonal_edges(first_faces, submesh_count_);
    }
    proposals += schedules_.further_proposals(done_faces, faces, submesh_count_);
    cost.levels = kProposal * proposals + (coarsens() ? kUncoarsening * faces : 0.0);
    const bool in_rounds = schedules_.budget.rounds > 0 && !by_weight_;
    const double exchanges = in_rounds ? 0.0 : schedules_.exchange_count(faces, edges);
    cost.exchanges = kProposal * exchanges + kFinish * faces;
    return cost;
}

double FastPlan::cost_of_rounds() const {
    const Budget& budget = schedules_.budget;
    return kProposal * budget.rounds * budget.round_proposals *
        hexagonal_edges(face_count_, submesh_count_);
}

} // namespace spheroseg
