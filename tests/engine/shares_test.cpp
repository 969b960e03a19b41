// SPDX-License-Identifier: GPL-3.0-or-later
#include "shares.h"

#include "random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace spheroseg {
namespace {

/// What shares are judged by, in this order: MTCD, largest count, sum of squared counts.
using Rank = std::array<long long, 3>;

Rank rank_of(const std::vector<int>& face_counts, const std::vector<int>& submesh_counts) {
    long long least = 1 << 30;
    long long most = 0;
    long long squares = 0;
    for (std::size_t i = 0; i < face_counts.size(); ++i) {
        const long long n = face_counts[i];
        const long long parts = submesh_counts[i];
        for (long long p = 0; p < parts; ++p) {
            const long long count = n * (p + 1) / parts - n * p / parts;
            least = std::min(least, count);
            most = std::max(most, count);
            squares += count * count;
        }
    }
    return {most - least, most, squares};
}

/// Tries all shares from component `at` on.
void try_all(const std::vector<int>& face_counts,
             int left,
             std::size_t at,
             std::vector<int>& submesh_counts,
             Rank& best) {
    if (at + 1 == face_counts.size()) {
        if (left >= 1 && left <= face_counts[at]) {
            submesh_counts[at] = left;
            best = std::min(best, rank_of(face_counts, submesh_counts));
        }
        return;
    }
    for (int share = 1; share <= std::min(left, face_counts[at]); ++share) {
        submesh_counts[at] = share;
        try_all(face_counts, left - share, at + 1, submesh_counts, best);
    }
}

TEST(Shares, NoOtherSharesAreBetter) {
    Random random(5);
    for (int run = 0; run < 3000; ++run) {
        std::vector<int> face_counts(1 + random.below(4));
        for (int& n : face_counts) {
            n = 1 + static_cast<int>(random.below(run % 2 ? 12 : 25));
        }
        const int c = static_cast<int>(face_counts.size());
        const int f = std::accumulate(face_counts.begin(), face_counts.end(), 0);
        // Large sub-meshes leave the most to choose.
        const int most_more = run % 3 == 0 ? std::min(3 * c, f - c) : f - c;
        const int k = c + static_cast<int>(random.below(most_more + 1));
        const Shares shares = share_submeshes(face_counts, k);
        ASSERT_EQ(std::accumulate(shares.submesh_counts.begin(), shares.submesh_counts.end(), 0),
                  k);
        for (int i = 0; i < c; ++i) {
            ASSERT_GE(shares.submesh_counts[i], 1);
            ASSERT_LE(shares.submesh_counts[i], face_counts[i]);
        }
        Rank best = {1 << 30, 0, 0};
        std::vector<int> tried(c);
        try_all(face_counts, k, 0, tried, best);
        EXPECT_EQ(rank_of(face_counts, shares.submesh_counts), best) << "run " << run;
        EXPECT_EQ(shares.max_triangle_count_difference, best[0]) << "run " << run;
        EXPECT_EQ(shares.largest_count, best[1]) << "run " << run;
        EXPECT_EQ(shares.least_count, best[1] - best[0]) << "run " << run;
    }
}

TEST(Shares, AreCountedByHand) {
    // One component: as even as division allows.
    EXPECT_EQ(share_submeshes({10}, 3).max_triangle_count_difference, 1);
    EXPECT_EQ(share_submeshes({9}, 3).max_triangle_count_difference, 0);
    // 100 and 50 faces in 3 parts: 50 each.
    EXPECT_EQ(share_submeshes({100, 50}, 3).submesh_counts, (std::vector<int>{2, 1}));
    EXPECT_EQ(share_submeshes({100, 50}, 3).max_triangle_count_difference, 0);
    // A component smaller than the others' parts is one sub-mesh: 100 in 4 parts of 25, and 4.
    EXPECT_EQ(share_submeshes({100, 4}, 5).submesh_counts, (std::vector<int>{4, 1}));
    EXPECT_EQ(share_submeshes({100, 4}, 5).max_triangle_count_difference, 21);
    EXPECT_EQ(share_submeshes({100, 4}, 5).largest_count, 25);
    EXPECT_EQ(share_submeshes({100, 4}, 5).least_count, 4);
    // 9 and 4 parts of 6 differ by less than 4, 5 and 3 parts of 8, although the largest is larger.
    EXPECT_EQ(share_submeshes({9, 24}, 5).submesh_counts, (std::vector<int>{1, 4}));
}

/// The part of a component's sub-meshes that have the larger of two counts that differ by one.
double part_of_larger(int face_count, int share, int smaller_count) {
    return static_cast<double>(face_count) / share - smaller_count;
}

TEST(Shares, AreInProportionWhateverTheOrder) {
    // Of 3 or 4 faces each: 300 : 90 : 10 sub-meshes.
    EXPECT_EQ(share_submeshes({1000, 300, 34}, 400).submesh_counts,
              (std::vector<int>{300, 90, 10}));
    EXPECT_EQ(share_submeshes({34, 300, 1000}, 400).submesh_counts,
              (std::vector<int>{10, 90, 300}));
    // Halves of 4 faces may not exist; a half and two single faces do as long as the rest suffices.
    for (int k = 643; k <= 1283; ++k) {
        EXPECT_EQ(share_submeshes({1280, 4}, k).submesh_counts[1], 3) << k;
        EXPECT_EQ(share_submeshes({4, 1280}, k).submesh_counts[0], 3) << k;
    }
    EXPECT_EQ(share_submeshes({1280, 4}, 642).submesh_counts[1], 2);
    EXPECT_EQ(share_submeshes({1280, 4}, 1284).submesh_counts[1], 4);
}

TEST(Shares, NoComponentHasOnlyOneCountWhereAllCanHaveTwo) {
    Random random(3);
    int compared = 0;
    for (int run = 0; run < 2000; ++run) {
        const int m = 1 + static_cast<int>(random.below(6));
        std::vector<int> face_counts(2 + random.below(5));
        int face_count = 0;
        for (int& n : face_counts) {
            n = 10 * m * (m + 1) + static_cast<int>(random.below(1000));
            face_count += n;
        }
        const int fewest = face_count / (m + 1);
        const int k = fewest + 1 + static_cast<int>(random.below(face_count / m - fewest));
        const Shares shares = share_submeshes(face_counts, k);
        if (shares.max_triangle_count_difference != 1 || shares.least_count != m) {
            continue;
        }
        const double all = part_of_larger(face_count, k, m);
        double step = 0.0;
        for (std::size_t i = 0; i < face_counts.size(); ++i) {
            const double share = shares.submesh_counts[i];
            step = std::max(step, face_counts[i] / (share - 1.0) / share);
        }
        for (std::size_t i = 0; i < face_counts.size(); ++i) {
            const double part = part_of_larger(face_counts[i], shares.submesh_counts[i], m);
            EXPECT_NEAR(part, all, 2.0 * step);
            if (all > 0.2 && all < 0.8) {
                EXPECT_GT(part, 0.0);
                EXPECT_LT(part, 1.0);
                ++compared;
            }
        }
    }
    EXPECT_GT(compared, 1000);
}

TEST(Shares, ManyComponentsAreSharedAtOnce) {
    std::vector<int> face_counts(100000);
    Random random(1);
    for (int& n : face_counts) {
        n = 20 + static_cast<int>(random.below(1000));
    }
    const Shares shares = share_submeshes(face_counts, 1000000);
    EXPECT_EQ(std::accumulate(shares.submesh_counts.begin(), shares.submesh_counts.end(), 0),
              1000000);
}

} // namespace
} // namespace spheroseg
