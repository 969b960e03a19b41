// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "multilevel.h"

#include <memory>
#include <optional>

namespace spheroseg {

/// One edge-connected component of a mesh, with the levels that serve its segmentation for any k.
/// Its faces are oriented alike as far as it is orientable.
class Component {
public:
    /// The component with the faces `faces` (indices into `mesh`, increasing). O(n log n) for n
    /// faces with `local_index`, which has an entry for every face of the mesh: the index of the
    /// face among those of its component.
    Component(const TriangleMesh& mesh,
              const DualGraph& dual_graph,
              std::vector<int> faces,
              const std::vector<int>& local_index);

    /// A whole mesh that is one component, oriented alike already. Both must outlive this.
    Component(const TriangleMesh& mesh, const DualGraph& dual_graph);

    int face_count() const { return mesh_->face_count(); }
    /// The face of the whole mesh that face `f` of the component is.
    int mesh_face(int f) const { return faces_.empty() ? f : faces_[f]; }

    /// Built on first use and kept: the collapse hierarchy, all levels, and the finest level alone,
    /// which needs no hierarchy. `multilevel` uses the hierarchy if it is there; else it builds one
    /// and drops it, since it takes 30 bytes per face.
    const CollapseHierarchy& hierarchy(int thread_count, const Progress& progress);
    const Multilevel& multilevel(int thread_count, const Progress& progress);
    const Multilevel& finest_level(int thread_count);

private:
    struct Surface {
        TriangleMesh mesh;
        DualGraph dual_graph;
    };

    std::vector<int> faces_;
    std::unique_ptr<Surface> own_;
    const TriangleMesh* mesh_;
    const DualGraph* dual_graph_;
    std::optional<CollapseHierarchy> hierarchy_;
    std::optional<Multilevel> multilevel_;
    std::optional<Multilevel> finest_level_;
};

/// The faces of each edge-connected component, in increasing order; components in the order of
/// their first faces. O(F).
std::vector<std::vector<int>> faces_of_components(const DualGraph& dual_graph);

/// Turns faces so that neighbours run along their edges in opposite directions, where the
/// surface is orientable; elsewhere some edges keep faces that do not. The first face of each
/// component stays. Sides of a turned face change places in the dual graph too. O(F).
void orient_alike(TriangleMesh& mesh, DualGraph& dual_graph);

} // namespace spheroseg
