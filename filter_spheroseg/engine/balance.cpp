// SPDX-License-Identifier: GPL-3.0-or-later
#include "balance.h"

#include "branches.h"
#include "pass_graph.h"
#include "planned_chains.h"
#include "random.h"
#include "submesh_boundaries.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

class Balancer {
public:
    Balancer(Patchwork& patchwork,
             std::int64_t max_work,
             const Deadline* deadline,
             const Progress& progress)
        : patchwork_(patchwork), work_left_(max_work), deadline_(deadline), progress_(progress),
          boundaries_(patchwork), branches_(patchwork), graph_(patchwork.submesh_count()),
          arc_of_(patchwork.submesh_count(), -1), even_(even_loads(patchwork)),
          chains_(patchwork, boundaries_, even_) {}

    bool run() {
        std::int64_t least = imbalance();
        bool by_plan = false;
        for (int idle_rounds = 0; least > 0 && idle_rounds < kMaxIdleRounds && work_left_ > 0;
             ++idle_rounds) {
            is_idle_ = idle_rounds > 0;
            if (is_idle_ && is_overdue()) {
                break;
            }
            if (idle_rounds == 1) {
                // What follows may lead astray.
                best_ = patchwork_;
                least_of_best_ = imbalance();
            }
            if (idle_rounds > kMaxIdleRounds / 2) {
                for_each_off([&](int label, bool outward) { return wander(label, outward); });
            } else if (by_plan) {
                shake(idle_rounds);
                follow_plans();
            } else {
                build_graph();
                for_each_off([&](int label, bool outward) { return relieve(label, outward); });
            }
            const std::int64_t now = imbalance();
            // Where many chains break, planning them costs more and pays.
            by_plan = by_plan || 2 * now > least;
            if (now < least) {
                least = now;
                idle_rounds = -1;
            }
        }
        if (!best_.cells.empty() && least_of_best_ < imbalance()) {
            patchwork_ = best_;
        }
        return least == 0;
    }

private:
    /// Rounds without progress before giving up; each searches in another order.
    static constexpr int kMaxIdleRounds = 20;
    static constexpr int kMaxBranchFaces = 64;
    /// Work between two reports of progress: about a millisecond.
    static constexpr std::int64_t kWorkPerReport = 30000;
    /// Sub-meshes of the graph that are met in the time of a face.
    static constexpr std::int64_t kLabelsPerFace = 4;
    /// Faces looked at for branches, at most.
    static constexpr std::int64_t kBranchWorkPerFace = 1000;

    bool is_overdue() const { return deadline_ && deadline_->is_overdue(); }

    void count_work(std::int64_t faces) {
        work_left_ -= faces;
        unreported_ += faces;
        if (unreported_ >= kWorkPerReport) {
            unreported_ = 0;
            report_progress(progress_, 0.0, "Balancing");
            if (is_idle_ && is_overdue()) {
                work_left_ = 0;
            }
        }
    }

    /// Calls `pass(label, outward)` for the sub-meshes that are off, as long as it answers true. A
    /// chain that breaks leaves its face on the way, so the same label may be off again: no more
    /// tries than it had faces too many or too few.
    template <typename Pass> void for_each_off(Pass pass) {
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            for (int left = deviation(l); left > 0 && deviation(l) > 0 && work_left_ > 0; --left) {
                if (!pass(l, patchwork_.load[l] > even_.ceiling)) {
                    break;
                }
            }
        }
    }

    /// As long as that brings the loads nearer to balance.
    void follow_plans() {
        const auto go_on = [this](std::int64_t faces) {
            count_work(faces);
            return work_left_ > 0;
        };
        std::int64_t before = 0;
        std::int64_t now = imbalance();
        do {
            before = now;
            chains_.follow(true, random_, go_on);
            chains_.follow(false, random_, go_on);
            now = imbalance();
        } while (now < before && work_left_ > 0);
    }

    /// Passes random faces out of the neighbours of the sub-meshes that are off, `times` for every
    /// side that they share: they could give or take none as they were.
    void shake(int times) {
        std::vector<int> neighbors;
        for (int l = 0; times > 0 && l < patchwork_.submesh_count(); ++l) {
            if (deviation(l) > 0) {
                boundaries_.for_each_side(
                    l, [&](int, int, int across) { neighbors.push_back(across); });
            }
        }
        for (int label : neighbors) {
            for (int i = 0; i < times; ++i) {
                const std::vector<Arc>& ways = arcs(label, true, [](int) { return true; });
                if (!ways.empty()) {
                    boundaries_.commit(ways.front().move);
                }
            }
        }
    }

    /// Faces that a sub-mesh has too many or too few.
    int deviation(int label) const { return even_.deviation(patchwork_.load[label]); }

    std::int64_t imbalance() const {
        std::int64_t sum = 0;
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            sum += deviation(l);
        }
        return sum;
    }

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

    /// The best allowed move to (or, not `outward`, from) each wanted neighbour of a sub-mesh.
    template <typename Wanted>
    const std::vector<Arc>& arcs(int label, bool outward, Wanted is_wanted) {
        count_work(1 + boundaries_.listed_count(label));
        arcs_.clear();
        boundaries_.for_each_side(label, [&](int face, int c, int across) {
            if (!is_wanted(across)) {
                return;
            }
            const Side side = passing_side(patchwork_, face, c, outward);
            const int at = arc_of_[across];
            Move move;
            if (describe_single(patchwork_, side.face, side.corner, move) &&
                (at < 0 || move.boundary_change < arcs_[at].move.boundary_change) &&
                single_is_allowed(patchwork_, side.face, side.corner, move)) {
                keep_best(move, across);
            }
        });
        for (const Arc& arc : arcs_) {
            arc_of_[arc.label] = -1;
        }
        if (arcs_.size() > 1) {
            std::rotate(arcs_.begin(),
                        arcs_.begin() + random_.below(static_cast<std::uint32_t>(arcs_.size())),
                        arcs_.end());
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
        } while (!is_open(*path));
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

    /// Can a face pass at every step, as the sub-meshes are? Blocks what leads nowhere where not.
    bool is_open(const std::vector<int>& path) {
        bool open = true;
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            if (arcs_between(path[i], path[i + 1]).empty()) {
                open = false;
                const std::vector<Arc>& ways = arcs(path[i], true, [](int) { return true; });
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

    /// The same by a random walk; where sub-meshes are narrow, whole branches pass.
    bool wander(int label, bool outward) {
        const bool with_branches = branches_.work() < kBranchWorkPerFace * patchwork_.face_count();
        int at = label;
        for (int steps = 4 * patchwork_.submesh_count(); steps > 0 && work_left_ > 0; --steps) {
            int to = with_branches && random_.below(2) == 0 ? pass_branch(at, outward) : -1;
            if (to < 0) {
                const std::vector<Arc>& ways = arcs(at, outward, [](int) { return true; });
                if (!ways.empty()) {
                    to = ways.front().label;
                    boundaries_.commit(ways.front().move);
                } else if (!with_branches || (to = pass_branch(at, outward)) < 0) {
                    break;
                }
            }
            at = to;
            if (deviation(at) == 0) {
                break;
            }
        }
        return at != label;
    }

    /// Passes a branch, drawn at random from those of up to about twice as many faces as there are
    /// too many (or too few). Returns the sub-mesh at the other side of it; -1 when there is none.
    int pass_branch(int label, bool outward) {
        const std::int64_t branch_work = branches_.work();
        const int max_faces = std::min(kMaxBranchFaces, 2 + 2 * deviation(label));
        int other = -1;
        std::uint32_t count = 0;
        chosen_.clear();
        boundaries_.for_each_side(label, [&](int face, int c, int across) {
            const int moving = outward ? face : patchwork_.neighbor(face, c);
            const std::vector<int>& branch =
                branches_.find(moving, outward ? across : label, max_faces);
            if (!branch.empty() &&
                is_worth(static_cast<int>(branch.size()),
                         outward ? label : across,
                         outward ? across : label) &&
                random_.below(++count) == 0) {
                chosen_ = branch;
                other = across;
            }
        });
        count_work(1 + boundaries_.listed_count(label) + branches_.work() - branch_work);
        for (int face : chosen_) {
            boundaries_.pass(face, outward ? label : other, outward ? other : label);
        }
        return other;
    }

    /// Whether to pass so many faces at once: if it brings the loads no farther from balance, and
    /// by chance where it does.
    bool is_worth(int face_count, int from, int to) {
        const int rise = even_.deviation(patchwork_.load[from] - face_count) +
            even_.deviation(patchwork_.load[to] + face_count) - deviation(from) - deviation(to);
        return rise <= 0 || random_.uniform() < std::exp(-0.5 * rise);
    }

    /// None, or the best move from one sub-mesh to another.
    const std::vector<Arc>& arcs_between(int from, int to) {
        return arcs(from, true, [to](int other) { return other == to; });
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
    std::int64_t work_left_;
    std::int64_t unreported_ = 0;
    /// Did the last round make no progress?
    bool is_idle_ = false;
    const Deadline* const deadline_;
    const Progress& progress_;
    SubmeshBoundaries boundaries_;
    Branches branches_;
    std::vector<int> chosen_;
    Patchwork best_;
    std::int64_t least_of_best_ = 0;
    PassGraph graph_;
    std::vector<int> arc_of_;
    std::vector<Arc> arcs_;
    const EvenLoads even_;
    PlannedChains chains_;
    Random random_{0x62616c616e6365ULL};
};

} // namespace

bool balance_exactly(Patchwork& patchwork,
                     std::int64_t max_work,
                     const Deadline* deadline,
                     const Progress& progress) {
    return Balancer(patchwork, max_work, deadline, progress).run();
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
