// SPDX-License-Identifier: GPL-3.0-or-later
#include "balance.h"

#include "pass_graph.h"
#include "planned_chains.h"
#include "random.h"
#include "submesh_boundaries.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// Thresholds of is_hopeless: more than kFewOff sub-meshes are off, and more than one in kOneOff.
/// In the runs that were balanced in the end, recuts had left at most 73 sub-meshes off, and of
/// more than a thousand at most one in 60.
constexpr std::int64_t kFewOff = 100;
constexpr std::int64_t kOneOff = 50;

class Balancer {
public:
    Balancer(Patchwork& patchwork,
             const Deadline* deadline,
             const Progress& progress,
             std::int64_t most_work)
        : patchwork_(patchwork), deadline_(deadline), progress_(progress), work_left_(most_work),
          boundaries_(patchwork), graph_(patchwork.submesh_count()),
          arc_of_(patchwork.submesh_count(), -1), even_(even_loads(patchwork)),
          chains_(patchwork, boundaries_, even_) {}

    bool run() {
        std::int64_t now = misplaced(patchwork_);
        // Does a round take off at least one of `parts` parts of what is off?
        const auto pays = [&](auto round, int parts) {
            const std::int64_t before = now;
            round();
            now = misplaced(patchwork_);
            return parts * (before - now) >= before;
        };
        while (now > 0 && !is_over_ && pays([this] { follow_paths(); }, 2)) {
        }
        // Where many chains break, planning them costs more and pays.
        while (now > 0 && !is_over_ && pays([this] { follow_plans(); }, 8)) {
        }
        return now == 0;
    }

private:
    /// Work between two reports of progress: about a millisecond.
    static constexpr std::int64_t kWorkPerReport = 30000;
    /// Sub-meshes that a search of the graph visits in the time that one face takes.
    static constexpr std::int64_t kLabelsPerFace = 4;

    void count_work(std::int64_t faces) {
        unreported_ += faces;
        if (unreported_ >= kWorkPerReport) {
            work_left_ -= unreported_;
            unreported_ = 0;
            report_progress(progress_, 0.0, "Balancing");
            is_over_ = work_left_ <= 0 || (deadline_ && deadline_->expired());
        }
    }

    /// A chain that breaks leaves its face on the way, so a label may be off again: no more tries
    /// than it had faces too many or too few.
    void follow_paths() {
        build_graph();
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            for (int left = deviation(l); left > 0 && deviation(l) > 0 && !is_over_; --left) {
                if (!relieve(l, patchwork_.load[l] > even_.ceiling)) {
                    break;
                }
            }
        }
    }

    void follow_plans() {
        const auto report = [this](std::int64_t faces) { count_work(faces); };
        chains_.follow(true, random_, report);
        chains_.follow(false, random_, report);
    }

    /// Faces that a sub-mesh has too many or too few.
    int deviation(int label) const { return even_.deviation(patchwork_.load[label]); }

    struct Arc {
        int label;
        Move move;
    };

    void keep_best(const Move& move, int label) {
        int& at = arc_of_[label];
        if (at < 0) {
            at = static_cast<int>(arcs_.size());
            arcs_.push_back({label, move});
        } else if (move.boundary_change < arcs_[at].move.boundary_change) {
            arcs_[at].move = move;
        }
    }

    /// The best allowed move to each wanted neighbour of a sub-mesh.
    template <typename Wanted> const std::vector<Arc>& arcs(int label, Wanted is_wanted) {
        count_work(1 + boundaries_.listed_count(label));
        arcs_.clear();
        boundaries_.for_each_side(label, [&](int face, int c, int across) {
            if (!is_wanted(across)) {
                return;
            }
            const int at = arc_of_[across];
            Move move;
            if (describe_single(patchwork_, face, c, move) &&
                (at < 0 || move.boundary_change < arcs_[at].move.boundary_change) &&
                single_is_allowed(patchwork_, face, c, move)) {
                keep_best(move, across);
            }
        });
        for (const Arc& arc : arcs_) {
            arc_of_[arc.label] = -1;
        }
        return arcs_;
    }

    void build_graph() {
        graph_ = PassGraph(patchwork_.submesh_count());
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            boundaries_.for_each_side(l, [&](int, int, int across) { graph_.link(l, across); });
        }
    }

    /// Passes faces from a sub-mesh that has too many to the nearest that can take one, or to one
    /// that has too few from the nearest that can spare one.
    bool relieve(int label, bool outward) {
        const auto has_room = [&](int other) { return room(other, outward) > 0; };
        const std::vector<int>* path;
        do {
            path = &graph_.find_path(label, outward, has_room, random_);
            count_work(graph_.met_count() / kLabelsPerFace);
            if (path->empty()) {
                return false;
            }
        } while (!is_open(*path) && !is_over_);
        // As many faces as the two ends need, as long as the chain holds.
        const int goal = outward ? path->back() : path->front();
        const int needed = std::min(deviation(label), room(goal, outward));
        bool moved = false;
        for (int passed = 0; passed < needed; ++passed) {
            for (std::size_t i = 0; i + 1 < path->size(); ++i) {
                if (!pass((*path)[i], (*path)[i + 1])) {
                    return moved;
                }
                moved = true;
            }
        }
        return moved;
    }

    /// Can a face pass at every step of the path now? Where not, blocks all arcs from that sub-mesh
    /// through which no face can pass.
    bool is_open(const std::vector<int>& path) {
        bool open = true;
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            if (arcs_between(path[i], path[i + 1]).empty()) {
                open = false;
                const std::vector<Arc>& ways = arcs(path[i], [](int) { return true; });
                graph_.block_from(path[i], [&](int other) {
                    return std::any_of(ways.begin(), ways.end(), [other](const Arc& way) {
                        return way.label == other;
                    });
                });
            }
        }
        return open;
    }

    /// Faces that a sub-mesh can take (`outward`) or spare.
    int room(int label, bool outward) const { return even_.room(patchwork_.load[label], outward); }

    /// None, or the best move from one sub-mesh to another.
    const std::vector<Arc>& arcs_between(int from, int to) {
        return arcs(from, [to](int other) { return other == to; });
    }

    bool pass(int from, int to) {
        const std::vector<Arc>& found = arcs_between(from, to);
        if (found.empty()) {
            return false;
        }
        const int face = found.front().move.faces[0];
        boundaries_.commit(found.front().move);
        graph_.change(from, to);
        for (int c = 0; c < 3; ++c) {
            const int across = patchwork_.label_across(face, c);
            if (across >= 0 && across != to) {
                graph_.link(to, across);
            }
        }
        return true;
    }

    Patchwork& patchwork_;
    const Deadline* const deadline_;
    const Progress& progress_;
    std::int64_t work_left_;
    bool is_over_ = false;
    std::int64_t unreported_ = 0;
    SubmeshBoundaries boundaries_;
    PassGraph graph_;
    std::vector<int> arc_of_;
    std::vector<Arc> arcs_;
    const EvenLoads even_;
    PlannedChains chains_;
    Random random_{0x62616c616e6365ULL};
};

} // namespace

bool balance_exactly(Patchwork& patchwork,
                     const Deadline* deadline,
                     const Progress& progress,
                     std::int64_t most_work) {
    return Balancer(patchwork, deadline, progress, most_work).run();
}

bool is_hopeless(const Patchwork& patchwork) {
    const EvenLoads even = even_loads(patchwork);
    const auto off = std::count_if(patchwork.load.begin(), patchwork.load.end(), [&](int load) {
        return even.deviation(load) > 0;
    });
    return off > kFewOff && kOneOff * off > patchwork.submesh_count();
}

bool is_near_balance(const Patchwork& patchwork) {
    const int ceiling = even_loads(patchwork).ceiling;
    std::int64_t excess = 0;
    for (int load : patchwork.load) {
        excess += std::max(0, load - ceiling);
    }
    return 10 * excess <= patchwork.face_count();
}

} // namespace spheroseg
