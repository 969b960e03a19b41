// SPDX-License-Identifier: GPL-3.0-or-later
#include "anneal.h"

#include "phases.h"

namespace spheroseg {

namespace {

/// Anneals the boundaries among the labels of one group.
class GroupAnnealer {
public:
    GroupAnnealer(Patchwork& patchwork,
                  BoundaryFaces& boundary,
                  Grouping& grouping,
                  int group,
                  const Phase& phase)
        : patchwork_(patchwork), balance_weight_(phase.balance_weight),
          source_(patchwork, boundary, grouping, group, phase) {}

    std::int64_t run() {
        for (auto left = source_.proposal_count(); left > 0 && !source_.exhausted(); --left) {
            ProposalSource::Proposal proposal;
            if (!source_.draw(proposal)) {
                continue;
            }
            if (proposal.as_fan) {
                propose_fan(proposal);
            } else {
                propose_single(proposal);
            }
        }
        return change_;
    }

private:
    double cost(const Move& move) const {
        // Change of the sum of squared loads of the two sub-meshes.
        const double change =
            2.0 * move.weight * (source_.load(move.to) - source_.load(move.from) + move.weight);
        return move.boundary_change + balance_weight_ * change;
    }

    void propose_single(const ProposalSource::Proposal& proposal) {
        Move move;
        if (describe_single(patchwork_, proposal.face, proposal.corner, move) &&
            cost(move) <= proposal.allowance &&
            single_is_allowed(patchwork_, proposal.face, proposal.corner, move)) {
            accept(move);
        }
    }

    void propose_fan(const ProposalSource::Proposal& proposal) {
        Fan fan;
        if (describe_fan(patchwork_, proposal.face, proposal.corner, proposal.forward, fan) &&
            cost(fan.move) <= proposal.allowance && fan_is_allowed(patchwork_, fan)) {
            accept(fan.move);
        }
    }

    void accept(const Move& move) {
        source_.apply(move);
        source_.list(move);
        change_ += move.boundary_change;
    }

    Patchwork& patchwork_;
    const double balance_weight_;
    ProposalSource source_;
    std::int64_t change_ = 0;
};

} // namespace

void anneal(Patchwork& patchwork, const AnnealSchedule& schedule, const AnnealControl& control) {
    if (patchwork.submesh_count() < 2) {
        return;
    }
    double total_load = 0.0;
    for (int load : patchwork.load) {
        total_load += load;
    }
    run_phases(patchwork,
               schedule,
               total_load / patchwork.face_count(),
               control,
               "Refinement",
               [&](Grouping& grouping, BoundaryFaces& boundary, int group, const Phase& phase) {
                   return GroupAnnealer(patchwork, boundary, grouping, group, phase).run();
               });
}

} // namespace spheroseg
