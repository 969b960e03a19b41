// SPDX-License-Identifier: GPL-3.0-or-later
#include "branches.h"

#include <algorithm>

namespace spheroseg {

namespace {

/// Which of the faces around a vertex belong to which fan of faces of one label: the number of a
/// fan, from 1 on; 0: another label. `around` has them in order; `closed`: the first follows the
/// last.
int number_fans(const Patchwork& patchwork,
                const std::vector<Corner>& around,
                bool closed,
                int label,
                std::vector<int>& fan_of) {
    const std::size_t count = around.size();
    fan_of.assign(count, 0);
    int fans = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (patchwork.label(around[i].face) == label) {
            fan_of[i] = i > 0 && fan_of[i - 1] > 0 ? fan_of[i - 1] : ++fans;
        }
    }
    if (closed && fans > 1 && fan_of.front() > 0 && fan_of.back() > 0) {
        std::replace(fan_of.begin(), fan_of.end(), fans, 1);
        --fans;
    }
    return fans;
}

} // namespace

const std::vector<int>& Branches::find(int face, int to, int max_faces) {
    const int from = patchwork_.label(face);
    const auto limit = static_cast<std::size_t>(max_faces);
    branch_.clear();
    add(face, to);
    bool closed = false;
    for (std::size_t before = 0; !closed && before != branch_.size();) {
        before = branch_.size();
        if (!close_fans(from, to, limit) || !close_parts(from, to, limit)) {
            break;
        }
        closed = branch_.size() == before;
    }
    for (int f : branch_) {
        patchwork_.set_label(f, from);
    }
    if (!closed) {
        branch_.clear();
    }
    return branch_;
}

/// While the search runs, the faces of the branch have the new label.
void Branches::add(int face, int to) {
    patchwork_.set_label(face, to);
    branch_.push_back(face);
}

/// Adds faces until neither sub-mesh has a bowtie at a face of the branch.
bool Branches::close_fans(int from, int to, std::size_t max_faces) {
    for (std::size_t i = 0; i < branch_.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            if (!close_vertex(branch_[i], c, from, to) || branch_.size() > max_faces) {
                return false;
            }
        }
    }
    return true;
}

bool Branches::close_vertex(int face, int corner, int from, int to) {
    int from_ends = 0;
    int to_ends = 0;
    if (is_counted(patchwork_, face, corner, from) && is_counted(patchwork_, face, corner, to)) {
        from_ends = share_at(patchwork_, face, corner, from).ends;
        to_ends = share_at(patchwork_, face, corner, to).ends;
        ++work_;
    } else {
        for_each_around(patchwork_, face, corner, [&](int other, int at) {
            const int label = patchwork_.label(other);
            from_ends += label == from ? fan_ends(patchwork_, other, at) : 0;
            to_ends += label == to ? fan_ends(patchwork_, other, at) : 0;
            ++work_;
        });
    }
    if (from_ends <= 2 && to_ends <= 2) {
        return true;
    }
    const bool ring = list_corners(patchwork_, face, corner, around_);
    std::vector<int>& fan_of = part_;
    if (to_ends > 2) {
        // What lies between two fans of the new sub-mesh goes to it.
        for (const Corner& other : around_) {
            if (patchwork_.label(other.face) == from) {
                add(other.face, to);
            }
        }
        return number_fans(patchwork_, around_, ring, to, fan_of) == 1;
    }
    const int fans = number_fans(patchwork_, around_, ring, from, fan_of);
    // All but the largest fan go, which brings the new one together too.
    int largest = 1;
    for (int fan = 2; fan <= fans; ++fan) {
        const auto size = [&](int n) { return std::count(fan_of.begin(), fan_of.end(), n); };
        largest = size(fan) > size(largest) ? fan : largest;
    }
    for (std::size_t i = 0; i < around_.size(); ++i) {
        if (fan_of[i] > 0 && fan_of[i] != largest) {
            add(around_[i].face, to);
        }
    }
    return number_fans(patchwork_, around_, ring, to, fan_of) == 1;
}

/// Adds all connected parts of what is left of the sub-mesh but (nearly always) the largest. The
/// searches take turns: when all but one have found their parts, the last part is at least about as
/// large as they are and need not be walked through.
bool Branches::close_parts(int from, int to, std::size_t max_faces) {
    begin_searches(from);
    const std::size_t room = max_faces - std::min(max_faces, branch_.size());
    const auto is_open = [](const Search& search) { return search.head < search.open.size(); };
    int open_count = search_count_;
    for (bool any_goes_on = true; open_count > 1 && any_goes_on;) {
        any_goes_on = false;
        for (int i = 0; i < search_count_ && open_count > 1; ++i) {
            if (is_open(searches_[i]) && searches_[i].faces.size() <= room) {
                go_on(i, from);
                open_count = static_cast<int>(
                    std::count_if(searches_.begin(), searches_.begin() + search_count_, is_open));
                any_goes_on = true;
            }
        }
    }
    std::vector<int>& small = part_;
    small.clear();
    for (int i = 0; i < search_count_; ++i) {
        const Search& search = searches_[i];
        for (int face : search.faces) {
            search_of_[face] = kNone;
        }
        work_ += static_cast<std::int64_t>(search.faces.size());
        if (!is_open(search)) {
            small.insert(small.end(), search.faces.begin(), search.faces.end());
        }
    }
    if (open_count != 1 || small.size() > room) {
        return false;
    }
    for (int f : small) {
        add(f, to);
    }
    return true;
}

/// Begins a search at each face of sub-mesh `from` that is adjacent to the branch.
void Branches::begin_searches(int from) {
    search_count_ = 0;
    for (int face : branch_) {
        for (int neighbor : patchwork_.neighbors(face)) {
            if (neighbor >= 0 && patchwork_.label(neighbor) == from &&
                search_of_[neighbor] == kNone) {
                const int number = search_count_++;
                if (number == static_cast<int>(searches_.size())) {
                    searches_.emplace_back();
                }
                Search& search = searches_[number];
                search.clear_into(number);
                search.faces.push_back(neighbor);
                search.open.push_back(neighbor);
                search_of_[neighbor] = number;
            }
        }
    }
}

/// Takes one step of a search, and merges the searches that it meets into it.
void Branches::go_on(int number, int from) {
    Search& search = searches_[number];
    const int face = search.open[search.head++];
    for (int neighbor : patchwork_.neighbors(face)) {
        if (neighbor < 0 || patchwork_.label(neighbor) != from) {
            continue;
        }
        if (search_of_[neighbor] == kNone) {
            search_of_[neighbor] = number;
            search.faces.push_back(neighbor);
            search.open.push_back(neighbor);
        } else if (const int other = root_of(search_of_[neighbor]); other != number) {
            Search& met = searches_[other];
            search.faces.insert(search.faces.end(), met.faces.begin(), met.faces.end());
            search.open.insert(search.open.end(),
                               met.open.begin() + static_cast<std::ptrdiff_t>(met.head),
                               met.open.end());
            met.clear_into(number);
        }
    }
}

int Branches::root_of(int search) const {
    while (searches_[search].into != search) {
        search = searches_[search].into;
    }
    return search;
}

} // namespace spheroseg
