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
          boundaries_(patchwork), graph_(patchwork, boundaries_), even_(even_loads(patchwork)),
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

    void count_work(std::int64_t faces) {
        unreported_ += faces;
        if (unreported_ >= kWorkPerReport) {
            work_left_ -= unreported_;
            unreported_ = 0;
            report_progress(progress_, 0.0, "Balancing");
            is_late_ = deadline_ && deadline_->expired();
            is_over_ = is_late_ || work_left_ <= 0;
        }
    }

    /// A chain that breaks leaves its face on the way, so a label may be off again: no more tries
    /// than it had faces too many or too few.
    void follow_paths() {
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            for (int left = deviation(l); left > 0 && deviation(l) > 0 && !is_over_; --left) {
                if (!relieve(l, patchwork_.load[l] > even_.ceiling)) {
                    break;
                }
            }
        }
    }

    void follow_plans() {
        const auto report = [this](std::int64_t faces) {
            count_work(faces);
            return !is_late_;
        };
        chains_.follow(true, random_, report);
        chains_.follow(false, random_, report);
    }

    /// Faces that a sub-mesh has too many or too few.
    int deviation(int label) const { return even_.deviation(patchwork_.load[label]); }

    /// Passes faces from a sub-mesh that has too many to the nearest that can take one, or to one
    /// that has too few from the nearest that can spare one.
    bool relieve(int label, bool outward) {
        const auto has_room = [&](int other) { return room(other, outward) > 0; };
        const std::vector<int>& path = graph_.find_path(label, outward, has_room, random_);
        count_work(graph_.take_work());
        if (path.empty()) {
            return false;
        }
        // As many faces as the two ends need, as long as the chain holds.
        const int goal = outward ? path.back() : path.front();
        const int needed = std::min(deviation(label), room(goal, outward));
        bool moved = false;
        for (int passed = 0; passed < needed && !is_late_; ++passed) {
            for (std::size_t i = 0; i + 1 < path.size(); ++i) {
                if (!pass(path[i], path[i + 1])) {
                    return moved;
                }
                moved = true;
            }
        }
        return moved;
    }

    /// Faces that a sub-mesh can take (`outward`) or spare.
    int room(int label, bool outward) const { return even_.room(patchwork_.load[label], outward); }

    /// Makes the pass from one sub-mesh to another that costs the fewest boundary edges.
    bool pass(int from, int to) {
        count_work(1 + boundaries_.listed_count(from));
        Move best;
        boundaries_.for_each_side(from, [&](int face, int c, int across) {
            Move move;
            if (across == to && describe_single(patchwork_, face, c, move) &&
                (best.face_count == 0 || move.boundary_change < best.boundary_change) &&
                single_is_allowed(patchwork_, face, c, move)) {
                best = move;
            }
        });
        if (best.face_count == 0) {
            return false;
        }
        graph_.pass(best);
        return true;
    }

    Patchwork& patchwork_;
    const Deadline* const deadline_;
    const Progress& progress_;
    std::int64_t work_left_;
    bool is_late_ = false; // the deadline has expired
    bool is_over_ = false; // that, or the work is done
    std::int64_t unreported_ = 0;
    SubmeshBoundaries boundaries_;
    PassGraph graph_;
    const LoadRange even_;
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
    const LoadRange even = even_loads(patchwork);
    const auto off = std::count_if(patchwork.load.begin(), patchwork.load.end(), [&](int load) {
        return even.deviation(load) > 0;
    });
    return off > kFewOff && kOneOff * off > patchwork.submesh_count();
}

} // namespace spheroseg
