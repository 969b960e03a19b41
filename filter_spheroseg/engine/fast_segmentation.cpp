// SPDX-License-Identifier: GPL-3.0-or-later
#include "fast_segmentation.h"

#include "balance_search.h"
#include "best_result.h"
#include "bisection.h"
#include "bridge_bound.h"
#include "cohesion_state.h"
#include "component.h"
#include "exact_cut.h"
#include "face_weights.h"
#include "fast_deadlines.h"
#include "fast_plan.h"
#include "level_annealing.h"
#include "pair_cohesion.h"
#include "relaxation.h"
#include "repair.h"
#include "seeds.h"
#include "soundness.h"
#include "sphere_bisection.h"
#include "trials.h"
#include "warm_start.h"
#include "weight_balance.h"

#include <algorithm>
#include <utility>

namespace spheroseg {

namespace {

/// Starts, where none is balanced.
constexpr int kMaxStarts = 6;
/// The part of the time of bisection and relaxation that the bisection takes.
constexpr double kBisectionShare = 0.15;
/// A heaviest load, over the mean, that is worth another start when the time is up.
constexpr double kFarOff = 1.03;
/// The greatest excess_share of initial labels that are near to balance.
constexpr double kNear = 0.02;
/// The tail of the cohesion is long and changes little.
constexpr int kSphereIterations = 100;

class FastSegmentation {
public:
    FastSegmentation(Component& component,
                     PreparedMesh* whole,
                     const SegmentOptions& options,
                     const ComponentTask& task,
                     const Deadline& deadline,
                     const Progress& progress)
        : component_(component), whole_(whole), options_(options), task_(task),
          submesh_count_(task.submesh_count), deadline_(deadline), time_(deadline),
          progress_(progress), plan_(component.face_count(),
                                     task.submesh_count,
                                     !task.weights.empty(),
                                     whole != nullptr,
                                     options.effort,
                                     options.thread_count) {}

    ComponentResult run() {
        const StopWatch watch;
        prepare_levels(sub_progress(progress_, 0, preparation_share()));
        result_.seconds.parametrization += watch.elapsed_seconds();
        consider_input();
        const std::optional<ComponentResult> reserve = make_reserve();
        for (int start = 0; start < kMaxStarts && !(reserve && time_.expired()); ++start) {
            if (time_.expired() && !time_.is_hurried()) {
                time_.hurry();
                plan_.set_effort(Effort::draft);
            }
            begin_start(start);
            Patchwork patchwork = start == 0 && trials() > 1 ? best_layout() : annealed_labels();
            make_exact(patchwork);
            keep(patchwork);
            if (!wants_more(patchwork, start)) {
                break;
            }
        }
        if (best_->history().count() == 0) {
            best_->set_history(history_); // The initial labels stay.
        }
        if (best_->is_valid() && has_rounds() && !time_.expired()) {
            go_on_in_rounds();
        }
        if (time_.expired() && reserve) {
            history_ = reserve->history;
            best_->keep_if_better(finest_with(reserve->labels), true, history_);
        }
        if (!best_->is_valid() && result_.may_be_as_asked && !by_weight() &&
            component_.face_count() <= kMaxFacesToSearch && !time_.of_search().expired()) {
            search();
        }
        result_.is_valid = best_->is_valid();
        result_.labels = best_->labels();
        result_.history = best_->history();
        if (!task_.initial_labels.empty()) {
            rename_like(result_.labels, task_.initial_labels, submesh_count_);
        }
        return std::move(result_);
    }

private:
    bool by_weight() const { return !task_.weights.empty(); }
    /// Does the running start go on from the initial labels?
    bool is_warm() const { return start_ == 0 && !task_.initial_labels.empty(); }
    bool has_rounds() const { return plan_.schedules().budget.rounds > 0; }

    int wanted_starts() const { return task_.initial_labels.empty() ? plan_.start_count() : 1; }

    /// Is the second start one on the sphere?
    bool starts_on_sphere() const {
        return task_.initial_labels.empty() && plan_.starts_on_sphere();
    }

    const Deadline& limit() const { return time_.of_start(); }

    /// Keeps the labels of a start if they are better than those before.
    void keep(const Patchwork& patchwork) {
        const bool is_whole = !patchwork.may_be_unsound || is_sound(patchwork);
        any_valid_ = best_->keep_if_better(patchwork, is_whole, history_) || any_valid_;
    }

    /// Is another start worth its time, after the start that made this patchwork?
    bool wants_more(const Patchwork& patchwork, int start) const {
        if (is_least_ || (is_hopeless_ && start > 0)) {
            return false;
        }
        if (time_.is_hurried()) {
            return !any_valid_ && !time_.of_search().expired();
        }
        if (time_.expired()) {
            return !any_valid_ ||
                (by_weight() && was_cut_short_ &&
                 heaviest_load(patchwork) > kFarOff * mean_load(patchwork));
        }
        return !any_valid_ || start + 1 < wanted_starts();
    }

    void prepare_levels(const Progress& progress) {
        if (starts_on_sphere()) {
            component_.hierarchy(options_.thread_count, progress); // the map needs it too
        }
        multilevel_ = plan_.coarsens() ? &component_.multilevel(options_.thread_count, progress)
                                       : &component_.finest_level(options_.thread_count);
        plan_.set_levels(*multilevel_);
        if (by_weight()) {
            weighted_.emplace(
                multilevel_->with_weights(quantized_weights(task_.weights, submesh_count_)));
            multilevel_ = &*weighted_;
        }
        best_.emplace(*multilevel_, task_, options_.thread_count);
    }

    /// The part of the progress that the preparation takes: progress follows the expected times.
    double preparation_share() const {
        const double preparation = plan_.cost_of_preparation();
        return preparation / (preparation + cost_before(wanted_starts()) + plan_.cost_of_rounds());
    }

    double cost_before(int start) const {
        return start == 0
            ? 0.0
            : plan_.cost_of_start(trials()).sum() + (start - 1) * plan_.cost_of_start(1).sum();
    }

    void begin_start(int start) {
        const double all =
            cost_before(std::max(wanted_starts(), start + 1)) + plan_.cost_of_rounds();
        start_progress_ = sub_progress(sub_progress(progress_, preparation_share(), 1.0),
                                       cost_before(start) / all,
                                       cost_before(start + 1) / all);
        cost_ = plan_.cost_of_start(start == 0 ? trials() : 1);
        seed_ = seed_of_start(options_.seed, start);
        history_ = {};
        start_ = start;
        start_watch_ = {};
    }

    /// Initial labels that are valid already are a result to beat.
    void consider_input() {
        const std::vector<int>& labels = task_.initial_labels;
        if (labels.empty() || *std::min_element(labels.begin(), labels.end()) < 0) {
            return;
        }
        const Patchwork patchwork = finest_with(task_.initial_labels);
        if (is_sound(patchwork) && best_->would_be_valid(patchwork)) {
            best_->keep_if_better(patchwork, true, {});
        }
    }

    /// `high` that runs out of time is cut short while it still melts boundaries. Then the result
    /// of `standard`, which takes a small part of its time, is better. Nothing where it is
    /// not needed, no other, or not valid.
    std::optional<ComponentResult> make_reserve() {
        if (options_.effort != Effort::high || options_.time_limit_seconds <= 0.0 ||
            plan_.are_single_or_pairs()) {
            return std::nullopt;
        }
        SegmentOptions quick = options_;
        quick.effort = Effort::standard;
        const Progress progress = sub_progress(progress_, preparation_share(), preparation_share());
        ComponentResult reserve =
            FastSegmentation(component_, whole_, quick, task_, deadline_, progress).run();
        result_.seconds += reserve.seconds;
        return reserve.is_valid ? std::optional(std::move(reserve)) : std::nullopt;
    }

    Patchwork level_with(int least_face_count) const {
        return multilevel_->coarsen(least_face_count, submesh_count_, options_.thread_count);
    }

    Patchwork finest_with(const std::vector<int>& labels) const {
        Patchwork patchwork = level_with(component_.face_count());
        multilevel_->set_labels(patchwork, labels);
        return patchwork;
    }

    /// Starts 0 and 1 are on a coarse mesh, of many sub-meshes start 1 on the sphere instead;
    /// later ones, which are rarely needed, on the finest level, where no room is lost.
    Patchwork first_labels() {
        if (is_warm()) {
            return adopted_labels();
        }
        Patchwork patchwork = start_ == 1 && starts_on_sphere() ? sphere_start() : graph_start();
        // Where rings could not be balanced, sub-meshes without any may be, if there can be such.
        patchwork.may_close_rings = start_ == 0 || any_valid_;
        repair(patchwork);
        return patchwork;
    }

    /// The initial labels, repaired. Annealing melts what is good about them, and moves many; so
    /// those near to balance are balanced and exchanged without it first: a result to beat.
    Patchwork adopted_labels() {
        Patchwork adopted = finest_with(task_.initial_labels);
        adopt_labels(adopted, seed_, start_progress_);
        const bool is_near = excess_share(adopted) <= kNear;
        cost_.start = is_near ? cost_.exchanges : 0.0;
        if (is_near) {
            Patchwork patchwork = adopted;
            make_exact(patchwork, false);
            keep(patchwork);
            history_ = {};
        }
        return adopted;
    }

    /// The last resort, where moves got stuck on narrow branches.
    void search() {
        history_ = {};
        Patchwork patchwork = level_with(component_.face_count());
        if (cut_exactly(patchwork, task_.counts.floor, task_.counts.ceiling, kMaxSearchSteps)) {
            const auto [least, most] =
                std::minmax_element(patchwork.load.begin(), patchwork.load.end());
            if (*most - *least <= 1) {
                anneal_balanced(patchwork, exchanges(patchwork), control(cost_.levels_end(), 1.0));
            }
            best_->keep_if_better(patchwork, true, history_);
        }
    }

    /// With few sub-meshes the layout decides, and another one costs little. Trials are made whole:
    /// none where a limit of iterations could end one.
    int trials() const {
        const auto may_end = [](int limit, int most) { return limit > 0 && limit < most; };
        const bool is_single = !task_.initial_labels.empty() ||
            may_end(options_.max_cohesion_iterations, plan_.schedules().budget.relaxations) ||
            may_end(options_.max_refinement_iterations, plan_.most_phases());
        return is_single ? 1 : plan_.trials();
    }

    /// The control on levels that take a part of the time of all of them.
    auto levels_control() {
        return [this](double begin, double end) {
            const double first = cost_.start_end();
            const double all = cost_.levels_end() - first;
            return control(first + begin * all, first + end * all);
        };
    }

    Patchwork best_layout() {
        const StopWatch watch;
        Trial best = best_of_trials(*multilevel_,
                                    plan_.trial_plan(trials()),
                                    seed_,
                                    limit(),
                                    sub_progress(start_progress_, 0.0, cost_.start_end()));
        history_ = std::move(best.history);
        result_.seconds.cohesion += watch.elapsed_seconds();
        if (best.patchwork.face_count() < component_.face_count()) {
            anneal_further_up(best.patchwork, best.schedule);
        }
        return std::move(best.patchwork);
    }

    Patchwork annealed_labels() {
        Patchwork patchwork = first_labels();
        anneal_up(patchwork);
        return patchwork;
    }

    Patchwork graph_start() {
        const StopWatch watch;
        Patchwork patchwork = level_with(start_ < 2 && plan_.coarsens() ? plan_.coarse_face_count()
                                                                        : component_.face_count());
        const double relaxation = kBisectionShare * cost_.start_end();
        bisect(patchwork,
               submesh_count_,
               seed_,
               options_.thread_count,
               sub_progress(start_progress_, 0.0, relaxation));
        if (start_ < 3) {
            AnnealControl cohesion = control(relaxation, cost_.start_end());
            cohesion.max_phases = max_cohesion_iterations();
            const int before = history_.count();
            relax(patchwork, plan_.relaxations(), options_.thread_count, cohesion);
            history_.cohesion_iterations += history_.count() - before;
        }
        result_.seconds.cohesion += watch.elapsed_seconds();
        return patchwork;
    }

    Patchwork sphere_start() {
        const StopWatch map_watch;
        const std::vector<Vec3> centroids = face_centroids_on_sphere(
            whole_->mesh(),
            whole_
                ->parametrization(options_.thread_count,
                                  sub_progress(start_progress_, 0.0, 0.5 * cost_.start_end()))
                .positions);
        result_.seconds.parametrization += map_watch.elapsed_seconds();
        const StopWatch watch;
        SwapLimits limits;
        limits.thread_count = options_.thread_count;
        limits.deadline = &limit();
        limits.max_iterations = std::min(kSphereIterations, max_cohesion_iterations());
        std::vector<int> labels = balanced_sphere_labels(centroids, submesh_count_);
        const SwapIterations cohesion =
            cohere_pairs(centroids,
                         submesh_count_,
                         limits,
                         labels,
                         sub_progress(start_progress_, 0.5 * cost_.start_end(), cost_.start_end()),
                         &whole_->dual_graph());
        history_ = {cohesion.boundary_edges, cohesion.seconds, cohesion.count()};
        Patchwork patchwork = finest_with(labels);
        result_.seconds.cohesion += watch.elapsed_seconds();
        return patchwork;
    }

    int max_cohesion_iterations() const {
        return options_.max_cohesion_iterations > 0 ? options_.max_cohesion_iterations : 1 << 30;
    }

    /// Anneals all levels from that of the patchwork on.
    void anneal_up(Patchwork& patchwork) {
        const StopWatch watch;
        anneal_levels(patchwork,
                      *multilevel_,
                      plan_.schedules(),
                      plan_.schedules().first(seed_),
                      component_.face_count(),
                      levels_control());
        result_.seconds.refinement += watch.elapsed_seconds();
    }

    void anneal_further_up(Patchwork& patchwork, const AnnealSchedule& schedule) {
        const StopWatch watch;
        anneal_further_levels(patchwork,
                              *multilevel_,
                              plan_.schedules(),
                              schedule,
                              component_.face_count(),
                              levels_control());
        result_.seconds.refinement += watch.elapsed_seconds();
    }

    /// Balances the labels and exchanges faces: initial ones, which are mended only, or, when
    /// `are_annealed`, those of a start.
    void make_exact(Patchwork& patchwork, bool are_annealed = true) {
        const StopWatch watch;
        was_cut_short_ = limit().expired();
        const double begin = are_annealed ? cost_.levels_end() : 0.0;
        AnnealControl exact = control(begin, are_annealed ? 1.0 : cost_.start_end());
        if (by_weight()) {
            const Deadline first = time_.of_lowering(start_watch_.elapsed_seconds());
            if (time_.is_hurried()) {
                exact.deadline = &first;
            }
            balance_by_weight(patchwork, exchanges(patchwork, are_annealed), exact, &first);
        } else if (balance(patchwork, are_annealed, sub_progress(start_progress_, begin, begin)) &&
                   !has_rounds()) {
            anneal_balanced(patchwork, exchanges(patchwork, are_annealed), exact);
        }
        result_.seconds.refinement += watch.elapsed_seconds();
    }

    /// Shortens the boundaries of the best result further.
    void go_on_in_rounds() {
        const StopWatch watch;
        Patchwork patchwork = finest_with(best_->labels());
        history_ = best_->history();
        const AnnealSchedule rounds = plan_.schedules().rounds(seed_ + seed_offset::kRounds);
        const double starts = cost_before(wanted_starts());
        start_progress_ = sub_progress(sub_progress(progress_, preparation_share(), 1.0),
                                       starts / (starts + plan_.cost_of_rounds()),
                                       1.0);
        if (by_weight()) {
            anneal_below(patchwork, heaviest_load(patchwork), rounds, control(0.0, 1.0));
        } else {
            anneal_balanced(patchwork, rounds, control(0.0, 1.0));
        }
        best_->keep_if_better(patchwork, true, history_);
        result_.seconds.refinement += watch.elapsed_seconds();
    }

    /// What was cut short, and initial labels, are not worth a long search: another start is
    /// better. Without annealing branches are not, either.
    bool balance(Patchwork& patchwork, bool are_annealed, const Progress& progress) {
        BalanceSearch search(
            patchwork, plan_.schedules(), seed_, start_, time_.of_search(), progress);
        if (limit().expired()) {
            return search.pass_faces();
        }
        if (are_annealed) {
            search.pass_branches(limit());
        }
        if (is_warm()) {
            return search.balance_initial_labels();
        }
        time_.extend_search();
        const bool balanced = search.search();
        is_hopeless_ = search.is_hopeless();
        // Other components may have such counts that those of this one need not be equal. The same
        // for all starts.
        if (!search.is_possible() && result_.may_be_as_asked) {
            result_.may_be_as_asked = least_misplaced(patchwork, task_.counts) == 0;
        }
        is_least_ = search.is_least() && !result_.may_be_as_asked;
        return balanced;
    }

    AnnealSchedule exchanges(const Patchwork& patchwork, bool are_annealed = true) const {
        const std::uint64_t seed = seed_ + seed_offset::kExchanges;
        return are_annealed ? plan_.schedules().exchanges(patchwork, seed)
                            : plan_.schedules().mending(patchwork, seed);
    }

    AnnealControl control(double begin, double end) {
        AnnealControl control;
        control.deadline = &limit();
        control.device = task_.device;
        control.progress = sub_progress(start_progress_, begin, end);
        control.history = &history_;
        if (options_.max_refinement_iterations > 0) {
            control.max_phases =
                options_.max_refinement_iterations - history_.refinement_iterations();
        }
        return control;
    }

    Component& component_;
    PreparedMesh* const whole_;
    const SegmentOptions& options_;
    const ComponentTask& task_;
    const int submesh_count_;
    const Deadline& deadline_;
    FastDeadlines time_;
    const Progress& progress_;
    Progress start_progress_;
    ComponentResult result_;
    FastPlan plan_;
    StartCost cost_ = {};
    const Multilevel* multilevel_ = nullptr;
    std::optional<Multilevel> weighted_;
    std::optional<BestResult> best_;
    /// Of the running start.
    History history_;
    StopWatch start_watch_;
    int start_ = 0;
    std::uint64_t seed_ = 0;
    bool was_cut_short_ = false;
    /// Where a balance was last searched for, so much stayed off that only another kind of start is
    /// worth a try.
    bool is_hopeless_ = false;
    /// No cut has counts as asked for, and none is nearer to a balance than what was found there.
    bool is_least_ = false;
    /// A start was, whatever the initial labels are.
    bool any_valid_ = false;
};

} // namespace

ComponentResult segment_component(Component& component,
                                  PreparedMesh* whole,
                                  const SegmentOptions& options,
                                  const ComponentTask& task,
                                  const Deadline& deadline,
                                  const Progress& progress) {
    return FastSegmentation(component, whole, options, task, deadline, progress).run();
}

} // namespace spheroseg
