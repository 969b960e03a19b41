// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "host_device.h"

/// Which pairs a thread block meets, in closed form: `RoundRobin` cut into tiles of slots and
/// rounds that one block plays alone. The same source on host and device.
///
/// A residue r in [0, m) stands for the element r + 1, with m = n - 1 and n the element count made
/// even; slot j of round r pairs the residues j - 1 - r ("up") and m - 1 - j - r ("down") modulo m.
/// In slot 0 both are the same, and its partner is the element 0. With an odd element count the
/// residue m - 1 stands for nothing.
namespace spheroseg::cuda {

struct ElementPair {
    int first;
    int second;
};

/// Elements that slot `slot` of round `round` pairs; `second` is -1 where the slot is idle.
SPHEROSEG_HOST_DEVICE inline ElementPair slot_pair(int element_count, int round, int slot) {
    const int modulus = element_count + element_count % 2 - 1;
    const int up = slot - 1 - round;
    const int down = modulus - 1 - slot - round;
    ElementPair pair{slot == 0 ? 0 : (up < 0 ? up + modulus : up) + 1,
                     (down < 0 ? down + modulus : down) + 1};
    if (pair.first >= element_count || pair.second >= element_count) {
        pair.second = -1;
    }
    return pair;
}

/// The rounds of a phase are played in two steps. First each block plays its own slots, leaving out
/// one more slot per round at each end that it shares with another block; then the wedges left out
/// between the blocks are played. Slot j of a round meets the elements that the slots j - 1, j and
/// j + 1 met in the round before, so that no tile of a step needs an element of another.
struct TilePhase {
    int element_count;
    int block_count; // 1 only where there is one slot
    int round_begin;
    int round_count; // at most rounds_per_phase(element_count, block_count)
    bool wedges;     // the second step: block_count - 1 tiles
};

SPHEROSEG_HOST_DEVICE inline int slot_count_of(int element_count) {
    return (element_count + 1) / 2;
}

/// Half of the slots of the smallest block, so that wedges do not meet; at least 1.
SPHEROSEG_HOST_DEVICE inline int rounds_per_phase(int element_count, int block_count) {
    const int rounds = slot_count_of(element_count) / block_count / 2;
    return rounds > 1 ? rounds : 1;
}

/// Most elements that a tile of a phase meets.
SPHEROSEG_HOST_DEVICE inline int most_tile_elements(int element_count, int block_count) {
    const int slots = slot_count_of(element_count);
    return 2 * ((slots + block_count - 1) / block_count) + 1;
}

/// Slots [begin + left * t, end + right * t) in the round `round_begin` + t. The tile keeps the
/// elements that it meets in one array: the residues from `up_base` on, then, unless both ranges
/// are one, those from `down_base` on, then the element 0 if it meets it.
struct Tile {
    int modulus;
    int round_begin;
    int round_count;
    int begin;
    int end;
    int left;
    int right;
    int up_base;
    int up_count;
    int down_base;
    int down_count;
    int down_offset;
    bool has_zero;

    SPHEROSEG_HOST_DEVICE int first_slot(int t) const { return begin + left * t; }
    SPHEROSEG_HOST_DEVICE int end_slot(int t) const { return end + right * t; }
    SPHEROSEG_HOST_DEVICE int held_count() const { return up_count + down_count + has_zero; }
    /// Places in the tile's array of the two elements that meet in a slot of round t of the tile.
    SPHEROSEG_HOST_DEVICE int first_place(int t, int slot) const {
        return slot == 0 ? up_count + down_count : rising_place(t, slot);
    }
    /// The same in all slots but 0; it goes on by -2 per round where slot plus round stay.
    SPHEROSEG_HOST_DEVICE int rising_place(int t, int slot) const {
        return slot - 1 - round_begin - t - up_base;
    }
    SPHEROSEG_HOST_DEVICE int second_place(int t, int slot) const {
        return modulus - 1 - slot - round_begin - t - down_base + down_offset;
    }
    /// Element at a place of the tile's array.
    SPHEROSEG_HOST_DEVICE int element_at(int place) const {
        if (place == up_count + down_count) {
            return 0;
        }
        const int residue = place < up_count ? up_base + place : down_base + (place - up_count);
        const int wrapped = residue % modulus;
        return (wrapped < 0 ? wrapped + modulus : wrapped) + 1;
    }
};

SPHEROSEG_HOST_DEVICE inline Tile tile_of(const TilePhase& phase, int index) {
    const long long slots = slot_count_of(phase.element_count);
    const auto block_begin = [&](int block) {
        return static_cast<int>(slots * block / phase.block_count);
    };
    Tile tile{};
    tile.modulus = phase.element_count + phase.element_count % 2 - 1;
    tile.round_begin = phase.round_begin;
    tile.round_count = phase.round_count;
    const int modulus = tile.modulus;
    const int round = phase.round_begin;
    const int last = phase.round_count - 1;
    if (phase.wedges) {
        tile.begin = tile.end = block_begin(index + 1);
        tile.left = -1;
        tile.right = 1;
        tile.up_base = tile.begin - 1 - round - 2 * last;
        tile.down_base = modulus - tile.end - round - 2 * last;
        tile.up_count = tile.down_count = tile.down_offset = 2 * last;
        return tile;
    }
    tile.begin = block_begin(index);
    tile.end = block_begin(index + 1);
    tile.left = index == 0 ? 0 : 1;
    tile.right = index == phase.block_count - 1 ? 0 : -1;
    tile.has_zero = index == 0;
    if (tile.left == 0) {
        // Elements that come down to slot 0 go up again: one range, from the lowest to the highest.
        tile.up_base = -tile.end - round;
        tile.up_count = 2 * tile.end - 1;
        tile.down_base = tile.up_base + modulus;
    } else if (tile.right == 0) {
        tile.up_base = tile.down_base = tile.begin - 1 - round;
        tile.up_count = modulus - 2 * tile.begin + 1;
    } else {
        tile.up_base = tile.begin - 1 - round;
        tile.down_base = modulus - tile.end - round;
        tile.up_count = tile.down_count = tile.down_offset = tile.end - tile.begin;
    }
    return tile;
}

} // namespace spheroseg::cuda
