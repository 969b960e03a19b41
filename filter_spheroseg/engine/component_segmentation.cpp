// SPDX-License-Identifier: GPL-3.0-or-later
#include "component_segmentation.h"

#include "anneal_device.h"
#include "exact_cut.h"
#include "face_weights.h"
#include "fast_segmentation.h"
#include "initial_labels.h"
#include "parallel_tasks.h"
#include "shares.h"
#include "threads.h"
#include "warm_start.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <numeric>
#include <utility>

namespace spheroseg {

namespace {

/// Faces below which components are segmented in parallel, one thread each.
constexpr int kLargeComponent = 16384;
/// Heaviest loads that differ by less than this part of the mean count as equal.
constexpr double kSameBalance = 0.001;
/// Where a component can not be cut as its share asks, so many others are tried for the sub-mesh
/// that it gives or takes, with so many times all faces cut anew in all.
constexpr int kMostPartners = 4;
constexpr std::int64_t kMostCutsAnew = 2;
/// Faces up to which counts are searched for that differ by more than the best shares would.
constexpr int kFewFaces = 24;

/// Component after component, each with its share of the sub-meshes.
class ComponentWise {
public:
    ComponentWise(PreparedMesh& prepared,
                  const SegmentOptions& options,
                  const Deadline& deadline,
                  const Progress& progress,
                  AnnealDevice* device)
        : prepared_(prepared), options_(options), deadline_(deadline), progress_(progress),
          device_(device) {}

    Segmentation run() {
        const int face_count = prepared_.mesh().face_count();
        const int submesh_count = requested_submesh_count(options_, face_count);
        result_.best_max_triangle_count_difference = face_count % submesh_count != 0;
        const StopWatch watch;
        components_ = &prepared_.components();
        seconds_.parametrization += watch.elapsed_seconds();
        std::vector<int> face_counts;
        for (const Component& component : *components_) {
            face_counts.push_back(component.face_count());
        }
        share_out(face_counts, submesh_count);
        result_.labels.resize(face_count);
        is_valid_.assign(components_->size(), 0);
        may_be_as_asked_.assign(components_->size(), 1);

        std::vector<int> small;
        const auto component_count = static_cast<int>(components_->size());
        for (int i = 0; i < component_count; ++i) {
            if (face_counts[i] < kLargeComponent && component_count > 1) {
                small.push_back(i);
                continue;
            }
            const double begin = done();
            done_faces_ += face_counts[i];
            segment_one(i,
                        options_,
                        device_,
                        component_count > 1 ? sub_progress(progress_, begin, done()) : progress_);
        }
        segment_small(small);
        if (options_.balance == Balance::triangle_count) {
            change_shares();
            // Counts that differ by more may be others than those of the best shares.
            result_.may_be_balanced = result_.best_max_triangle_count_difference > 1 ||
                std::count(may_be_as_asked_.begin(), may_be_as_asked_.end(), 0) == 0;
        }
        if (options_.balance == Balance::triangle_count && submesh_count > 1 &&
            face_count <= kMaxFacesToSearch &&
            count_difference() > result_.best_max_triangle_count_difference) {
            search_all_shares(submesh_count);
        }
        if (!options_.initial_labels.empty() &&
            (component_count > 1 || options_.balance == Balance::weight)) {
            keep_better_input(submesh_count);
        }
        report_run();
        return std::move(result_);
    }

private:
    /// Times, iterations and device of the result.
    void report_run() {
        result_.parametrization_seconds = seconds_.parametrization;
        result_.cohesion_seconds = seconds_.cohesion;
        result_.refinement_seconds = seconds_.refinement;
        result_.cohesion_iterations = history_.cohesion_iterations;
        result_.refinement_iterations = history_.refinement_iterations();
        result_.energy_by_iteration = history_.boundary_edges;
        result_.boundary_edges_by_iteration = std::move(history_.boundary_edges);
        result_.seconds_by_iteration = std::move(history_.seconds);
        result_.time_limit_hit = deadline_.expired();
        result_.used_cuda = device_ && device_->was_used();
    }

    /// Of the largest and the smallest sub-mesh.
    int count_difference() const {
        std::vector<int> counts;
        for (int label : result_.labels) {
            counts.resize(std::max(counts.size(), static_cast<std::size_t>(label) + 1), 0);
            ++counts[label];
        }
        const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
        return *most - *least;
    }

    /// Each component that could not be cut as its share asks gives a sub-mesh to another one, or
    /// takes one from it, where both can be cut then and the MTCD may be as small as before.
    void change_shares() {
        const auto component_count = static_cast<int>(components_->size());
        if (std::count(is_valid_.begin(), is_valid_.end(), 0) == 0 || component_count == 1) {
            return;
        }
        std::vector<int> by_size(component_count);
        std::iota(by_size.begin(), by_size.end(), 0);
        std::stable_sort(by_size.begin(), by_size.end(), [this](int a, int b) {
            return (*components_)[a].face_count() < (*components_)[b].face_count();
        });
        cuts_anew_left_ = kMostCutsAnew * prepared_.mesh().face_count();
        bool changed = false;
        for (int i : by_size) {
            if (!is_valid_[i]) {
                changed = change_share(i, -1, by_size) || change_share(i, 1, by_size) || changed;
            }
        }
        if (changed && !options_.initial_labels.empty()) {
            rename_like(result_.labels,
                        compacted(options_.initial_labels),
                        requested_submesh_count(options_, prepared_.mesh().face_count()));
        }
    }

    /// `partners`: all components, in the order in which they are tried.
    bool change_share(int component, int change, const std::vector<int>& partners) {
        if (!may_take(component, change)) {
            return false;
        }
        ComponentResult own;
        int tried = 0;
        for (auto at = partners.begin(); at != partners.end() && tried < kMostPartners; ++at) {
            if (*at == component || !may_take(*at, -change)) {
                continue;
            }
            if (tried++ == 0) {
                own = cut_anew(component, change);
                if (!own.is_valid) {
                    return false;
                }
            }
            const ComponentResult other = cut_anew(*at, -change);
            if (other.is_valid) {
                const int giver = change < 0 ? component : *at;
                const int taker = change < 0 ? *at : component;
                labels_[taker].names.push_back(labels_[giver].names.back());
                labels_[giver].names.pop_back();
                submesh_counts_[component] += change;
                submesh_counts_[*at] -= change;
                take(component, own);
                take(*at, other);
                return true;
            }
        }
        return false;
    }

    /// May there be a cut with such a share that does not make the MTCD larger than it has to be?
    bool may_take(int component, int change) const {
        if (!may_be_as_asked_[component]) {
            return false;
        }
        const std::int64_t share = submesh_counts_[component] + change;
        const int face_count = (*components_)[component].face_count();
        return share >= 1 && share * counts_.floor <= face_count &&
            face_count <= share * counts_.ceiling;
    }

    /// With another share; not valid when the time is up.
    ComponentResult cut_anew(int component, int change) {
        const int face_count = (*components_)[component].face_count();
        if (cuts_anew_left_ < face_count || deadline_.expired()) {
            return {};
        }
        cuts_anew_left_ -= face_count;
        ComponentTask task = task_of(component);
        task.submesh_count += change;
        task.initial_labels.clear();
        ComponentResult part = cut(component, task, options_, [this](double, const char* message) {
            return !progress_ || progress_(1.0, message);
        });
        seconds_ += part.seconds;
        return part;
    }

    /// The last resort for small meshes: other shares, and any counts that differ as little as
    /// those of the best shares; with few faces also those that differ by more, but less than what
    /// was found.
    void search_all_shares(int submesh_count) {
        const Multilevel finest(prepared_.mesh(), prepared_.dual_graph());
        const int best_difference = result_.best_max_triangle_count_difference;
        const int least_difference = best_difference + (result_.may_be_balanced ? 0 : 1);
        const int end = finest.face_count() <= kFewFaces ? count_difference() : best_difference + 1;
        Patchwork patchwork = finest.coarsen(finest.face_count(), submesh_count);
        for (int difference = least_difference; difference < end; ++difference) {
            if (search_counts(patchwork, difference)) {
                result_.labels = finest.labels(patchwork);
                if (!options_.initial_labels.empty()) {
                    rename_like(result_.labels, compacted(options_.initial_labels), submesh_count);
                }
                return;
            }
        }
    }

    /// False when no cut was found whose counts differ by at most so much.
    bool search_counts(Patchwork& patchwork, int difference) {
        const int mean = patchwork.face_count() / patchwork.submesh_count();
        const int end = std::max(1, mean - difference);
        for (int least = mean; least >= end && !deadline_.for_searches().expired(); --least) {
            report_progress(progress_, 1.0, "Searching");
            if (cut_exactly(patchwork, least, least + difference, kMaxSearchSteps)) {
                return true;
            }
        }
        return false;
    }

    /// Valid initial labels may share the sub-meshes out to the components in another way than
    /// `share_out`, or load a sub-mesh that is too heavy anyway with less; then they can be better.
    void keep_better_input(int submesh_count) {
        const auto measures_of = [&](const std::vector<int>& labels) {
            return measure(prepared_, labels, submesh_count, options_.thread_count);
        };
        const int largest_difference = options_.balance == Balance::weight
            ? prepared_.mesh().face_count()
            : result_.best_max_triangle_count_difference;
        std::vector<int> given = compacted(options_.initial_labels);
        const Measures before = measures_of(given);
        if (!before.is_valid(largest_difference)) {
            return;
        }
        const Measures after = measures_of(result_.labels);
        const bool is_shorter = after.boundary_edge_count < before.boundary_edge_count;
        const bool is_valid = after.is_valid(largest_difference);
        bool is_better = is_valid && is_shorter;
        if (options_.balance == Balance::weight && is_valid) {
            const double gain = weight_imbalance(weights_, given, submesh_count) -
                weight_imbalance(weights_, result_.labels, submesh_count);
            is_better = gain >= -kSameBalance && (gain > 0.0 || is_shorter);
        }
        if (!is_better) {
            result_.labels = std::move(given);
        }
    }

    /// How many sub-meshes each component gets, and which labels.
    void share_out(const std::vector<int>& face_counts, int submesh_count) {
        if (options_.balance == Balance::weight) {
            weights_ = weights_of(options_, prepared_.mesh());
            const std::vector<double> shares = load_shares(weights_, submesh_count);
            std::vector<double> sums;
            for (const Component& component : *components_) {
                double sum = 0.0;
                for (int f = 0; f < component.face_count(); ++f) {
                    sum += shares[component.mesh_face(f)];
                }
                sums.push_back(sum);
            }
            submesh_counts_ = share_submeshes_by_weight(sums, face_counts, submesh_count);
        } else {
            Shares shares = share_submeshes(face_counts, submesh_count);
            result_.best_max_triangle_count_difference = shares.max_triangle_count_difference;
            counts_ = {shares.least_count, shares.largest_count};
            submesh_counts_ = std::move(shares.submesh_counts);
        }
        if (!options_.initial_labels.empty()) {
            labels_ =
                share_labels(*components_, submesh_counts_, compacted(options_.initial_labels));
        }
        labels_.resize(components_->size());
        int label = 0;
        for (std::size_t i = 0; i < labels_.size(); ++i) {
            labels_[i].names.resize(submesh_counts_[i]);
            if (options_.initial_labels.empty()) {
                std::iota(labels_[i].names.begin(), labels_[i].names.end(), label);
            }
            label += submesh_counts_[i];
        }
    }

    ComponentTask task_of(int i) const {
        const Component& component = (*components_)[i];
        ComponentTask task;
        task.submesh_count = submesh_counts_[i];
        task.counts = counts_;
        task.initial_labels = labels_[i].labels;
        for (int f = 0; f < component.face_count() && !weights_.empty(); ++f) {
            task.weights.push_back(weights_[component.mesh_face(f)]);
        }
        return task;
    }

    double done() const {
        return static_cast<double>(done_faces_.load()) / prepared_.mesh().face_count();
    }

    void segment_small(const std::vector<int>& small) {
        const StopWatch watch;
        const StageSeconds before = std::exchange(seconds_, {});
        SegmentOptions options = options_;
        options.thread_count = 1;
        const int threads = resolve_thread_count(options_.thread_count);
        const auto count = static_cast<int>(small.size());
        const auto report = [&] { return !progress_ || progress_(done(), "Components"); };
        run_tasks(count, threads, report, [&](int i, const Progress& progress) {
            segment_one(small[i], options, nullptr, progress);
            done_faces_ += (*components_)[small[i]].face_count();
        });
        // Tasks that run in parallel spend more seconds than pass: scaled to wall-clock time.
        const double passed = watch.elapsed_seconds();
        const double spent = seconds_.sum();
        if (spent > passed) {
            seconds_ *= passed / spent;
        }
        seconds_ += before;
    }

    void segment_one(int i,
                     const SegmentOptions& options,
                     AnnealDevice* device,
                     const Progress& progress) {
        ComponentTask task = task_of(i);
        task.device = device;
        const ComponentResult part = cut(i, task, options, progress);
        take(i, part);
        const std::lock_guard<std::mutex> lock(result_mutex_);
        seconds_ += part.seconds;
        add_iterations(part.history);
    }

    ComponentResult
    cut(int i, const ComponentTask& task, const SegmentOptions& options, const Progress& progress) {
        Component& component = (*components_)[i];
        if (task.submesh_count == 1) {
            ComponentResult whole;
            whole.labels.assign(component.face_count(), 0);
            whole.is_valid = true;
            return whole;
        }
        const bool is_sphere = prepared_.report().is_closed_genus_zero();
        return segment_component(
            component, is_sphere ? &prepared_ : nullptr, options, task, deadline_, progress);
    }

    /// Only of what belongs to the component: others may be taken at the same time.
    void take(int i, const ComponentResult& part) {
        const Component& component = (*components_)[i];
        for (int f = 0; f < component.face_count(); ++f) {
            result_.labels[component.mesh_face(f)] = labels_[i].names[part.labels[f]];
        }
        is_valid_[i] = part.is_valid;
        may_be_as_asked_[i] = part.may_be_as_asked;
    }

    /// The n-th iterations of all components count as one; a component that has ended keeps its
    /// last number of boundary edges.
    void add_iterations(const History& part) {
        const int cohesion = std::max(history_.cohesion_iterations, part.cohesion_iterations);
        const int all =
            cohesion + std::max(history_.refinement_iterations(), part.refinement_iterations());
        History sum;
        sum.cohesion_iterations = cohesion;
        for (int n = 0; n < all; ++n) {
            double edges = 0.0;
            double seconds = 0.0;
            for (const History* from : {&std::as_const(history_), &part}) {
                if (from->count() == 0) {
                    continue;
                }
                const bool is_cohesion = n < cohesion;
                const int own = is_cohesion ? n : from->cohesion_iterations + n - cohesion;
                const int end = is_cohesion ? from->cohesion_iterations : from->count();
                const int last = std::clamp(std::min(own, end - 1), 0, from->count() - 1);
                edges += from->boundary_edges[last];
                seconds += own < end ? from->seconds[own] : 0.0;
            }
            sum.add(edges, seconds);
        }
        history_ = std::move(sum);
    }

    PreparedMesh& prepared_;
    const SegmentOptions& options_;
    const Deadline& deadline_;
    const Progress& progress_;
    AnnealDevice* const device_; // null without
    Segmentation result_;
    std::vector<Component>* components_ = nullptr;
    std::vector<int> submesh_counts_;
    /// Is each component cut as its share asks?
    std::vector<std::uint8_t> is_valid_;
    /// Could it be cut so, with any share, for all that is known?
    std::vector<std::uint8_t> may_be_as_asked_;
    /// Faces that may be cut anew with other shares.
    std::int64_t cuts_anew_left_ = 0;
    /// Without weights: those of all sub-meshes when they differ least.
    LoadRange counts_ = {};
    std::vector<double> weights_;
    std::vector<ComponentLabels> labels_;
    std::atomic<int> done_faces_{0};
    std::mutex result_mutex_;
    StageSeconds seconds_;
    History history_;
};

} // namespace

Segmentation segment_fast(PreparedMesh& prepared,
                          const SegmentOptions& options,
                          const Deadline& deadline,
                          const Progress& progress,
                          AnnealDevice* device) {
    return ComponentWise(prepared, options, deadline, progress, device).run();
}

} // namespace spheroseg
