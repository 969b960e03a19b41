// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "multilevel.h"

#include <memory>
#include <optional>

namespace spheroseg {

/// One edge-connected component of a mesh, with what a segmentation of it needs for any k. Its
/// faces are oriented alike as far as it is orientable.
class Component {
public:
    /// The component with the faces `faces` (indices into `mesh`, increasing). O(its size) with
    /// `local_index`, which has an entry for every face of the mesh: the index of the face among
    /// those of its component.
    Component(const TriangleMesh& mesh,
              const DualGraph& dual_graph,
              std::vector<int> faces,
              const std::vector<int>& local_index);

    /// A whole mesh that is one component, oriented alike already; `hierarchy` must outlive this.
    Component(int face_count, const CollapseHierarchy& hierarchy);

    int face_count() const { return face_count_; }
    /// The face of the whole mesh that face `f` of the component is.
    int mesh_face(int f) const { return faces_.empty() ? f : faces_[f]; }

    /// Its coarse versions; built on first use.
    const Multilevel& multilevel(int thread_count, const Progress& progress);

private:
    int face_count_;
    std::vector<int> faces_;
    TriangleMesh mesh_;
    DualGraph dual_graph_;
    std::unique_ptr<CollapseHierarchy> hierarchy_; // its address must last for multilevel_
    std::optional<Multilevel> multilevel_;
};

/// The faces of each edge-connected component, in increasing order; components in the order of
/// their first faces. O(F).
std::vector<std::vector<int>> faces_of_components(const DualGraph& dual_graph);

/// Turns faces so that neighbours run along their edges in opposite directions, where the
/// surface is orientable; elsewhere some edges keep faces that do not. The first face of each
/// component stays. Sides of a turned face change places in the dual graph too. O(F).
void orient_alike(TriangleMesh& mesh, DualGraph& dual_graph);

} // namespace spheroseg
