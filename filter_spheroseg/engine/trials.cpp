// SPDX-License-Identifier: GPL-3.0-or-later
#include "trials.h"

#include "bisection.h"
#include "boundary.h"
#include "branch_annealing.h"
#include "free_annealing.h"
#include "level_annealing.h"
#include "parallel_tasks.h"
#include "relaxation.h"
#include "repair.h"
#include "seeds.h"
#include "soundness.h"
#include "threads.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace spheroseg {

namespace {

constexpr int kMaxTrials = 12;
/// On tiny meshes there is no room for more layouts than one for so many cells.
constexpr int kCellsPerTrial = 20;
/// Every trial is annealed up to the first level with so many cells.
constexpr int kTrialFaces = 4000;
/// This many of the best trials are annealed further, up to a level with kFinalFaces cells; but
/// none with kMuchWorse times the boundary edges of the best.
constexpr std::ptrdiff_t kFinalists = 2;
constexpr int kFinalFaces = 16000;
constexpr double kMuchWorse = 1.15;
/// Strength of the pull towards balance on the last level before trials are compared (set_balance):
/// with narrow limbs balance may cost many boundary edges, so it must be reached about equally.
constexpr double kJudgedBalance = 10.0;
/// Free annealing begins so hot, with so many times the proposals, that the layout melts.
constexpr double kMelting = 1.0;
constexpr double kMeltingProposals = 2.0;
/// The part of a trial that free annealing or step-by-step bisection takes, for the progress.
constexpr double kBegun = 0.6;
/// Cells of a relaxation that take as long as one proposal.
constexpr double kRelaxedPerProposal = 5.0;

struct Candidate {
    Trial trial;
    /// Boundary edges; more than any where a sub-mesh is not sound, infinite if it was not made.
    double cost = std::numeric_limits<double>::infinity();

    bool operator<(const Candidate& other) const { return cost < other.cost; }
};

class Trials {
public:
    Trials(const Multilevel& multilevel, const TrialPlan& plan, const Deadline& deadline)
        : multilevel_(multilevel), plan_(plan), deadline_(deadline), schedules_(plan.schedules) {
        schedules_.thread_count = 1;
        short_schedules_ = schedules_;
        short_schedules_.share = schedules_.budget.trial_share;
    }

    Trial best(std::uint64_t seed, const Progress& progress) const {
        const TrialWork work = trial_work(plan_, multilevel_.face_count());
        const double made = work.making / work.proposals();
        std::vector<Candidate> candidates(plan_.count);
        run_all(candidates, sub_progress(progress, 0.0, made), [&](int i, auto& control) {
            if (i == 0 || !deadline_.expired()) {
                Trial& trial = candidates[i].trial;
                make(trial, i % 4, seed_of_trial(seed, i), control);
                candidates[i].cost = cost(trial);
            }
        });
        keep_best(candidates);
        run_all(candidates, sub_progress(progress, made, 1.0), [&](int i, auto& control) {
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
        std::vector<std::atomic<double>> parts(count);
        const auto report = [&] {
            double sum = 0.0;
            for (const std::atomic<double>& part : parts) {
                sum += part;
            }
            return !progress || progress(sum / count, "Trials");
        };
        const int threads = resolve_thread_count(plan_.schedules.thread_count);
        run_tasks(count, threads, report, [&](int i, const Progress& task_progress) {
            AnnealControl control;
            control.deadline = &deadline_;
            control.progress = [&](double part, const char* step) {
                parts[i] = part;
                return task_progress(part, step);
            };
            work(i, control);
            parts[i] = 1.0;
        });
    }

    static double cost(const Trial& trial) {
        const double edges = static_cast<double>(count_boundary_edges(trial.patchwork, 1));
        return trial.patchwork.may_be_unsound && !is_sound(trial.patchwork) ? 1e12 + edges : edges;
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

    static AnnealControl part_of(const AnnealControl& control, double begin, double end) {
        AnnealControl part = control;
        part.progress = sub_progress(control.progress, begin, end);
        return part;
    }

    static auto parts_of(const AnnealControl& control) {
        return [control](double begin, double end) { return part_of(control, begin, end); };
    }

    void make(Trial& trial, int kind, std::uint64_t seed, const AnnealControl& control) const {
        const AnnealControl begun = part_of(control, 0.0, kBegun);
        trial.patchwork = multilevel_.coarsen(plan_.first_face_count, plan_.submesh_count);
        if (kind == 3) {
            cut_again_and_again(trial.patchwork, seed, begun);
        } else {
            bisect(trial.patchwork, plan_.submesh_count, seed, 1);
            AnnealControl recorded = part_of(control, 0.0, 0.0);
            recorded.history = &trial.history;
            relax(trial.patchwork, schedules_.budget.relaxations, 1, recorded);
            trial.history.cohesion_iterations = trial.history.count();
        }
        if (kind == 1) {
            anneal_freely_up(trial.patchwork, seed, begun);
        }
        repair(trial.patchwork);
        trial.schedule =
            anneal_levels(trial.patchwork,
                          multilevel_,
                          short_schedules_,
                          short_schedules_.first(seed),
                          kTrialFaces,
                          parts_of(kind % 2 == 1 ? part_of(control, kBegun, 1.0) : control),
                          0,
                          kJudgedBalance);
        pass_branches(trial, short_schedules_, control);
    }

    void cut_again_and_again(Patchwork& patchwork,
                             std::uint64_t seed,
                             const AnnealControl& control) const {
        AnnealSchedule schedule = short_schedules_.first(seed);
        set_balance(schedule, patchwork, 0.5, 1.5);
        const auto unit = static_cast<int>(mean_load(patchwork));
        const double count = plan_.submesh_count;
        std::vector<int> parts{plan_.submesh_count};
        patchwork.load.resize(1);
        while (static_cast<int>(parts.size()) < plan_.submesh_count) {
            const double begin = parts.size() / count;
            cut_in_two(patchwork, parts, schedule.seed++);
            repair(patchwork);
            // The annealing is to take a sub-mesh of several parts for as heavy as one of fewer.
            const int most = *std::max_element(parts.begin(), parts.end());
            for (std::size_t l = 0; l < parts.size(); ++l) {
                patchwork.load[l] += (most - parts[l]) * unit;
            }
            anneal(patchwork, schedule, part_of(control, begin, parts.size() / count));
            sum_loads(patchwork);
        }
    }

    void
    anneal_freely_up(Patchwork& patchwork, std::uint64_t seed, const AnnealControl& control) const {
        AnnealSchedule schedule = short_schedules_.first(seed);
        schedule.temperature_begin = kMelting;
        schedule.proposals_per_face *= kMeltingProposals;
        const int last = std::min(kTrialFaces, multilevel_.face_count());
        for (;;) {
            set_balance(schedule, patchwork, 0.5, 1.5);
            anneal_freely(patchwork, schedule, deadline_);
            if (patchwork.face_count() >= last) {
                report_progress(control.progress, 1.0, "");
                return;
            }
            const int submesh_count = patchwork.submesh_count();
            report_progress(control.progress,
                            short_schedules_.level_work(patchwork.face_count(), submesh_count) /
                                short_schedules_.level_work(last, submesh_count),
                            "");
            multilevel_.uncoarsen(patchwork);
            schedule = short_schedules_.next(schedule, patchwork);
        }
    }

    void go_on(Trial& trial, AnnealControl& control) const {
        if (trial.patchwork.face_count() >= kFinalFaces) {
            return;
        }
        control.history = &trial.history;
        trial.schedule = anneal_further_levels(trial.patchwork,
                                               multilevel_,
                                               schedules_,
                                               trial.schedule,
                                               kFinalFaces,
                                               parts_of(control),
                                               kJudgedBalance);
        pass_branches(trial, schedules_, control);
    }

    void
    pass_branches(Trial& trial, const Schedules& schedules, const AnnealControl& control) const {
        if (is_stuck(trial.patchwork)) {
            anneal_branches(trial.patchwork,
                            schedules.branches(trial.patchwork, trial.schedule.seed),
                            control.deadline,
                            part_of(control, 1.0, 1.0).progress);
        }
    }

    const Multilevel& multilevel_;
    const TrialPlan& plan_;
    const Deadline& deadline_;
    /// Of one thread.
    Schedules schedules_;
    Schedules short_schedules_;
};

} // namespace

int trial_count(const Budget& budget, int first_face_count) {
    const int worth =
        std::min(budget.trial_faces / first_face_count, first_face_count / kCellsPerTrial);
    return std::clamp(worth, 1, kMaxTrials);
}

TrialWork trial_work(const TrialPlan& plan, int face_count) {
    const Schedules& schedules = plan.schedules;
    const int threads = resolve_thread_count(schedules.thread_count);
    const int trial_faces = std::min(kTrialFaces, face_count);
    const int final_faces = std::min(kFinalFaces, face_count);
    const double first_edges = hexagonal_edges(plan.first_face_count, plan.submesh_count);
    const double first = schedules.first_proposals() * first_edges;
    const double further =
        schedules.further_proposals(plan.first_face_count, trial_faces, plan.submesh_count);
    // Of four trials one is melted before, and one annealed after each cut.
    const double melting = kMeltingProposals * first + further;
    const double cuts = std::log2(plan.submesh_count) * first;
    const double trial = schedules.budget.trial_share * (first + further + (melting + cuts) / 4.0) +
        schedules.budget.relaxations * plan.first_face_count / kRelaxedPerProposal;
    const auto finalists = std::min(static_cast<int>(kFinalists), plan.count);
    return {trial * plan.count / std::min(threads, plan.count),
            schedules.further_proposals(trial_faces, final_faces, plan.submesh_count) * finalists /
                std::min(threads, finalists),
            final_faces};
}

Trial best_of_trials(const Multilevel& multilevel,
                     const TrialPlan& plan,
                     std::uint64_t seed,
                     const Deadline& deadline,
                     const Progress& progress) {
    return Trials(multilevel, plan, deadline).best(seed, progress);
}

} // namespace spheroseg
