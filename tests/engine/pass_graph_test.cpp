// SPDX-License-Identifier: GPL-3.0-or-later
#include "pass_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <queue>
#include <set>
#include <utility>
#include <vector>

namespace spheroseg {
namespace {

/// The same graph as sets of ordered pairs, and its distances by plain breadth-first search.
struct Reference {
    int count;
    std::set<std::pair<int, int>> open; // (from, to): a face can pass

    /// Steps from `label` (`outward`) or to it; -1: out of reach.
    std::vector<int> distances(int label, bool outward) const {
        std::vector<int> distance(count, -1);
        std::queue<int> queue;
        queue.push(label);
        distance[label] = 0;
        for (; !queue.empty(); queue.pop()) {
            const int at = queue.front();
            for (int other = 0; other < count; ++other) {
                const auto step = outward ? std::pair(at, other) : std::pair(other, at);
                if (distance[other] < 0 && open.count(step) > 0) {
                    distance[other] = distance[at] + 1;
                    queue.push(other);
                }
            }
        }
        return distance;
    }
};

TEST(PassGraph, PathsAreShortestAndAvoidWhatIsBlockedUntilItChanges) {
    constexpr int kLabels = 40;
    Random random(3);
    PassGraph graph(kLabels);
    Reference reference{kLabels, {}};
    std::set<std::pair<int, int>> linked;
    const auto draw = [&] { return static_cast<int>(random.below(kLabels)); };
    for (int i = 0; i < 70; ++i) {
        const int a = draw();
        const int b = draw();
        if (a != b) {
            graph.link(a, b);
            for (const auto& step : {std::pair(a, b), std::pair(b, a)}) {
                linked.insert(step);
                reference.open.insert(step);
            }
        }
    }
    int found = 0;
    int missing = 0;
    for (int round = 0; round < 2000; ++round) {
        if (random.below(8) == 0) {
            // Whatever was known of the two does not hold any more.
            const int a = draw();
            const int b = draw();
            graph.change(a, b);
            for (const auto& step : linked) {
                if (step.first == a || step.second == a || step.first == b || step.second == b) {
                    reference.open.insert(step);
                }
            }
        } else if (random.below(2) == 0) {
            const int from = draw();
            const int kept = draw();
            graph.block_from(from, [&](int other) {
                const bool is_open = other % 3 == kept % 3;
                if (!is_open) {
                    reference.open.erase({from, other});
                }
                return is_open;
            });
        }
        const int label = draw();
        const bool outward = random.below(2) == 0;
        const std::set<int> ends = {draw(), draw()};
        const std::vector<int> distance = reference.distances(label, outward);
        int least = -1;
        for (int end : ends) {
            if (end != label && distance[end] >= 0 && (least < 0 || distance[end] < least)) {
                least = distance[end];
            }
        }
        const std::vector<int>& path = graph.find_path(
            label, outward, [&](int other) { return ends.count(other) > 0; }, random);
        ASSERT_EQ(static_cast<int>(path.size()), least + 1) << "round " << round;
        if (path.empty()) {
            ++missing;
            continue;
        }
        ++found;
        EXPECT_EQ(outward ? path.front() : path.back(), label);
        EXPECT_EQ(ends.count(outward ? path.back() : path.front()), 1u);
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            EXPECT_EQ(reference.open.count({path[i], path[i + 1]}), 1u) << "round " << round;
        }
    }
    EXPECT_GT(found, 500);
    EXPECT_GT(missing, 100);
}

} // namespace
} // namespace spheroseg
