// SPDX-License-Identifier: GPL-3.0-or-later
#include "anneal.h"

#include "anneal_device.h"
#include "parallel_tasks.h"
#include "threads.h"

#include <algorithm>
#include <atomic>

namespace spheroseg {

namespace {

/// Proposals of a phase that make another thread worth while.
constexpr int kProposalsPerThread = 2000;

/// Per label a list of candidates for the second half of an exchange: faces that may lie on the
/// boundary of the sub-mesh. Some may have another label by now, or be listed twice.
class PartnerLists {
public:
    explicit PartnerLists(int submesh_count) : lists_(submesh_count) {}

    /// Empties all lists.
    void clear() {
        for (List& list : lists_) {
            list.faces.clear();
            list.capacity = partner_capacity(0);
        }
    }

    /// Begins the empty lists of a group's labels with its boundary faces.
    void begin(const Patchwork& patchwork, const std::vector<int>& faces) {
        for (int f : faces) {
            lists_[patchwork.label(f)].faces.push_back(f);
        }
        for (int f : faces) {
            List& list = lists_[patchwork.label(f)];
            list.capacity = partner_capacity(list.faces.size());
        }
    }

    std::vector<int>& operator[](int label) { return lists_[label].faces; }
    void add(int label, int face) {
        if (lists_[label].faces.size() < lists_[label].capacity) {
            lists_[label].faces.push_back(face);
        }
    }

private:
    struct List {
        std::vector<int> faces;
        std::size_t capacity = 0;
    };
    std::vector<List> lists_;
};

/// What the groups of a phase are made of.
struct Work {
    Patchwork& patchwork;
    Grouping& grouping;
    BoundaryFaces& boundary;
    PartnerLists* partners; // null without
};

/// The `Group` of group_moves.h on one core.
class CoreGroup {
public:
    CoreGroup(const Work& work, int group, const Phase& phase)
        : patchwork_(work.patchwork), grouping_(work.grouping), boundary_(work.boundary),
          partners_(work.partners), group_(group), rules_{work.grouping.group_of_label().data(),
                                                          exponential_quantiles().data(),
                                                          group,
                                                          phase.temperature},
          faces_(std::move(work.grouping.faces(group))),
          proposal_count_(
              proposal_count(phase.proposals_per_face, static_cast<int>(faces_.size()))),
          random_(phase.seed, static_cast<std::uint64_t>(group)) {
        if (partners_) {
            partners_->begin(patchwork_, faces_);
        }
    }
    ~CoreGroup() { grouping_.faces(group_) = std::move(faces_); }
    CoreGroup(const CoreGroup&) = delete;
    CoreGroup& operator=(const CoreGroup&) = delete;

    /// Makes all proposals of the phase; returns the change of the number of boundary edges.
    template <typename Loads> std::int64_t anneal(const Loads& loads) {
        std::int64_t change = 0;
        for (auto left = proposal_count_; left > 0 && !faces_.empty(); --left) {
            Proposal proposal;
            Fan fan;
            if (draw(proposal) && loads.wants(*this, proposal, fan)) {
                change += loads.make(*this, proposal, fan);
            }
        }
        return change;
    }

    const Patchwork& patches() const { return patchwork_; }
    int load(int label) const { return grouping_.load(label); }
    Random& random() { return random_; }

    void apply(const Move& move) { relabel(move, move.from, move.to); }
    void undo(const Move& move) { relabel(move, move.to, move.from); }
    /// Lists the faces that came to the boundary when a move was made.
    void list(const Move& move) {
        for (int i = 0; i < move.face_count; ++i) {
            boundary_.list_around(patchwork_, move.faces[i], move.from, faces_);
        }
    }

    int partner_count(int label) const { return static_cast<int>((*partners_)[label].size()); }
    int partner(int label, int index) const { return (*partners_)[label][index]; }
    void drop_partner(int label, int index) { take_out((*partners_)[label], index); }
    void add_partner(int label, int face) { partners_->add(label, face); }

private:
    bool draw(Proposal& proposal) {
        const std::uint64_t bits = random_.next();
        const int index = index_of(bits, static_cast<int>(faces_.size()));
        const Drawn drawn = draw_proposal(patchwork_, rules_, faces_[index], bits, proposal);
        if (drawn == Drawn::stale) {
            boundary_.unlist_at(faces_, index);
        }
        return drawn == Drawn::proposal;
    }

    void relabel(const Move& move, int from, int to) {
        for (int i = 0; i < move.face_count; ++i) {
            patchwork_.set_label(move.faces[i], to);
        }
        grouping_.load(from) -= move.weight;
        grouping_.load(to) += move.weight;
    }

    Patchwork& patchwork_;
    Grouping& grouping_;
    BoundaryFaces& boundary_;
    PartnerLists* const partners_;
    const int group_;
    const GroupRules rules_;
    std::vector<int> faces_;
    const std::int64_t proposal_count_;
    Random random_;
};

/// Progress within phases is told at most so often.
constexpr double kSecondsPerReport = 0.1;

/// `report` is called now and then on the calling thread; it may throw.
template <typename Loads, typename Report>
std::int64_t run_on_cores(const Work& work,
                          const Phase& phase,
                          const Loads& loads,
                          int thread_count,
                          const Report& report) {
    if (work.partners) {
        work.partners->clear();
    }
    const std::vector<int> groups = work.grouping.largest_first();
    const auto group_count = static_cast<int>(groups.size());
    const auto face_count = static_cast<int>(work.boundary.faces().size());
    const int threads = threads_for(
        thread_count, proposal_count(phase.proposals_per_face, face_count), kProposalsPerThread);
    std::atomic<std::int64_t> change{0};
    StopWatch since_report;
    const auto report_at_times = [&] {
        if (since_report.elapsed_seconds() >= kSecondsPerReport) {
            report();
            since_report = {};
        }
        return true;
    };
    run_tasks(group_count, threads, report_at_times, [&](int i, const Progress&) {
        change += CoreGroup(work, groups[i], phase).anneal(loads);
    });
    return change;
}

/// Calls phases(run); `run(phase, loads, grouping, boundary, report)` makes the proposals of all
/// groups, on the device if there is one, and returns the change of the number of boundary edges.
/// In between labels must not be changed otherwise.
template <typename Phases>
void with_groups(Patchwork& patchwork,
                 const AnnealControl& control,
                 PartnerLists* partners,
                 int threads,
                 const Phases& phases) {
    if (control.device) {
        const std::unique_ptr<DeviceGroups> groups =
            control.device->begin_groups(patchwork, partners != nullptr, threads);
        phases(
            [&](const Phase& phase,
                const auto& loads,
                Grouping& grouping,
                BoundaryFaces& boundary,
                const auto&) { return groups->run(phase, loads, patchwork, grouping, boundary); });
        return;
    }
    phases([&](const Phase& phase,
               const auto& loads,
               Grouping& grouping,
               BoundaryFaces& boundary,
               const auto& report) {
        return run_on_cores(
            {patchwork, grouping, boundary, partners}, phase, loads, threads, report);
    });
}

std::uint64_t seed_of(const AnnealSchedule& schedule, int phase) {
    return schedule.seed * 0x9E3779B97F4A7C15ULL + static_cast<std::uint64_t>(phase);
}

bool is_over(const AnnealControl& control, int phase) {
    return phase >= control.max_phases || (control.deadline && control.deadline->expired());
}

/// Runs the phases of a schedule: new groups of labels in each. `loads_of(phase)` gives the rule
/// for the loads.
template <typename LoadsOf>
void run_phases(Patchwork& patchwork,
                const AnnealSchedule& schedule,
                const AnnealControl& control,
                const char* step,
                PartnerLists* partners,
                const LoadsOf& loads_of) {
    const int threads = resolve_thread_count(schedule.thread_count);
    with_groups(patchwork, control, partners, threads, [&](const auto& run) {
        BoundaryFaces boundary(patchwork, threads);
        std::int64_t edges = count_boundary_edges(patchwork, threads);
        Grouping grouping;
        const int phases = std::max(1, schedule.phase_count);
        const double face_count =
            std::max<double>(1.0, static_cast<double>(boundary.faces().size()));
        const double proposals =
            std::max(schedule.proposals_per_face, schedule.least_proposals / face_count) / phases;
        for (int p = 0; p < phases && !is_over(control, p); ++p) {
            const auto report = [&] {
                report_progress(control.progress, static_cast<double>(p) / phases, step);
            };
            report();
            const StopWatch watch;
            const Phase phase{schedule.temperature(p), proposals, seed_of(schedule, p)};
            grouping.regroup(patchwork, boundary, phase.seed, threads);
            edges += run(phase, loads_of(p), grouping, boundary, report);
            grouping.collect(patchwork.load, boundary);
            if (control.history) {
                control.history->add(static_cast<double>(edges), watch.elapsed_seconds());
            }
        }
    });
}

/// The boundary edges inside each group.
std::vector<std::int64_t>
edges_of_groups(const Patchwork& patchwork, const Grouping& grouping, int threads) {
    const std::vector<int>& group_of_label = grouping.group_of_label();
    std::vector<std::atomic<std::int64_t>> sides(grouping.group_count());
    const int face_count = patchwork.face_count();
    for_each_share(
        face_count, threads_for(threads, face_count, kFacesPerThread), [&](int begin, int end) {
            for (int f = begin; f < end; ++f) {
                const int label = patchwork.label(f);
                const int group = group_of_label[label];
                for (int c = 0; c < 3; ++c) {
                    const int across = patchwork.label_across(f, c);
                    if (across != label && across != kOpenBorder &&
                        group_of_label[across] == group) {
                        sides[group].fetch_add(1, std::memory_order_relaxed);
                    }
                }
            }
        });
    std::vector<std::int64_t> edges;
    for (const std::atomic<std::int64_t>& count : sides) {
        edges.push_back(count / 2);
    }
    return edges;
}

/// Gives the faces of groups that have more boundary edges than `edges` their `labels` again.
void undo_worse_groups(Patchwork& patchwork,
                       const Grouping& grouping,
                       const std::vector<std::int64_t>& edges,
                       const std::vector<int>& labels,
                       int threads) {
    const std::vector<std::int64_t> edges_now = edges_of_groups(patchwork, grouping, threads);
    for (int f = 0; f < patchwork.face_count(); ++f) {
        const int group = grouping.group_of_label()[labels[f]];
        if (edges_now[group] > edges[group]) {
            patchwork.set_own_label(f, labels[f]);
        }
    }
    patchwork.tell_neighbors(threads);
    sum_loads(patchwork);
}

void run_rounds(Patchwork& patchwork,
                const AnnealSchedule& schedule,
                const AnnealControl& control,
                const char* step,
                PartnerLists& partners,
                const BoundedLoads& range) {
    const int threads = resolve_thread_count(schedule.thread_count);
    const int phases = std::max(1, schedule.phase_count);
    const double all_phases = static_cast<double>(schedule.round_count) * phases;
    Grouping grouping;
    for (int round = 0; round < schedule.round_count && !is_over(control, round); ++round) {
        const StopWatch watch;
        const int first = round * phases;
        BoundaryFaces boundary(patchwork, threads);
        grouping.regroup(patchwork, boundary, seed_of(schedule, first), threads);
        const std::vector<int> labels = cell_labels(patchwork);
        const std::vector<std::int64_t> edges = edges_of_groups(patchwork, grouping, threads);
        with_groups(patchwork, control, &partners, threads, [&](const auto& run) {
            for (int p = 0; p < phases && !is_over(control, round); ++p) {
                const auto report = [&] {
                    report_progress(control.progress, (first + p) / all_phases, step);
                };
                report();
                const Phase phase{schedule.temperature(p),
                                  schedule.proposals_per_face / phases,
                                  seed_of(schedule, first + p)};
                run(phase, range, grouping, boundary, report);
            }
        });
        undo_worse_groups(patchwork, grouping, edges, labels, threads);
        if (control.history) {
            control.history->add(static_cast<double>(count_boundary_edges(patchwork, threads)),
                                 watch.elapsed_seconds());
        }
    }
}

void anneal_within(Patchwork& patchwork,
                   const AnnealSchedule& schedule,
                   const AnnealControl& control,
                   const BoundedLoads& range) {
    constexpr const char* kStep = "Exchanges";
    PartnerLists partners(patchwork.submesh_count());
    if (schedule.round_count > 0) {
        run_rounds(patchwork, schedule, control, kStep, partners, range);
    } else {
        run_phases(patchwork, schedule, control, kStep, &partners, [&](int) { return range; });
    }
}

} // namespace

void anneal(Patchwork& patchwork, const AnnealSchedule& schedule, const AnnealControl& control) {
    if (patchwork.submesh_count() < 2) {
        return;
    }
    const double face_weight = mean_face_weight(patchwork);
    run_phases(patchwork, schedule, control, "Refinement", nullptr, [&](int phase) {
        return FreeLoads{schedule.balance_weight(phase, face_weight)};
    });
}

void anneal_balanced(Patchwork& patchwork,
                     const AnnealSchedule& schedule,
                     const AnnealControl& control) {
    if (patchwork.submesh_count() > 1) {
        const LoadRange even = even_loads(patchwork);
        anneal_within(patchwork, schedule, control, {even.floor, even.ceiling});
    }
}

void anneal_below(Patchwork& patchwork,
                  int limit,
                  const AnnealSchedule& schedule,
                  const AnnealControl& control) {
    if (patchwork.submesh_count() > 1) {
        anneal_within(patchwork, schedule, control, {0, limit});
    }
}

} // namespace spheroseg
