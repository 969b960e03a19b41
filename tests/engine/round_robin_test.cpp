// SPDX-License-Identifier: GPL-3.0-or-later
#include "round_robin.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace spheroseg {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

Pairs pairs_of_round(const RoundRobin& schedule, int round, int slot_begin, int slot_end) {
    Pairs pairs;
    schedule.for_each_run(round, slot_begin, slot_end, [&](const PairRun& run) {
        for (int i = 0; i < run.count; ++i) {
            pairs.emplace_back(run.first + i, run.second - i);
        }
    });
    return pairs;
}

/// Algorithm 2 with its index array, for an even count.
std::vector<Pairs> paper_schedule(int n) {
    std::vector<int> u(n);
    for (int j = 0; j < n; ++j) {
        u[j] = j;
    }
    std::vector<Pairs> rounds;
    for (int round = 0; round < n - 1; ++round) {
        Pairs pairs;
        for (int j = 0; j < n / 2; ++j) {
            pairs.emplace_back(u[j], u[n - 1 - j]);
        }
        rounds.push_back(pairs);
        for (int j = 1; j < n; ++j) {
            u[j] = u[j] - 1 < 1 ? n - 1 : u[j] - 1;
        }
    }
    return rounds;
}

TEST(RoundRobin, FollowsTheIndexArrayOfThePaper) {
    for (int n : {2, 4, 6, 8, 30}) {
        const RoundRobin schedule(n);
        const std::vector<Pairs> expected = paper_schedule(n);
        ASSERT_EQ(schedule.round_count(), n - 1);
        for (int round = 0; round < n - 1; ++round) {
            EXPECT_EQ(pairs_of_round(schedule, round, 0, n / 2), expected[round])
                << "round " << round << " of " << n;
        }
    }
}

TEST(RoundRobin, EveryPairMeetsExactlyOnceAndNobodyTwiceInARound) {
    for (int count = 0; count <= 41; ++count) {
        const RoundRobin schedule(count);
        std::set<std::pair<int, int>> met;
        for (int round = 0; round < schedule.round_count(); ++round) {
            std::set<int> busy;
            for (const auto& [a, b] : pairs_of_round(schedule, round, 0, schedule.slot_count())) {
                ASSERT_TRUE(a >= 0 && b >= 0 && a < count && b < count && a != b);
                EXPECT_TRUE(busy.insert(a).second && busy.insert(b).second);
                EXPECT_TRUE(met.insert(std::minmax(a, b)).second);
                EXPECT_EQ(schedule.round_of(a, b), round);
                EXPECT_EQ(schedule.round_of(b, a), round);
            }
        }
        EXPECT_EQ(static_cast<int>(met.size()), count * (count - 1) / 2) << count;
    }
}

TEST(RoundRobin, PartsOfARoundJoinToTheWholeRound) {
    for (int count : {16, 17}) {
        const RoundRobin schedule(count);
        for (int round = 0; round < schedule.round_count(); ++round) {
            const Pairs whole = pairs_of_round(schedule, round, 0, schedule.slot_count());
            for (int cut = 0; cut <= schedule.slot_count(); ++cut) {
                Pairs parts = pairs_of_round(schedule, round, 0, cut);
                const Pairs rest = pairs_of_round(schedule, round, cut, schedule.slot_count());
                parts.insert(parts.end(), rest.begin(), rest.end());
                EXPECT_EQ(parts, whole);
            }
        }
    }
}

TEST(RoundRobin, SlidingRunsAreTheRunsOfTheRounds) {
    constexpr int kSlots = 5;
    for (int count : {40, 41}) {
        const RoundRobin schedule(count);
        int step_total = 0;
        for (int round = 0; round < schedule.round_count(); ++round) {
            for (int slot = 0; slot + kSlots <= schedule.slot_count(); ++slot) {
                PairRun run{};
                const int limit = schedule.round_count() - round;
                const int steps = schedule.sliding_run(round, slot, kSlots, limit, run);
                for (int step = 0; step < steps; ++step) {
                    Pairs expected;
                    for (int i = 0; i < kSlots; ++i) {
                        expected.emplace_back(run.first - 2 * step + i, run.second - i);
                    }
                    EXPECT_EQ(
                        pairs_of_round(schedule, round + step, slot - step, slot - step + kSlots),
                        expected);
                }
                step_total += steps;
            }
        }
        EXPECT_GT(step_total, 1000);
    }
}

TEST(RoundRobin, ARoundIsFewRuns) {
    for (int count : {1000, 1001}) {
        const RoundRobin schedule(count);
        for (int round = 0; round < schedule.round_count(); ++round) {
            int runs = 0;
            schedule.for_each_run(round, 0, schedule.slot_count(), [&](const PairRun&) { ++runs; });
            EXPECT_LE(runs, 4);
        }
    }
}

TEST(RoundRobin, OneElementHasNobodyToMeet) {
    const RoundRobin schedule(1);
    EXPECT_EQ(schedule.round_count(), 1);
    EXPECT_TRUE(pairs_of_round(schedule, 0, 0, schedule.slot_count()).empty());
    EXPECT_EQ(RoundRobin(0).round_count(), 0);
}

} // namespace
} // namespace spheroseg
