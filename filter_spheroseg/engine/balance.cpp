// SPDX-License-Identifier: GPL-3.0-or-later
#include "balance.h"

#include "boundary.h"
#include "random.h"

#include <algorithm>

namespace spheroseg {

namespace {

class Balancer {
public:
    Balancer(Patchwork& patchwork, std::int64_t max_searches)
        : patchwork_(patchwork), searches_left_(max_searches), faces_of_(patchwork.submesh_count()),
          parent_(patchwork.submesh_count(), -1), arc_of_(patchwork.submesh_count(), -1) {
        const BoundaryFaces boundary(patchwork, 1);
        for (int f : boundary.faces()) {
            faces_of_[patchwork.cells[f].label].push_back(f);
        }
        floor_ = patchwork.face_count() / patchwork.submesh_count();
        ceiling_ = floor_ + (patchwork.face_count() % patchwork.submesh_count() != 0);
    }

    bool run() {
        std::int64_t least = imbalance();
        for (int idle_rounds = 0; least > 0 && idle_rounds < kMaxIdleRounds && searches_left_ > 0;
             ++idle_rounds) {
            for (int l = 0; l < patchwork_.submesh_count(); ++l) {
                // A chain that breaks leaves its face on the way, so the same label may be off
                // again: no more tries than it had faces too many or too few.
                for (int left = deviation(l); left > 0 && deviation(l) > 0 && searches_left_ > 0;
                     --left) {
                    const bool outward = patchwork_.load[l] > ceiling_;
                    if (!(idle_rounds > 0 ? wander(l, outward) : relieve(l, outward))) {
                        break;
                    }
                }
            }
            const std::int64_t now = imbalance();
            if (now < least) {
                least = now;
                idle_rounds = -1;
            }
        }
        return least == 0;
    }

private:
    /// Rounds without progress before giving up; each searches in another order.
    static constexpr int kMaxIdleRounds = 20;

    /// Faces that a sub-mesh has too many or too few.
    int deviation(int label) const {
        const int load = patchwork_.load[label];
        return std::max({0, load - ceiling_, floor_ - load});
    }

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

    /// The best allowed move to (or, not `outward`, from) each neighbour of a sub-mesh.
    const std::vector<Arc>& arcs(int label, bool outward) {
        --searches_left_;
        arcs_.clear();
        std::vector<int>& faces = faces_of_[label];
        for (std::size_t i = 0; i < faces.size();) {
            const int face = faces[i];
            bool touches = false;
            for (int c = 0; c < 3 && patchwork_.label(face) == label; ++c) {
                const int across = patchwork_.label_across(patchwork_.cells[face], c);
                if (across < 0 || across == label) {
                    continue;
                }
                touches = true;
                Move move;
                int moving = face;
                int corner = c;
                if (!outward) {
                    moving = patchwork_.cells[face].neighbor[c];
                    const Cell& cell = patchwork_.cells[moving];
                    corner = cell.neighbor[0] == face ? 0 : (cell.neighbor[1] == face ? 1 : 2);
                }
                const int at = arc_of_[across];
                if (describe_single(patchwork_, moving, corner, move) &&
                    (at < 0 || move.boundary_change < arcs_[at].move.boundary_change) &&
                    single_is_allowed(patchwork_, moving, corner, move)) {
                    keep_best(move, across);
                }
            }
            if (touches) {
                ++i;
            } else {
                faces[i] = faces.back();
                faces.pop_back();
            }
        }
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

    /// Passes one face from a sub-mesh that has too many to the nearest that can take one, or to
    /// one that has too few from the nearest that can spare one.
    bool relieve(int label, bool outward) {
        queue_.assign(1, label);
        parent_[label] = label;
        int goal = -1;
        for (std::size_t head = 0; head < queue_.size() && goal < 0; ++head) {
            for (const Arc& arc : arcs(queue_[head], outward)) {
                if (parent_[arc.label] >= 0) {
                    continue;
                }
                parent_[arc.label] = queue_[head];
                queue_.push_back(arc.label);
                const int load = patchwork_.load[arc.label];
                if (outward ? load < ceiling_ : load > floor_) {
                    goal = arc.label;
                    break;
                }
            }
        }
        std::vector<int> path;
        if (goal >= 0) {
            for (int l = goal; l != label; l = parent_[l]) {
                path.push_back(l);
            }
            path.push_back(label);
            if (outward) {
                std::reverse(path.begin(), path.end());
            }
        }
        for (int l : queue_) {
            parent_[l] = -1;
        }
        bool moved = false;
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            if (!pass(path[i], path[i + 1])) {
                return moved;
            }
            moved = true;
        }
        return moved;
    }

    /// The same by a random walk: where sub-meshes have two or three faces, the first move of a
    /// chain often forbids the next one, but there is always some other move.
    bool wander(int label, bool outward) {
        int at = label;
        for (int steps = 4 * patchwork_.submesh_count(); steps > 0; --steps) {
            const std::vector<Arc>& ways = arcs(at, outward);
            if (ways.empty()) {
                break;
            }
            const int to = ways.front().label;
            commit(Move(ways.front().move));
            at = to;
            const int load = patchwork_.load[at];
            if (load >= floor_ && load <= ceiling_) {
                break;
            }
        }
        return at != label;
    }

    bool pass(int from, int to) {
        for (const Arc& arc : arcs(from, true)) {
            if (arc.label == to) {
                commit(arc.move);
                return true;
            }
        }
        return false;
    }

    void commit(const Move& move) {
        apply(patchwork_, move);
        const int face = move.faces[0];
        list(face, move.to);
        for (int neighbor : patchwork_.cells[face].neighbor) {
            if (neighbor >= 0 && patchwork_.label(neighbor) == move.from) {
                list(neighbor, move.from);
            }
        }
    }

    void list(int face, int label) {
        std::vector<int>& faces = faces_of_[label];
        if (std::find(faces.begin(), faces.end(), face) == faces.end()) {
            faces.push_back(face);
        }
    }

    Patchwork& patchwork_;
    std::int64_t searches_left_;
    std::vector<std::vector<int>> faces_of_;
    std::vector<int> parent_;
    std::vector<int> arc_of_;
    std::vector<Arc> arcs_;
    std::vector<int> queue_;
    int floor_ = 0;
    int ceiling_ = 0;
    Random random_{0x62616c616e6365ULL};
};

} // namespace

bool balance_exactly(Patchwork& patchwork, std::int64_t max_searches) {
    return Balancer(patchwork, max_searches).run();
}

} // namespace spheroseg
