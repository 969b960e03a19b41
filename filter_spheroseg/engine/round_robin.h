// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <utility>

namespace spheroseg {

/// The pairs (first + i, second - i) for i in [0, count).
struct PairRun {
    int first;
    int second;
    int count;
};

/// Round-robin tournament of `element_count` elements by the circle method, in closed form: the
/// index array of Algorithm 2 is never stored. With n = element_count made even, there are n - 1
/// rounds of n / 2 slots; slot j of round r pairs u(j) with u(n - 1 - j), where u(0) = 0 and
/// u(j) = 1 + (j - 1 - r) mod (n - 1). For an odd count the element n - 1 does not exist, and the
/// slot that meets it is idle. Every pair of elements meets exactly once.
/// Source: Haselgrove and Leech, A Tournament Design Problem (as cited by the paper, sec. 3.2).
class RoundRobin {
public:
    explicit RoundRobin(int element_count)
        : element_count_(element_count), even_count_(element_count + element_count % 2) {}

    int round_count() const { return std::max(0, even_count_ - 1); }
    int slot_count() const { return even_count_ / 2; }

    /// Round in which a and b, different and below element_count, meet.
    int round_of(int a, int b) const {
        const int modulus = even_count_ - 1;
        if (a == 0 || b == 0) {
            return modulus - (a + b);
        }
        // The two residues of a slot sum to n - 3 - 2r; 2 has the inverse n / 2 modulo n - 1.
        const long long twice_round = (2LL * modulus + even_count_ - 3 - (a - 1) - (b - 1));
        return static_cast<int>(twice_round % modulus * (even_count_ / 2) % modulus);
    }

    /// Calls visit(PairRun) for the pairs in the slots [slot_begin, slot_end) of a round, in the
    /// order of the slots, as few runs of neighbouring indices (at most four per round).
    template <typename Visit>
    void for_each_run(int round, int slot_begin, int slot_end, const Visit& visit) const {
        const int modulus = even_count_ - 1;
        const int limit = element_count_ - 1; // residues of elements that exist lie below
        int slot = slot_begin;
        if (slot == 0 && slot_end > 0) {
            const int residue = modulus - 1 - round;
            if (residue < limit) {
                visit(PairRun{0, residue + 1, 1});
            }
            ++slot;
        }
        while (slot < slot_end) {
            const int up = wrap(slot - 1 - round, modulus);
            const int down = wrap(even_count_ - 2 - slot - round, modulus);
            if (up >= limit || down >= limit) {
                ++slot;
                continue;
            }
            const int count = std::min({slot_end - slot, limit - up, down + 1});
            visit(PairRun{up + 1, down + 1, count});
            slot += count;
        }
    }

    /// How many rounds from `round` on, at most `round_limit`, meet whole and unbroken runs of
    /// `slot_count` pairs in the slots [slot, slot + slot_count), [slot - 1, ...), [slot - 2, ...):
    /// their second elements are the same in all of them, and the first ones move down by 2. `run`
    /// becomes the first of them.
    int sliding_run(int round, int slot, int slot_count, int round_limit, PairRun& run) const {
        const int modulus = even_count_ - 1;
        const int limit = element_count_ - 1;
        const int up = wrap(slot - 1 - round, modulus);
        const int down = wrap(even_count_ - 2 - slot - round, modulus);
        if (slot < 1 || up + slot_count > limit || down >= limit || down + 1 < slot_count) {
            return 0;
        }
        run = {up + 1, down + 1, slot_count};
        return std::min({round_limit, slot, up / 2 + 1});
    }

private:
    static int wrap(int value, int modulus) { return value < 0 ? value + modulus : value; }

    int element_count_;
    int even_count_;
};

} // namespace spheroseg
