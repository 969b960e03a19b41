// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "patchwork.h"

#include <cstdint>

namespace spheroseg {

/// Takes the entry at `index` out of a list; the last one comes to its place.
inline void take_out(std::vector<int>& list, std::size_t index) {
    list[index] = list.back();
    list.pop_back();
}

/// The faces that may touch another sub-mesh: all that do, and some that did.
class BoundaryFaces {
public:
    /// Finds them in O(F).
    BoundaryFaces(const Patchwork& patchwork, int thread_count);

    std::vector<int>& faces() { return faces_; }
    const std::vector<int>& faces() const { return faces_; }

    /// One entry per face: whether it is in the list, or in that of a group.
    std::vector<std::uint8_t>& listed() { return listed_; }

    /// Forgets a face that touches no other sub-mesh; the caller takes it from its list.
    void unlist(int face) { listed_[face] = 0; }
    /// The same for the face at `index` of a list, and takes it out of there.
    void unlist_at(std::vector<int>& faces, std::size_t index) {
        unlist(faces[index]);
        take_out(faces, index);
    }

    /// Appends to `faces` a face that left sub-mesh `label` and its neighbours that are still in
    /// it.
    void list_around(const Patchwork& patchwork, int face, int label, std::vector<int>& faces) {
        list(face, faces);
        for (int c = 0; c < 3; ++c) {
            if (patchwork.label_across(face, c) == label) {
                list(patchwork.neighbor(face, c), faces);
            }
        }
    }

private:
    void list(int face, std::vector<int>& faces) {
        if (!listed_[face]) {
            listed_[face] = 1;
            faces.push_back(face);
        }
    }

    std::vector<int> faces_;
    std::vector<std::uint8_t> listed_;
};

/// Edges between sub-meshes, each counted once.
std::int64_t count_boundary_edges(const Patchwork& patchwork, int thread_count);

/// Which sub-meshes touch which: the neighbours of label l are
/// neighbors[begin[l] .. begin[l + 1]), in the order in which the boundary faces name them.
struct SubmeshGraph {
    std::vector<int> begin;
    std::vector<int> neighbors;
};

/// Partitions the sub-meshes into groups of neighbours, and the boundary faces with them.
class Grouping {
public:
    /// Draws other groups: random seeds, grown breadth first over the graph of sub-meshes.
    void regroup(const Patchwork& patchwork,
                 BoundaryFaces& boundary,
                 std::uint64_t seed,
                 int thread_count);
    int group_count() const { return static_cast<int>(faces_.size()) - 1; }
    const std::vector<int>& group_of_label() const { return group_of_label_; }
    /// The listed faces whose label is in the group and that touch another label of it.
    std::vector<int>& faces(int group) { return faces_[group]; }
    /// The groups, those with the most faces first: the order in which threads should take them.
    std::vector<int> largest_first() const;
    /// The load of a label while its group is worked on.
    int load(int label) const { return loads_[slot_of_label_[label]]; }
    int& load(int label) { return loads_[slot_of_label_[label]]; }
    /// Gives the faces and the loads back.
    void collect(std::vector<int>& loads, BoundaryFaces& boundary);

private:
    /// Returns the number of groups.
    int draw_groups(const Patchwork& patchwork, const BoundaryFaces& boundary, std::uint64_t seed);
    /// Grows the groups of the labels in `queue` breadth first over labels without one; empties it.
    void grow_groups(std::vector<int>& queue);
    void place_loads(const std::vector<int>& loads, int group_count);
    /// The group of a face; `idle` if it touches labels of other groups only; below 0 if it touches
    /// no other label.
    int place_of(const Patchwork& patchwork, int face, int idle) const;
    void place_faces(const Patchwork& patchwork,
                     BoundaryFaces& boundary,
                     int group_count,
                     int thread_count);

    SubmeshGraph graph_;
    int phase_ = 0;
    std::vector<int> group_of_label_;
    /// Copies of the loads, those of a group together and far from those of the others, so that
    /// threads do not write to the same cache lines.
    std::vector<int> loads_;
    std::vector<int> slot_of_label_;
    /// Per group its faces; the last entry holds the idle ones.
    std::vector<std::vector<int>> faces_;
    /// Per listed face the result of place_of: its index in faces_.
    std::vector<int> places_;
};

} // namespace spheroseg
