// SPDX-License-Identifier: GPL-3.0-or-later
#include "trials.h"

#include "bisection.h"
#include "boundary.h"
#include "free_annealing.h"
#include "parallel_tasks.h"
#include "relaxation.h"
#include "repair.h"
#include "threads.h"

#include <algorithm>
#include <limits>

namespace spheroseg {

namespace {

constexpr int kMaxTrials = 12;
/// So many of the best trials go on up to a level with so many cells, unless one is much worse than
/// the best.
constexpr std::ptrdiff_t kFinalists = 2;
constexpr int kFinalFaces = 16000;
constexpr double kMuchWorse = 1.15;
/// Free annealing begins so hot, with so many times the proposals, that the layout melts.
constexpr double kMelting = 1.0;
constexpr double kMeltingProposals = 2.0;
/// The part of the time that it takes to make all trials.
constexpr double kMakingShare = 0.7;

struct Candidate {
    Trial trial;
    /// Boundary edges; more than any where a sub-mesh is not sound, infinite if it was not made.
    double cost = std::numeric_limits<double>::infinity();

    bool operator<(const Candidate& other) const { return cost < other.cost; }
};

class Trials {
public:
    Trials(const Multilevel& multilevel,
           int submesh_count,
           int first_face_count,
           const Schedules& schedules,
           const Deadline& deadline)
        : multilevel_(multilevel), submesh_count_(submesh_count),
          first_face_count_(first_face_count), deadline_(deadline),
          thread_count_(resolve_thread_count(schedules.thread_count)), schedules_(schedules) {
        schedules_.thread_count = 1;
        short_schedules_ = schedules_;
        short_schedules_.share = schedules_.budget.trial_share;
    }

    Trial best(int count, std::uint64_t seed, const Progress& progress) const {
        std::vector<Candidate> candidates(count);
        run_all(candidates, sub_progress(progress, 0.0, kMakingShare), [&](int i, auto& control) {
            if (i == 0 || !deadline_.expired()) {
                Trial& trial = candidates[i].trial;
                make(trial, i % 4, seed + 0x51ED270BULL * static_cast<std::uint64_t>(i), control);
                candidates[i].cost = cost(trial);
            }
        });
        keep_best(candidates);
        run_all(candidates, sub_progress(progress, kMakingShare, 1.0), [&](int i, auto& control) {
            go_on(candidates[i].trial, control);
            candidates[i].cost = cost(candidates[i].trial);
        });
        return std::move(std::min_element(candidates.begin(), candidates.end())->trial);
    }

private:
    /// Calls work(i, control) for each of the candidates.
    template <typename Work>
    void run_all(const std::vector<Candidate>& candidates,
                 const Progress& progress,
                 const Work& work) const {
        const auto count = static_cast<int>(candidates.size());
        std::atomic<int> done{0};
        const auto report = [&] {
            return !progress || progress(static_cast<double>(done) / count, "Trials");
        };
        run_tasks(count, thread_count_, report, [&](int i, const Progress& heard) {
            AnnealControl control;
            control.deadline = &deadline_;
            control.progress = heard;
            work(i, control);
            ++done;
        });
    }

    static double cost(const Trial& trial) {
        const double edges = static_cast<double>(count_boundary_edges(trial.patchwork, 1));
        return trial.forced_faces > 0 ? 1e12 + edges : edges;
    }

    void keep_best(std::vector<Candidate>& candidates) const {
        std::stable_sort(candidates.begin(), candidates.end());
        const double limit = kMuchWorse * candidates[0].cost;
        const auto worse = std::find_if(candidates.begin(),
                                        candidates.end(),
                                        [&](const Candidate& c) { return c.cost > limit; });
        candidates.erase(candidates.begin() + std::min(worse - candidates.begin(), kFinalists),
                         candidates.end());
    }

    void make(Trial& trial, int kind, std::uint64_t seed, const AnnealControl& control) const {
        trial.patchwork = multilevel_.coarsen(first_face_count_, submesh_count_);
        if (kind == 3) {
            cut_again_and_again(trial.patchwork, seed, control);
        } else {
            bisect(trial.patchwork, submesh_count_, seed, 1);
            AnnealControl recorded = control;
            trial.history.record(recorded);
            relax(trial.patchwork, schedules_.budget.relaxations, 1, recorded);
            trial.history.cohesion_iterations = trial.history.count();
        }
        if (kind == 1) {
            anneal_freely_up(trial.patchwork, seed, control);
        }
        trial.forced_faces = repair(trial.patchwork);
        trial.schedule = anneal_levels(trial.patchwork,
                                       multilevel_,
                                       short_schedules_,
                                       short_schedules_.first(seed),
                                       kTrialFaces,
                                       [&](const Patchwork&) { return control; });
    }

    void cut_again_and_again(Patchwork& patchwork,
                             std::uint64_t seed,
                             const AnnealControl& control) const {
        AnnealSchedule schedule = short_schedules_.first(seed);
        set_balance(schedule, patchwork, 0.5, 1.5);
        const auto unit = static_cast<int>(mean_load(patchwork));
        std::vector<int> parts{submesh_count_};
        patchwork.load.resize(1);
        while (static_cast<int>(parts.size()) < submesh_count_) {
            cut_in_two(patchwork, parts, schedule.seed++);
            repair(patchwork);
            // The annealing is to take a sub-mesh of several parts for as heavy as one of fewer.
            const int most = *std::max_element(parts.begin(), parts.end());
            for (std::size_t l = 0; l < parts.size(); ++l) {
                patchwork.load[l] += (most - parts[l]) * unit;
            }
            anneal(patchwork, schedule, control);
            sum_loads(patchwork);
        }
    }

    void
    anneal_freely_up(Patchwork& patchwork, std::uint64_t seed, const AnnealControl& control) const {
        AnnealSchedule schedule = short_schedules_.first(seed);
        schedule.temperature_begin = kMelting;
        schedule.proposals_per_face *= kMeltingProposals;
        for (;;) {
            set_balance(schedule, patchwork, 0.5, 1.5);
            anneal_freely(patchwork, schedule, deadline_);
            report_progress(control.progress, 1.0, "");
            if (patchwork.face_count() >= std::min(kTrialFaces, multilevel_.face_count())) {
                return;
            }
            schedule = short_schedules_.next(schedule);
            multilevel_.uncoarsen(patchwork);
        }
    }

    void go_on(Trial& trial, AnnealControl& control) const {
        if (trial.patchwork.face_count() >= kFinalFaces) {
            return;
        }
        trial.history.record(control);
        if (trial.patchwork.face_count() < multilevel_.face_count()) {
            multilevel_.uncoarsen(trial.patchwork);
        }
        trial.schedule = anneal_levels(trial.patchwork,
                                       multilevel_,
                                       schedules_,
                                       schedules_.next(trial.schedule),
                                       kFinalFaces,
                                       [&](const Patchwork&) { return control; });
    }

    const Multilevel& multilevel_;
    const int submesh_count_;
    const int first_face_count_;
    const Deadline& deadline_;
    const int thread_count_;
    Schedules schedules_;
    Schedules short_schedules_;
};

} // namespace

int trial_count(const Budget& budget, int first_face_count) {
    return std::clamp(budget.trial_faces / first_face_count, 1, kMaxTrials);
}

Trial best_of_trials(int count,
                     const Multilevel& multilevel,
                     int submesh_count,
                     int first_face_count,
                     const Schedules& schedules,
                     std::uint64_t seed,
                     const Deadline& deadline,
                     const Progress& progress) {
    const Trials trials(multilevel, submesh_count, first_face_count, schedules, deadline);
    return trials.best(count, seed, progress);
}

} // namespace spheroseg
