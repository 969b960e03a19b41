// SPDX-License-Identifier: GPL-3.0-or-later
#include "load_lowering.h"

#include "random.h"
#include "submesh_boundaries.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// A side across which its face may pass.
struct Passage {
    SubmeshSide side;
    Move move;
};

class LoadLowering {
public:
    LoadLowering(Patchwork& patchwork,
                 int limit,
                 const Deadline* deadline,
                 const Progress& progress)
        : patchwork_(patchwork), limit_(limit), deadline_(deadline), progress_(progress),
          boundaries_(patchwork), inflow_(patchwork.submesh_count(), -1),
          came_by_(patchwork.submesh_count()) {
        work_left_ = kMinWork;
        for (int l = 0; l < patchwork.submesh_count(); ++l) {
            work_left_ += kWorkPerFace * boundaries_.listed_count(l);
        }
    }

    bool run() {
        std::vector<int> heavy;
        for (int idle_rounds = 0; idle_rounds < kMaxIdleRounds && may_go_on(); ++idle_rounds) {
            const std::int64_t before = excess(heavy);
            if (heavy.empty()) {
                return true;
            }
            for (int label : heavy) {
                int tries = boundaries_.listed_count(label) + kExtraTries;
                while (patchwork_.load[label] > limit_ && tries-- > 0 && may_go_on() &&
                       relieve(label)) {
                }
            }
            if (excess(heavy) < before) {
                idle_rounds = -1;
            }
        }
        excess(heavy);
        return heavy.empty();
    }

private:
    static constexpr int kMaxIdleRounds = 8;
    static constexpr int kExtraTries = 64;
    /// The work before giving up, counted in boundary faces looked at: a minimum, and an addition
    /// per boundary face. The time of a look grows with the degrees of the face's vertices; only
    /// the deadline bounds it.
    static constexpr std::int64_t kMinWork = 200000;
    static constexpr std::int64_t kWorkPerFace = 50;
    /// Work between two checks of the clock: about 0.1 ms where vertices have usual degrees.
    static constexpr std::int64_t kWorkPerReport = 1000;

    bool may_go_on() const { return work_left_ > 0 && !is_over_; }

    void count_work(std::int64_t faces) {
        work_left_ -= faces;
        unreported_ += faces;
        if (unreported_ >= kWorkPerReport) {
            unreported_ = 0;
            report_progress(progress_, 0.0, "Balancing");
            is_over_ = deadline_ && deadline_->expired();
        }
    }

    /// Sum of what lies above the limit; lists the labels where something does.
    std::int64_t excess(std::vector<int>& heavy) const {
        heavy.clear();
        std::int64_t sum = 0;
        for (int l = 0; l < patchwork_.submesh_count(); ++l) {
            if (patchwork_.load[l] > limit_) {
                sum += patchwork_.load[l] - limit_;
                heavy.push_back(l);
            }
        }
        return sum;
    }

    /// Lists the allowed moves of single faces out of a sub-mesh, from a random one on.
    void find_passages(int label) {
        passages_.clear();
        count_work(boundaries_.listed_count(label));
        boundaries_.for_each_side(label, [&](int face, int corner, int) {
            Passage passage{{face, corner}, {}};
            if (is_allowed_pass(patchwork_, passage.side, passage.move)) {
                passages_.push_back(passage);
            }
        });
        if (passages_.size() > 1) {
            std::rotate(passages_.begin(),
                        passages_.begin() +
                            random_.below(static_cast<std::uint32_t>(passages_.size())),
                        passages_.end());
        }
    }

    /// Searches, breadth first, for a chain of moves from a sub-mesh above the limit to one with
    /// room, and makes them. Each sub-mesh of the chain passes on at least the part of its inflow
    /// that puts it above the limit. Returns whether anything moved.
    bool relieve(int start) {
        queue_.assign(1, start);
        inflow_[start] = 0;
        Passage last{{-1, 0}, {}};
        for (std::size_t head = 0; head < queue_.size() && last.side.face < 0 && !is_over_;
             ++head) {
            const int label = queue_[head];
            const int must_pass =
                label == start ? 1 : patchwork_.load[label] + inflow_[label] - limit_;
            find_passages(label);
            last = best_end(must_pass);
            if (last.side.face < 0) {
                extend(must_pass);
            }
        }
        const bool moved = last.side.face >= 0 && carry_out(start, last);
        for (int l : queue_) {
            inflow_[l] = -1;
        }
        return moved;
    }

    /// The move after which the chain may end that costs the fewest boundary edges.
    Passage best_end(int must_pass) const {
        Passage best{{-1, 0}, {}};
        for (const Passage& passage : passages_) {
            const Move& move = passage.move;
            if (inflow_[move.to] < 0 && move.weight >= must_pass &&
                patchwork_.load[move.to] + move.weight <= limit_ &&
                (best.side.face < 0 || move.boundary_change < best.move.boundary_change)) {
                best = passage;
            }
        }
        return best;
    }

    /// Continues the search to every neighbour, by the lightest move that is heavy enough.
    void extend(int must_pass) {
        for (const Passage& passage : passages_) {
            const Move& move = passage.move;
            if (move.weight < must_pass) {
                continue;
            }
            int& inflow = inflow_[move.to];
            if (inflow < 0) {
                queue_.push_back(move.to);
            } else if (came_by_[move.to].move.from != move.from || inflow <= move.weight) {
                continue;
            }
            inflow = move.weight;
            came_by_[move.to] = passage;
        }
    }

    /// Makes the moves of the chain, the last one first, so that no load comes above the limit
    /// when one of them is not allowed any more.
    bool carry_out(int start, const Passage& last) {
        bool relieved = false;
        for (Passage passage = last;;) {
            Move move;
            if (!is_allowed_pass(patchwork_, passage.side, move) ||
                move.from != passage.move.from || move.to != passage.move.to) {
                return relieved;
            }
            boundaries_.commit(move);
            relieved = true;
            if (move.from == start) {
                return true;
            }
            passage = came_by_[move.from];
        }
    }

    Patchwork& patchwork_;
    const int limit_;
    const Deadline* const deadline_;
    const Progress& progress_;
    std::int64_t work_left_ = 0;
    std::int64_t unreported_ = 0;
    bool is_over_ = false;
    SubmeshBoundaries boundaries_;
    /// Per label the weight that the chain moves into it; -1: not reached by the search.
    std::vector<int> inflow_;
    std::vector<Passage> came_by_;
    std::vector<Passage> passages_;
    std::vector<int> queue_;
    Random random_{0x77656967687473ULL};
};

} // namespace

bool lower_loads(Patchwork& patchwork,
                 int limit,
                 const Deadline* deadline,
                 const Progress& progress) {
    return LoadLowering(patchwork, limit, deadline, progress).run();
}

} // namespace spheroseg
