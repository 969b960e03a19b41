// SPDX-License-Identifier: GPL-3.0-or-later
// The closed forms of the tiles against the tournament itself.
#include "round_tiles.h"

#include "device_swaps.h"
#include "round_robin.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

namespace spheroseg {
namespace {

using Meetings = std::vector<std::vector<int>>; // per element, its partners in order

void meet(Meetings& meetings, int a, int b) {
    meetings[a].push_back(b);
    meetings[b].push_back(a);
}

Meetings tournament(int element_count, int round_begin, int round_end) {
    Meetings meetings(element_count);
    const RoundRobin schedule(element_count);
    for (int round = round_begin; round < round_end; ++round) {
        schedule.for_each_run(round, 0, schedule.slot_count(), [&](const PairRun& run) {
            for (int i = 0; i < run.count; ++i) {
                meet(meetings, run.first + i, run.second - i);
            }
        });
    }
    return meetings;
}

/// Plays the tiles of a step, each whole before the next, and checks that they share no element.
void play_step(const cuda::TilePhase& phase, Meetings& meetings) {
    const int element_count = phase.element_count;
    std::set<int> held_before;
    for (int index = 0; index < phase.block_count - (phase.wedges ? 1 : 0); ++index) {
        const cuda::Tile tile = cuda::tile_of(phase, index);
        ASSERT_LE(tile.held_count(), cuda::most_tile_elements(element_count, phase.block_count));
        for (int place = 0; place < tile.held_count(); ++place) {
            const int element = tile.element_at(place);
            ASSERT_GE(element, 0);
            ASSERT_TRUE(held_before.insert(element).second)
                << "element " << element << " is held twice";
        }
        for (int t = 0; t < tile.round_count; ++t) {
            for (int slot = tile.first_slot(t); slot < tile.end_slot(t); ++slot) {
                const int first = tile.first_place(t, slot);
                const int second = tile.second_place(t, slot);
                ASSERT_GE(std::min(first, second), 0);
                ASSERT_LT(std::max(first, second), tile.held_count());
                const int a = tile.element_at(first);
                const int b = tile.element_at(second);
                if (std::max(a, b) < element_count) {
                    meet(meetings, a, b);
                }
            }
        }
    }
}

TEST(RoundTiles, SlotPairIsThatOfTheTournament) {
    for (int element_count : {2, 3, 4, 5, 8, 9, 30, 31}) {
        const RoundRobin schedule(element_count);
        for (int round = 0; round < schedule.round_count(); ++round) {
            std::vector<std::pair<int, int>> expected;
            std::vector<std::pair<int, int>> found;
            schedule.for_each_run(round, 0, schedule.slot_count(), [&](const PairRun& run) {
                for (int i = 0; i < run.count; ++i) {
                    expected.emplace_back(run.first + i, run.second - i);
                }
            });
            for (int slot = 0; slot < cuda::slot_count_of(element_count); ++slot) {
                const cuda::ElementPair pair = cuda::slot_pair(element_count, round, slot);
                if (pair.second >= 0) {
                    found.emplace_back(pair.first, pair.second);
                }
            }
            EXPECT_EQ(found, expected) << element_count << " elements, round " << round;
        }
    }
}

TEST(RoundTiles, EveryElementMeetsItsPartnersInTheOrderOfTheTournament) {
    for (int element_count = 1; element_count <= 42; ++element_count) {
        const RoundRobin schedule(element_count);
        for (int block_count = 1; block_count <= schedule.slot_count(); ++block_count) {
            if (block_count == 1 && schedule.slot_count() > 1) {
                continue;
            }
            const int most = cuda::rounds_per_phase(element_count, block_count);
            // From any round on, and with a last phase that is shorter than the others.
            for (int begin : {0, schedule.round_count() / 3}) {
                Meetings meetings(element_count);
                for (int round = begin; round < schedule.round_count(); round += most) {
                    const int count = std::min(most, schedule.round_count() - round);
                    play_step({element_count, block_count, round, count, false}, meetings);
                    play_step({element_count, block_count, round, count, true}, meetings);
                }
                ASSERT_EQ(meetings, tournament(element_count, begin, schedule.round_count()))
                    << element_count << " elements, " << block_count << " blocks, from round "
                    << begin;
            }
        }
    }
}

TEST(RoundTiles, BlocksFillTheDeviceWithinTheBoundsOfTheirSize) {
    cuda::SwapTuning tuning;
    tuning.min_slots_per_block = 256;
    tuning.max_slots_per_block = 512;
    // 10,048 slots, at least 256 in a block; 279,488 slots, at most 512.
    EXPECT_EQ(cuda::cohesion_block_count(20096, 132, tuning), 40);
    EXPECT_EQ(cuda::cohesion_block_count(558976, 132, tuning), 546);
    // 40,000 slots on 100 multiprocessors: one block each.
    EXPECT_EQ(cuda::cohesion_block_count(80000, 100, tuning), 100);
    EXPECT_EQ(cuda::cohesion_block_count(4, 132, tuning), 2);
    EXPECT_EQ(cuda::cohesion_block_count(2, 132, tuning), 1);
    EXPECT_EQ(cuda::cohesion_block_count(1, 132, tuning), 1);
}

} // namespace
} // namespace spheroseg
