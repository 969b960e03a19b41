// SPDX-License-Identifier: GPL-3.0-or-later
#include "anneal.h"

#include "phases.h"

namespace spheroseg {

namespace {

/// Faces of the other sub-mesh that are tried as the second half of an exchange.
constexpr int kPartnerTries = 16;
/// The most that a single move back can save.
constexpr int kBestPartner = 1;

/// The loads that are allowed.
struct LoadRange {
    int floor;
    int ceiling;
};

class GroupExchanger {
public:
    GroupExchanger(Patchwork& patchwork,
                   BoundaryFaces& boundary,
                   Grouping& grouping,
                   int group,
                   const Phase& phase,
                   const LoadRange& balance,
                   std::vector<std::vector<int>>& faces_of_label)
        : patchwork_(patchwork), balance_(balance), faces_of_label_(faces_of_label),
          source_(patchwork, boundary, grouping, group, phase) {
        for (int f : source_.faces()) {
            faces_of_label_[patchwork_.label(f)].clear();
        }
        for (int f : source_.faces()) {
            faces_of_label_[patchwork_.label(f)].push_back(f);
        }
    }

    std::int64_t run() {
        for (auto left = source_.proposal_count(); left > 0 && !source_.exhausted(); --left) {
            ProposalSource::Proposal proposal;
            Fan fan;
            if (source_.draw(proposal) &&
                describe(proposal.face, proposal.corner, proposal.as_fan, proposal.forward, fan)) {
                try_move(proposal, fan);
            }
        }
        return change_;
    }

private:
    bool describe(int face, int corner, bool as_fan, bool forward, Fan& fan) const {
        return as_fan ? describe_fan(patchwork_, face, corner, forward, fan)
                      : describe_single(patchwork_, face, corner, fan.move);
    }

    bool is_allowed(int face, int corner, bool as_fan, const Fan& fan) const {
        return as_fan ? fan_is_allowed(patchwork_, fan)
                      : single_is_allowed(patchwork_, face, corner, fan.move);
    }

    bool in_balance(int from_load, int to_load) const {
        return from_load >= balance_.floor && from_load <= balance_.ceiling &&
            to_load >= balance_.floor && to_load <= balance_.ceiling;
    }

    void try_move(const ProposalSource::Proposal& proposal, const Fan& fan) {
        const Move& move = fan.move;
        const bool alone =
            in_balance(source_.load(move.from) - move.weight, source_.load(move.to) + move.weight);
        if (move.boundary_change > proposal.allowance + (alone ? 0 : kBestPartner) ||
            !is_allowed(proposal.face, proposal.corner, proposal.as_fan, fan)) {
            return;
        }
        source_.apply(move);
        if (!alone && !exchange_back(move, proposal.allowance - move.boundary_change)) {
            source_.undo(move);
            return;
        }
        list(move);
    }

    /// Looks for a move from `first.to` back to `first.from` that restores the balance.
    bool exchange_back(const Move& first, double allowance) {
        std::vector<int>& faces = faces_of_label_[first.to];
        for (int i = 0; i < kPartnerTries && !faces.empty(); ++i) {
            const std::uint64_t bits = source_.random().next();
            const auto count = static_cast<std::uint64_t>(faces.size());
            const auto index = static_cast<std::size_t>(((bits >> 32) * count) >> 32);
            const int face = faces[index];
            if (patchwork_.label(face) != first.to) {
                faces[index] = faces.back();
                faces.pop_back();
                continue;
            }
            int corner = 0;
            while (corner < 3 &&
                   patchwork_.label_across(patchwork_.cells[face], corner) != first.from) {
                ++corner;
            }
            if (corner == 3) {
                continue;
            }
            const bool as_fan = first.face_count > 1;
            Fan fan;
            if (describe(face, corner, as_fan, (bits >> 1) & 1, fan) && fan.move.to == first.from &&
                fan.move.boundary_change <= allowance &&
                in_balance(source_.load(fan.move.from) - fan.move.weight,
                           source_.load(fan.move.to) + fan.move.weight) &&
                is_allowed(face, corner, as_fan, fan)) {
                source_.apply(fan.move);
                list(fan.move);
                return true;
            }
        }
        return false;
    }

    void list(const Move& move) {
        for (int i = 0; i < move.face_count; ++i) {
            const int face = move.faces[i];
            faces_of_label_[move.to].push_back(face);
            for (int neighbor : patchwork_.cells[face].neighbor) {
                if (neighbor >= 0 && patchwork_.label(neighbor) == move.from) {
                    faces_of_label_[move.from].push_back(neighbor);
                }
            }
        }
        source_.list(move);
        change_ += move.boundary_change;
    }

    Patchwork& patchwork_;
    const LoadRange balance_;
    std::vector<std::vector<int>>& faces_of_label_;
    ProposalSource source_;
    std::int64_t change_ = 0;
};

void anneal_within(Patchwork& patchwork,
                   const AnnealSchedule& schedule,
                   const AnnealControl& control,
                   const LoadRange& balance) {
    std::vector<std::vector<int>> faces_of_label(patchwork.submesh_count());
    run_phases(patchwork,
               schedule,
               1.0,
               control,
               "Exchanges",
               [&](Grouping& grouping, BoundaryFaces& boundary, int group, const Phase& phase) {
                   return GroupExchanger(
                              patchwork, boundary, grouping, group, phase, balance, faces_of_label)
                       .run();
               });
}

} // namespace

void anneal_balanced(Patchwork& patchwork,
                     const AnnealSchedule& schedule,
                     const AnnealControl& control) {
    const int submesh_count = patchwork.submesh_count();
    if (submesh_count > 1) {
        const int floor = patchwork.face_count() / submesh_count;
        const int ceiling = floor + (patchwork.face_count() % submesh_count != 0);
        anneal_within(patchwork, schedule, control, {floor, ceiling});
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
