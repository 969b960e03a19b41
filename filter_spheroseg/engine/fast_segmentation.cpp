// SPDX-License-Identifier: GPL-3.0-or-later
#include "fast_segmentation.h"

#include "all_pairs_cohesion.h"
#include "balance.h"
#include "bisection.h"
#include "boundary.h"
#include "component.h"
#include "exact_cut.h"
#include "face_weights.h"
#include "history.h"
#include "pair_cohesion.h"
#include "relaxation.h"
#include "repair.h"
#include "schedules.h"
#include "soundness.h"
#include "sphere_bisection.h"
#include "threads.h"
#include "trials.h"
#include "warm_start.h"
#include "weight_balance.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace spheroseg {

namespace {

/// The start is made on a mesh with about so many faces per sub-mesh ...
constexpr int kCoarseFacesPerSubmesh = 60;
/// ... and at least so many in all, if there is such a level.
constexpr int kMinCoarseFaces = 240;
/// Faces from which on a sub-mesh is not small.
constexpr int kSmallSubmesh = 86;
/// Times that the balance is tried again from where it got stuck, and from another start.
constexpr int kBalanceTries = 6;
constexpr int kMaxStarts = 6;
/// A heaviest load, over the mean, that is worth another start when the time is up.
constexpr double kFarOff = 1.03;
/// Faces of boundaries that the search for exact balance may look at, per face: where it found one
/// it needed up to 310. With large sub-meshes on large meshes it needed up to 5, and more take
/// long.
constexpr std::int64_t kBalanceWork = 1000;
constexpr std::int64_t kLargeBalanceWork = 100;
constexpr int kLargeMesh = 20000;
constexpr int kLargeSubmesh = 30;
/// Starts of which `high` keeps the best result.
constexpr int kHighStarts = 2;
/// From here on the sphere is as good a start as the graph, and another one; below, limbs stretch
/// on the sphere too much.
constexpr int kManySubmeshes = 50;
/// The tail of the cohesion is long and changes little.
constexpr int kSphereIterations = 100;

/// How long the steps take, roughly, in microseconds on two cores.
struct StartCost {
    /// The first labels.
    double start;
    /// The annealing of the levels.
    double levels;
    double exchanges;

    double sum() const { return start + levels + exchanges; }
};

/// Where the progress of a start is when a step ends, from 0 to 1.
struct Shares {
    double start;
    double levels;
};

class FastSegmentation {
public:
    FastSegmentation(Component& component,
                     PreparedMesh* whole,
                     const SegmentOptions& options,
                     const ComponentTask& task,
                     const Deadline& deadline,
                     const Progress& progress,
                     Segmentation& result)
        : component_(component), whole_(whole), options_(options), task_(task),
          submesh_count_(task.submesh_count), deadline_(deadline), progress_(progress),
          result_(result), schedules_{budget_of(options.effort), is_small(), options.thread_count} {
    }

    void run() {
        const Deadline watch;
        prepare_levels(sub_progress(progress_, 0, preparation_share()));
        result_.parametrization_seconds += watch.elapsed_seconds();
        consider_input();
        const std::optional<Segmentation> reserve = make_reserve();
        for (int start = 0; start < kMaxStarts && !(reserve && deadline_.expired()); ++start) {
            if (deadline_.expired()) {
                hurry();
            }
            begin_start(start);
            Patchwork patchwork =
                start == 0 && trials() > 1 ? best_layout() : annealed_labels(start);
            make_exact(patchwork);
            const bool valid = keep_if_better(patchwork, forced_faces_ == 0 || is_sound(patchwork));
            if (valid && start > 0 && !task_.initial_labels.empty()) {
                rename_like(result_.labels, task_.initial_labels, submesh_count_);
            }
            any_valid_ = any_valid_ || valid;
            if (!wants_more(patchwork, start)) {
                break;
            }
        }
        if (kept_history_.count() == 0) {
            kept_history_ = history_; // The initial labels stay.
        }
        if (deadline_.expired() && reserve) {
            history_ = {reserve->boundary_edges_by_iteration,
                        reserve->seconds_by_iteration,
                        reserve->cohesion_iterations};
            history_.on_cores = reserve->used_cuda ? 0 : history_.count();
            any_valid_ = keep_if_better(finest_with(reserve->labels), true) || any_valid_;
        }
        if (!any_valid_ && !by_weight() && component_.face_count() <= kMaxFacesToSearch &&
            !deadline_.is_overdue()) {
            search();
        }
        result_.cohesion_iterations = kept_history_.cohesion_iterations;
        result_.refinement_iterations = kept_history_.refinement_iterations();
        result_.used_cuda = task_.device &&
            kept_history_.count() > std::max(kept_history_.on_cores, result_.cohesion_iterations);
        result_.boundary_edges_by_iteration = std::move(kept_history_.boundary_edges);
        result_.seconds_by_iteration = std::move(kept_history_.seconds);
    }

private:
    bool by_weight() const { return !task_.weights.empty(); }

    int wanted_starts() const {
        return options_.effort == Effort::high && task_.initial_labels.empty() ? kHighStarts : 1;
    }

    /// Is the second start one on the sphere?
    bool starts_on_sphere() const {
        return whole_ && wanted_starts() > 1 && !by_weight() && !is_hurried_ &&
            submesh_count_ >= kManySubmeshes;
    }

    /// When the time is up and there is no valid result, one is made as `draft` does it, without
    /// the limit: what is cut short can not be balanced.
    void hurry() {
        is_hurried_ = true;
        schedules_.budget = budget_of(Effort::draft);
    }

    const Deadline& limit() const { return is_hurried_ ? unlimited_ : deadline_; }

    /// Is another start worth its time, after the start that made this patchwork?
    bool wants_more(const Patchwork& patchwork, int start) const {
        if (is_hurried_) {
            return !any_valid_ && !deadline_.is_overdue();
        }
        if (deadline_.expired()) {
            return !any_valid_ ||
                (by_weight() && was_cut_short_ &&
                 heaviest_load(patchwork) > kFarOff * mean_load(patchwork));
        }
        return !any_valid_ || start + 1 < wanted_starts();
    }

    void prepare_levels(const Progress& progress) {
        if (starts_on_sphere() && coarsens()) {
            component_.hierarchy(options_.thread_count, progress); // the map needs it too
        }
        multilevel_ = coarsens() ? &component_.multilevel(options_.thread_count, progress)
                                 : &component_.finest_level(options_.thread_count);
        if (by_weight()) {
            weighted_.emplace(
                multilevel_->with_weights(quantized_weights(task_.weights, submesh_count_)));
            multilevel_ = &*weighted_;
        }
    }

    /// Progress is by the times that the steps take.
    double preparation_share() const {
        const double preparation = (coarsens() ? 0.45 : 0.15) * component_.face_count();
        return preparation / (preparation + cost_before(wanted_starts()));
    }

    double cost_before(int start) const {
        return start == 0 ? 0.0 : cost_of_start(0).sum() + (start - 1) * cost_of_start(1).sum();
    }

    void begin_start(int start) {
        const double all = cost_before(std::max(wanted_starts(), start + 1));
        start_progress_ = sub_progress(sub_progress(progress_, preparation_share(), 1.0),
                                       cost_before(start) / all,
                                       cost_before(start + 1) / all);
        const StartCost cost = cost_of_start(start);
        shares_ = {cost.start / cost.sum(), (cost.start + cost.levels) / cost.sum()};
        seed_ = options_.seed + 0x9E3779B9ULL * static_cast<std::uint64_t>(start);
        history_ = {};
    }

    StartCost cost_of_start(int start) const {
        constexpr double kProposal = 0.1;
        const double faces = component_.face_count();
        const double edges = hexagonal_edges(faces, submesh_count_);
        const double first_faces = coarsens() ? coarse_face_count() : faces;
        double first = 0.03 * schedules_.budget.relaxations * first_faces;
        double proposals =
            schedules_.first_proposals() * hexagonal_edges(first_faces, submesh_count_);
        double done_faces = first_faces;
        if (start == 0 && trials() > 1) {
            const TrialWork work = trial_work(
                trials(), component_.face_count(), submesh_count_, first_face_count(), schedules_);
            first = kProposal * work.proposals();
            proposals = 0.0;
            done_faces = work.face_count;
        }
        proposals +=
            schedules_.further_proposals(hexagonal_edges(done_faces, submesh_count_), edges);
        return {first,
                kProposal * proposals + (coarsens() ? 0.1 * faces : 0.0),
                kProposal * schedules_.exchange_count(edges) + 0.05 * faces};
    }

    /// Are sub-meshes so small that fewer proposals per boundary face suffice?
    bool is_small() const {
        return component_.face_count() < std::int64_t{kSmallSubmesh} * submesh_count_;
    }

    bool coarsens() const {
        return coarse_face_count() < MeshLevels::kLeastShare * component_.face_count();
    }

    /// Initial labels that are valid already are a result to beat.
    void consider_input() {
        const std::vector<int>& labels = task_.initial_labels;
        if (labels.empty() || *std::min_element(labels.begin(), labels.end()) < 0) {
            return;
        }
        Patchwork patchwork = finest_with(task_.initial_labels);
        if (is_sound(patchwork) && (by_weight() || is_balanced(patchwork))) {
            keep_if_better(patchwork, true);
        }
    }

    /// `high` that runs out of time is cut short while it still melts boundaries. Then the result
    /// of `standard`, which takes a small part of its time, is better. Nothing where it is
    /// not needed, or not valid.
    std::optional<Segmentation> make_reserve() {
        if (options_.effort != Effort::high || options_.time_limit_seconds <= 0.0) {
            return std::nullopt;
        }
        SegmentOptions quick = options_;
        quick.effort = Effort::standard;
        Segmentation reserve;
        const Progress progress = sub_progress(progress_, preparation_share(), preparation_share());
        FastSegmentation run(component_, whole_, quick, task_, deadline_, progress, reserve);
        run.run();
        result_.cohesion_seconds += reserve.cohesion_seconds;
        result_.refinement_seconds += reserve.refinement_seconds;
        return run.any_valid_ ? std::optional(std::move(reserve)) : std::nullopt;
    }

    Patchwork level_with(int least_face_count) const {
        return multilevel_->coarsen(least_face_count, submesh_count_, options_.thread_count);
    }

    Patchwork finest_with(const std::vector<int>& labels) const {
        Patchwork patchwork = level_with(component_.face_count());
        multilevel_->set_labels(patchwork, labels);
        return patchwork;
    }

    bool is_balanced(const Patchwork& patchwork) const {
        const auto [least, most] =
            std::minmax_element(patchwork.load.begin(), patchwork.load.end());
        return *least >= task_.least_count && *most <= task_.largest_count;
    }

    /// Keeps the labels if no better ones were met. `sound`: every sub-mesh is connected and free
    /// of bowties. Returns true when they are valid.
    bool keep_if_better(const Patchwork& patchwork, bool sound) {
        const bool valid = sound && (by_weight() || is_balanced(patchwork));
        // Validity before weight before boundary.
        std::int64_t cost = valid ? 0 : std::int64_t{1} << 62;
        if (by_weight()) {
            const std::int64_t excess =
                std::max(0, heaviest_load(patchwork) - near_enough(patchwork));
            const std::int64_t unit =
                std::max(1, multilevel_->total_weight() / submesh_count_ / 1000);
            cost += ((excess + unit - 1) / unit) << 32;
        }
        const std::int64_t edges = count_boundary_edges(patchwork, options_.thread_count);
        cost += edges;
        if (least_cost_ < 0 || cost < least_cost_) {
            least_cost_ = cost;
            result_.labels = multilevel_->labels(patchwork);
            kept_history_ = history_;
            if (history_.count() > 0) {
                // With what was done to balance it.
                kept_history_.boundary_edges.back() = static_cast<double>(edges);
            }
        }
        return valid;
    }

    /// Starts 0 and 1 are on a coarse mesh, of many sub-meshes start 1 on the sphere instead;
    /// later ones, which are rarely needed, on the finest level, where no room is lost.
    Patchwork first_labels(int start) {
        is_warm_ = start == 0 && !task_.initial_labels.empty();
        if (is_warm_) {
            Patchwork patchwork = finest_with(task_.initial_labels);
            forced_faces_ = adopt_labels(patchwork, seed_);
            return patchwork;
        }
        Patchwork patchwork =
            start == 1 && starts_on_sphere() ? sphere_start() : graph_start(start);
        // Where rings could not be balanced, sub-meshes without any may be, if there can be such.
        patchwork.may_close_rings = start == 0 || any_valid_;
        forced_faces_ = repair(patchwork);
        return patchwork;
    }

    /// The last resort, where moves got stuck on narrow branches.
    void search() {
        history_ = {};
        Patchwork patchwork = level_with(component_.face_count());
        if (cut_exactly(patchwork, task_.least_count, task_.largest_count, kMaxSearchSteps)) {
            const auto [least, most] =
                std::minmax_element(patchwork.load.begin(), patchwork.load.end());
            if (*most - *least <= 1) {
                anneal_balanced(patchwork, exchanges(patchwork), control(shares_.levels, 1.0));
            }
            keep_if_better(patchwork, true);
        }
    }

    int coarse_face_count() const {
        return static_cast<int>(std::min<std::int64_t>(
            component_.face_count(),
            std::max<std::int64_t>(kMinCoarseFaces,
                                   std::int64_t{kCoarseFacesPerSubmesh} * submesh_count_)));
    }

    /// The least cells that the first level may have; more, still of the same level, where there is
    /// none so coarse.
    int first_face_count() const {
        const int least = coarse_face_count();
        return multilevel_ == nullptr
            ? least
            : std::max(least,
                       static_cast<int>(MeshLevels::kLeastShare * multilevel_->cell_count(least)));
    }

    /// With few sub-meshes the layout decides, and another one costs little.
    int trials() const {
        const bool limited = options_.max_cohesion_iterations > 0 ||
            options_.max_refinement_iterations > 0 || !task_.initial_labels.empty();
        return limited ? 1 : trial_count(schedules_.budget, first_face_count());
    }

    /// The control on levels that take a part of the time of all of them.
    auto levels_control() {
        return [this](double begin, double end) {
            const double all = shares_.levels - shares_.start;
            return control(shares_.start + begin * all, shares_.start + end * all);
        };
    }

    Patchwork best_layout() {
        const Deadline watch;
        Trial best = best_of_trials(trials(),
                                    *multilevel_,
                                    submesh_count_,
                                    first_face_count(),
                                    schedules_,
                                    seed_,
                                    limit(),
                                    sub_progress(start_progress_, 0.0, shares_.start));
        history_ = std::move(best.history);
        history_.on_cores = history_.count();
        forced_faces_ = best.forced_faces;
        result_.cohesion_seconds += watch.elapsed_seconds();
        if (best.patchwork.face_count() < component_.face_count()) {
            anneal_further_up(best.patchwork, best.schedule);
        }
        return std::move(best.patchwork);
    }

    Patchwork annealed_labels(int start) {
        Patchwork patchwork = first_labels(start);
        anneal_up(patchwork);
        return patchwork;
    }

    Patchwork graph_start(int start) {
        const Deadline watch;
        Patchwork patchwork =
            level_with(coarsens() && start < 2 ? coarse_face_count() : component_.face_count());
        bisect(patchwork, submesh_count_, seed_, options_.thread_count);
        if (start < 3) {
            AnnealControl cohesion = control(0.0, shares_.start);
            cohesion.max_phases = max_cohesion_iterations();
            const int before = history_.count();
            relax(patchwork, schedules_.budget.relaxations, options_.thread_count, cohesion);
            history_.cohesion_iterations += history_.count() - before;
        }
        result_.cohesion_seconds += watch.elapsed_seconds();
        return patchwork;
    }

    Patchwork sphere_start() {
        const Deadline map_watch;
        const std::vector<Vec3> centroids = face_centroids_on_sphere(
            whole_->mesh(),
            whole_
                ->parametrization(options_.thread_count,
                                  sub_progress(start_progress_, 0.0, 0.5 * shares_.start))
                .positions);
        result_.parametrization_seconds += map_watch.elapsed_seconds();
        const Deadline watch;
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
                         sub_progress(start_progress_, 0.5 * shares_.start, shares_.start),
                         &whole_->dual_graph());
        history_ = {cohesion.boundary_edges, cohesion.seconds, cohesion.count()};
        Patchwork patchwork = finest_with(labels);
        result_.cohesion_seconds += watch.elapsed_seconds();
        return patchwork;
    }

    int max_cohesion_iterations() const {
        return options_.max_cohesion_iterations > 0 ? options_.max_cohesion_iterations : 1 << 30;
    }

    /// Anneals all levels from that of the patchwork on.
    void anneal_up(Patchwork& patchwork) {
        const Deadline watch;
        anneal_levels(patchwork,
                      *multilevel_,
                      schedules_,
                      schedules_.first(seed_),
                      component_.face_count(),
                      forced_faces_,
                      levels_control());
        result_.refinement_seconds += watch.elapsed_seconds();
    }

    void anneal_further_up(Patchwork& patchwork, const AnnealSchedule& schedule) {
        const Deadline watch;
        anneal_further_levels(patchwork,
                              *multilevel_,
                              schedules_,
                              schedule,
                              component_.face_count(),
                              forced_faces_,
                              levels_control());
        result_.refinement_seconds += watch.elapsed_seconds();
    }

    void make_exact(Patchwork& patchwork) {
        const Deadline watch;
        was_cut_short_ = limit().expired();
        if (by_weight()) {
            balance_by_weight(patchwork, exchanges(patchwork), control(shares_.levels, 1.0));
        } else if (balance(patchwork)) {
            anneal_balanced(patchwork, exchanges(patchwork), control(shares_.levels, 1.0));
        }
        result_.refinement_seconds += watch.elapsed_seconds();
    }

    /// At most a tenth of all faces are too many where they are.
    bool is_near_balance(const Patchwork& patchwork) const {
        const int ceiling = (patchwork.face_count() + submesh_count_ - 1) / submesh_count_;
        std::int64_t excess = 0;
        for (int load : patchwork.load) {
            excess += std::max(0, load - ceiling);
        }
        return 10 * excess <= patchwork.face_count();
    }

    bool balance(Patchwork& patchwork) {
        const Progress progress = sub_progress(start_progress_, shares_.levels, shares_.levels);
        const bool is_large =
            patchwork.face_count() >= kLargeMesh && mean_load(patchwork) >= kLargeSubmesh;
        const std::int64_t work = is_large ? kLargeBalanceWork : kBalanceWork;
        const auto balance_by = [&](std::int64_t work_per_face) {
            return balance_exactly(
                patchwork, work_per_face * patchwork.face_count(), &limit(), progress);
        };
        if (is_warm_ || limit().expired()) {
            // Another start is better than a long search.
            return is_near_balance(patchwork) && balance_by(work / 5);
        }
        bool balanced = balance_by(work);
        for (int i = 0; i < kBalanceTries && !balanced && !deadline_.is_overdue(); ++i) {
            // Shake the boundaries with a strong pull towards balance, whatever the time limit.
            const AnnealSchedule schedule =
                schedules_.shaking(seed_ + 1000 + static_cast<std::uint64_t>(i));
            AnnealControl control;
            control.progress = progress;
            anneal(patchwork, schedule, control);
            balanced = balance_by(work);
        }
        return balanced;
    }

    AnnealSchedule exchanges(const Patchwork& patchwork) const {
        return schedules_.exchanges(patchwork, seed_ + 2000);
    }

    AnnealControl control(double begin, double end) {
        AnnealControl control;
        control.deadline = &limit();
        control.device = task_.device;
        control.progress = sub_progress(start_progress_, begin, end);
        history_.record(control);
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
    const Deadline unlimited_;
    const Progress& progress_;
    Progress start_progress_;
    Segmentation& result_;
    Schedules schedules_;
    Shares shares_ = {};
    const Multilevel* multilevel_ = nullptr;
    std::optional<Multilevel> weighted_;
    std::int64_t least_cost_ = -1;
    /// Of the running start, and of the one whose result is kept.
    History history_;
    History kept_history_;
    std::uint64_t seed_ = 0;
    int forced_faces_ = 0;
    bool is_warm_ = false;
    bool is_hurried_ = false;
    bool was_cut_short_ = false;
    bool any_valid_ = false;
};

} // namespace

void segment_component(Component& component,
                       PreparedMesh* whole,
                       const SegmentOptions& options,
                       const ComponentTask& task,
                       const Deadline& deadline,
                       const Progress& progress,
                       Segmentation& result) {
    FastSegmentation(component, whole, options, task, deadline, progress, result).run();
}

} // namespace spheroseg
