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

/// A mesh as pairs of faces that share an edge which has no third face.
class Surface {
public:
    explicit Surface(const TriangleMesh& mesh);

    struct SharedEdge {
        int faces[2];
        int vertices[2];
    };

    int face_count() const { return static_cast<int>(corners_.size()); }
    const std::vector<SharedEdge>& shared_edges() const { return shared_; }
    /// Faces joined by shared edges: size of each component.
    const std::vector<int>& component_sizes() const { return component_sizes_; }
    /// The vertices of a face. A vertex where the mesh is pinched counts as one for each fan.
    const std::array<int, 3>& corners(int face) const { return corners_[face]; }

    /// At least one face, each with three different vertices and finite coordinates, and at most
    /// two on an edge.
    bool is_clean() const { return is_clean_; }
    /// Clean, one component, closed, no two faces alike, consistently oriented, not pinched, V - E
    /// + F = 2.
    bool is_sphere() const { return is_sphere_; }

    Recount recount(const std::vector<int>& labels, int submesh_count) const;

    /// The least MTCD of connected sub-meshes, were every component as easy to cut as a chain;
    /// -1 when there are more components than sub-meshes.
    int least_count_difference(int submesh_count) const;

    /// Vertices of these faces that lie in more than one fan of them, once for each further fan.
    int count_bowties(const std::vector<int>& faces) const;

private:
    void join_sides();
    void count_components();
    void split_pinches();
    void examine();
    int count_pieces(const std::vector<int>& labels, int label) const;
    bool is_disk(const std::vector<int>& faces) const;

    const TriangleMesh& mesh_;
    std::vector<SharedEdge> shared_;
    std::vector<std::vector<int>> shared_of_face_;
    std::vector<std::array<int, 3>> corners_;
    std::vector<int> component_sizes_;
    int edge_count_ = 0;
    bool is_closed_ = true;
    bool is_oriented_ = true;
    bool is_pinched_ = false;
    bool is_clean_ = true;
    bool is_sphere_ = true;
};

} // namespace spheroseg::fuzz
