// SPDX-License-Identifier: GPL-3.0-or-later
#include "branch_annealing.h"

#include "boundary.h"
#include "branches.h"
#include "random.h"

#include <algorithm>
#include <cmath>

namespace spheroseg {

namespace {

/// A branch has at most so many faces: larger limbs pass on coarser levels.
constexpr int kMaxBranchFaces = 128;
/// Faces looked at between two reports of progress: about a millisecond.
constexpr std::int64_t kWorkPerReport = 30000;
/// Thresholds of is_stuck for the sum of the deviations of all loads from the mean: as a part of
/// all faces, and in faces per sub-mesh. Without narrow limbs it was at most 0.4 % of all faces, or
/// one per sub-mesh.
constexpr double kPartOff = 0.01;
constexpr double kFacesOff = 2.0;

class BranchAnnealing {
public:
    BranchAnnealing(Patchwork& patchwork,
                    const AnnealSchedule& schedule,
                    const Deadline* deadline,
                    const Progress& progress)
        : patchwork_(patchwork), schedule_(schedule), deadline_(deadline), progress_(progress),
          boundary_(patchwork, 1), branches_(patchwork), random_(schedule.seed) {}

    void run() {
        const double weight = mean_face_weight(patchwork_);
        for (int phase = 0; phase < schedule_.phase_count; ++phase) {
            temperature_ = schedule_.temperature(phase);
            balance_weight_ = schedule_.balance_weight(phase, weight);
            const auto faces = static_cast<double>(boundary_.faces().size());
            const double proposals = schedule_.proposals_per_face * faces / schedule_.phase_count;
            for (auto left = static_cast<std::int64_t>(proposals); left > 0; --left) {
                if (boundary_.faces().empty() || !goes_on()) {
                    return;
                }
                propose();
            }
        }
    }

private:
    bool goes_on() {
        if (branches_.work() - reported_ < kWorkPerReport) {
            return true;
        }
        reported_ = branches_.work();
        report_progress(progress_, 0.0, "Balancing");
        return !deadline_ || !deadline_->expired();
    }

    void propose() {
        std::vector<int>& faces = boundary_.faces();
        const std::uint32_t at = random_.below(static_cast<std::uint32_t>(faces.size()));
        const int face = faces[at];
        const int from = patchwork_.label(face);
        std::array<int, 3> across;
        std::uint32_t count = 0;
        for (int c = 0; c < 3; ++c) {
            const int label = patchwork_.label_across(face, c);
            if (label >= 0 && label != from) {
                across[count++] = label;
            }
        }
        if (count == 0) {
            boundary_.unlist_at(faces, at);
            return;
        }
        const int to = across[random_.below(count)];
        const std::vector<int>& branch = branches_.find(face, to, kMaxBranchFaces);
        if (!branch.empty() && is_accepted(branch, from, to)) {
            pass(branch, from, to);
        }
    }

    bool is_accepted(const std::vector<int>& branch, int from, int to) {
        double weight = 0.0;
        for (int face : branch) {
            weight += patchwork_.weight(face);
        }
        const double rise =
            2.0 * balance_weight_ * weight * (weight - patchwork_.load[from] + patchwork_.load[to]);
        const double allowance = -temperature_ * std::log(1.0 - random_.uniform());
        return rise + boundary_change(branch, from, to) <= allowance;
    }

    int boundary_change(const std::vector<int>& branch, int from, int to) {
        relabel(branch, to);
        int change = 0;
        for (int face : branch) {
            for (int c = 0; c < 3; ++c) {
                const int neighbor = patchwork_.neighbor(face, c);
                const int label = neighbor < 0 ? kOpenBorder : patchwork_.label(neighbor);
                // Neighbours in the branch have the new label already, which is not told yet.
                change += label == from;
                change -= patchwork_.label_across(face, c) == to;
            }
        }
        relabel(branch, from);
        return change;
    }

    void relabel(const std::vector<int>& branch, int label) {
        for (int face : branch) {
            patchwork_.set_own_label(face, label);
        }
    }

    void pass(const std::vector<int>& branch, int from, int to) {
        for (int face : branch) {
            patchwork_.set_label(face, to);
            patchwork_.load[from] -= patchwork_.weight(face);
            patchwork_.load[to] += patchwork_.weight(face);
        }
        for (int face : branch) {
            boundary_.list_around(patchwork_, face, from, boundary_.faces());
        }
    }

    Patchwork& patchwork_;
    const AnnealSchedule& schedule_;
    const Deadline* const deadline_;
    const Progress& progress_;
    BoundaryFaces boundary_;
    Branches branches_;
    Random random_;
    std::int64_t reported_ = 0;
    double temperature_ = 0.0;
    double balance_weight_ = 0.0;
};

} // namespace

void anneal_branches(Patchwork& patchwork,
                     const AnnealSchedule& schedule,
                     const Deadline* deadline,
                     const Progress& progress) {
    BranchAnnealing(patchwork, schedule, deadline, progress).run();
}

bool is_stuck(const Patchwork& patchwork) {
    const double mean = mean_load(patchwork);
    double off = 0.0;
    for (int load : patchwork.load) {
        off += std::abs(load - mean);
    }
    off /= mean_face_weight(patchwork);
    return off > kPartOff * patchwork.face_count() && off > kFacesOff * patchwork.submesh_count();
}

} // namespace spheroseg
