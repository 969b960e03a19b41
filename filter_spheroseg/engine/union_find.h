// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace spheroseg {

/// Sets of the numbers in [0, count), at first of one each. The greatest number of a set names it.
class UnionFind {
public:
    explicit UnionFind(int count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

    /// The name of the set that `i` is in.
    int find(int i) {
        while (parent_[i] != i) {
            parent_[i] = parent_[parent_[i]];
            i = parent_[i];
        }
        return i;
    }

    /// False when both were in one set already.
    bool join(int a, int b) {
        a = find(a);
        b = find(b);
        parent_[std::min(a, b)] = std::max(a, b);
        return a != b;
    }

private:
    std::vector<int> parent_;
};

} // namespace spheroseg
