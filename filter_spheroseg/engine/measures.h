// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

namespace spheroseg {

/// Measures of a labelling; definitions in the manual (docs/measures.md).
struct Measures {
    int submesh_count = 0;
    int triangle_count = 0;
    int min_submesh_triangles = 0;
    int max_submesh_triangles = 0;
    int boundary_edge_count = 0;
    int max_triangle_count_difference = 0;
    double coefficient_of_variation = 0.0;
    int bowtie_count = 0;
    int disconnected_submesh_count = 0;
    int disk_count = 0;
    double boundary_edge_ratio = 0.0;
    /// Triangles of each sub-mesh; submesh_count entries.
    std::vector<int> submesh_triangles;

    /// Triangle counts differ by at most so many, nothing empty, all connected, no bowtie.
    bool is_valid(int largest_difference = 1) const {
        return max_triangle_count_difference <= largest_difference && min_submesh_triangles >= 1 &&
            disconnected_submesh_count == 0 && bowtie_count == 0;
    }
};

/// Measures `labels` (one per face, each in [0, submesh_count)) in O(F + k), on up to two threads
/// (thread_count 0: as many as there are cores). Edges and neighbours are those of the dual graph;
/// an empty sub-mesh is neither disconnected nor a disk. Throws InvalidInput when the sizes differ
/// or a label is out of range.
Measures measure(const TriangleMesh& mesh,
                 const DualGraph& dual_graph,
                 const std::vector<int>& labels,
                 int submesh_count,
                 int thread_count,
                 VertexFanCount fans_per_vertex = VertexFanCount::unknown);

/// `boundary_edge_count` alone.
int count_boundary_edges(const DualGraph& dual_graph, const std::vector<int>& labels);

} // namespace spheroseg
