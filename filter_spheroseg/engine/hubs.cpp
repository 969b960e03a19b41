// SPDX-License-Identifier: GPL-3.0-or-later
#include "hubs.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// A mesh without labels, to be walked through.
struct LinkedFaces {
    const std::vector<std::array<NeighborSide, 3>>& sides;

    int neighbor(int face, int corner) const { return face_of(sides[face][corner]); }
    Step step_from(const Step& step) const {
        return step_across(step, sides[step.face][step.exit]);
    }
};

template <typename Shares> auto place_of(Shares& shares, int hub) {
    return std::lower_bound(
        shares.begin(), shares.end(), hub, [](const HubShare& a, int b) { return a.hub < b; });
}

} // namespace

std::shared_ptr<const Hubs> find_hubs(const std::vector<std::array<NeighborSide, 3>>& sides) {
    constexpr int kUnseen = Hubs::kNone - 1;
    const LinkedFaces faces{sides};
    auto found = std::make_shared<Hubs>();
    found->at.assign(sides.size(), {kUnseen, kUnseen, kUnseen});
    for (int f = 0; f < static_cast<int>(sides.size()); ++f) {
        for (int c = 0; c < 3; ++c) {
            if (found->at[f][c] != kUnseen) {
                continue;
            }
            Hubs::Hub hub{0, true};
            for_each_around(faces, f, c, [&](int face, int corner) {
                found->at[face][corner] = Hubs::kNone;
                ++hub.face_count;
                hub.is_closed &=
                    sides[face][corner] >= 0 && sides[face][previous_corner(corner)] >= 0;
            });
            if (hub.face_count > Hubs::kMostWalked) {
                const auto number = static_cast<int>(found->hubs.size());
                for_each_around(
                    faces, f, c, [&](int face, int corner) { found->at[face][corner] = number; });
                found->hubs.push_back(hub);
            }
        }
    }
    return found->hubs.empty() ? nullptr : found;
}

HubShare HubShares::find(int label, int hub) const {
    const std::vector<HubShare>& shares = of_label_[label];
    const auto place = place_of(shares, hub);
    return place != shares.end() && place->hub == hub ? *place : HubShare{hub};
}

void HubShares::add(int label, const HubShare& change) {
    if (!counts(label)) {
        return;
    }
    std::vector<HubShare>& shares = of_label_[label];
    auto place = place_of(shares, change.hub);
    if (place == shares.end() || place->hub != change.hub) {
        shares.insert(place, change);
        return;
    }
    place->faces += change.faces;
    place->ends += change.ends;
    if (place->faces == 0) {
        shares.erase(place);
    }
}

} // namespace spheroseg
