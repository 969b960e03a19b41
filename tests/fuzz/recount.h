// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "types.h"

#include <vector>

namespace spheroseg::fuzz {

/// What a labelling is like, counted from the definitions by plain means that share no code with
/// the engine: no speed, no dual graph of its making.
struct Recount {
    std::vector<int> triangle_counts;
    int max_triangle_count_difference = 0;
    int boundary_edge_count = 0;
    int bowtie_count = 0;
    int disconnected_submesh_count = 0;
    int empty_submesh_count = 0;
    int disk_count = 0;

    /// All sub-meshes have a face, are connected and free of bowties.
    bool is_whole() const {
        return bowtie_count == 0 && disconnected_submesh_count == 0 && empty_submesh_count == 0;
    }
};

/// A mesh as pairs of faces that share an edge.
class Surface {
public:
    explicit Surface(const TriangleMesh& mesh);

    /// Faces joined by shared edges: size of each component.
    const std::vector<int>& component_sizes() const { return component_sizes_; }
    /// Finite, of triangles with three different vertices, at most two on an edge.
    bool is_manifold() const { return is_manifold_; }

    Recount recount(const std::vector<int>& labels, int submesh_count) const;

    /// The least MTCD of connected sub-meshes, were every component as easy to cut as a chain;
    /// -1 when there are more components than sub-meshes.
    int least_count_difference(int submesh_count) const;

    /// Whether connected sub-meshes without bowties of this MTCD exist at all, by trying all
    /// labellings: for a dozen faces.
    bool can_be_cut(int submesh_count, int count_difference) const;

private:
    struct SharedEdge {
        int faces[2];
        int vertices[2];
    };
    void join_sides();
    void count_components();
    void examine();
    int count_fans(const std::vector<int>& labels, int label, int* vertex_count) const;
    int count_pieces(const std::vector<int>& labels, int label) const;
    bool is_disk(const std::vector<int>& labels, int label) const;
    bool place(std::vector<int>& labels,
               std::vector<int>& counts,
               int face,
               int used,
               int count_difference) const;

    const TriangleMesh& mesh_;
    std::vector<SharedEdge> shared_;
    std::vector<int> component_sizes_;
    bool has_unjoined_pair_ = false;
    bool is_manifold_ = false;
};

} // namespace spheroseg::fuzz
