// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cell.h"

#include <array>
#include <memory>
#include <vector>

namespace spheroseg {

/// The vertices of a mesh with more than kMostWalked faces around them, such as the middle of a
/// cylinder's cap or the tip of a cone. Walking around one for each proposed move would take far
/// longer than everything else; the numbers that decide about a move are counted instead
/// (HubShares).
struct Hubs {
    /// At about 100 faces both ways take equally long: counting saves 7 % where sub-meshes have
    /// three faces, and costs 11 % where they have hundreds.
    static constexpr int kMostWalked = 128;
    static constexpr int kNone = -1;

    struct Hub {
        int face_count;
        /// Not on an open border.
        bool is_closed;
    };
    std::vector<Hub> hubs;
    /// Per face and corner the number of the hub there, or kNone.
    std::vector<std::array<int, 3>> at;
};

/// Null when there are none. O(F).
std::shared_ptr<const Hubs> find_hubs(const std::vector<std::array<NeighborSide, 3>>& sides);

/// What a sub-mesh has at a hub.
struct HubShare {
    int hub = Hubs::kNone;
    int faces = 0;
    /// Sides of these faces at the hub across which another label or an open border lies.
    int ends = 0;
};

/// What each sub-mesh has at which hubs, in a list per label: together they are no longer than the
/// hubs have faces, whatever the number of sub-meshes, and threads that work on disjoint groups of
/// labels change none in common.
class HubShares {
public:
    /// Forgets all shares.
    void begin(int submesh_count) {
        of_label_.resize(submesh_count);
        for (std::vector<HubShare>& shares : of_label_) {
            shares.clear();
        }
    }

    /// Are shares kept of this label? Not of kOpenBorder, -1 and other labels that stand for no
    /// sub-mesh.
    bool counts(int label) const {
        return label >= 0 && label < static_cast<int>(of_label_.size());
    }

    /// The share of a label that is counted; without faces where it has none.
    HubShare find(int label, int hub) const;
    /// Adds the numbers in `change` to the share of `label`, if it is counted.
    void add(int label, const HubShare& change);

private:
    /// In the order of the hubs; none without faces.
    std::vector<std::vector<HubShare>> of_label_;
};

} // namespace spheroseg
