// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "measures.h"
#include "options.h"
#include "parametrization.h"
#include "validity.h"

#include <optional>

namespace spheroseg {

class Component;

struct Segmentation {
    /// One label in [0, k) per face.
    std::vector<int> labels;
    /// Of `labels`.
    Measures measures;
    /// `all_pairs`: the measures between cohesion and refinement.
    Measures measures_after_cohesion;
    /// Edge-connected components of the mesh.
    int component_count = 0;
    /// The least MTCD that the sizes of the components allow (1 or 0 when there is one).
    int best_max_triangle_count_difference = 0;
    /// False where that is at most 1, and no cut into connected sub-meshes has it, as parts of the
    /// mesh hang on the rest by single edges (least_misplaced). Not found out for `all_pairs`, by
    /// weight, or where a balance was found.
    bool may_be_balanced = true;
    Balance balance = Balance::triangle_count;
    /// Heaviest sub-mesh over the mean; by triangle counts unless the balance is by weight.
    double weight_imbalance = 1.0;
    int cohesion_iterations = 0;
    int refinement_iterations = 0;
    /// What does not depend on k: for `fast` components and levels, and the map where one is used.
    double parametrization_seconds = 0.0;
    /// For `fast` the starts with their trials.
    double cohesion_seconds = 0.0;
    double refinement_seconds = 0.0;
    /// Checks and measures too.
    double total_seconds = 0.0;
    bool time_limit_hit = false;
    bool used_cuda = false;
    /// One entry per iteration: cohesion, then refinement. The last one is that of the result. Of
    /// several components, as if each did its n-th iteration at the same time.
    std::vector<double> boundary_edges_by_iteration;
    std::vector<double> seconds_by_iteration;
    /// `all_pairs`: sum of chord distances in cohesion, of Eq. 1 in refinement; `fast`: boundary
    /// edges.
    std::vector<double> energy_by_iteration;

    /// Nothing empty, all connected, no bowtie; unless balanced by weight, triangle counts as equal
    /// as the components allow.
    bool is_valid() const {
        return measures.is_valid(balance == Balance::weight ? measures.triangle_count
                                                            : best_max_triangle_count_difference);
    }
};

/// A mesh with all that does not depend on k, so that a second segmentation costs less: dual graph
/// and report, and, built on first use and kept, components and parametrization.
class PreparedMesh {
public:
    /// Examines the mesh. Throws InvalidInput when it is too large (check_size) or a vertex index
    /// is out of range, OutOfMemory.
    explicit PreparedMesh(TriangleMesh mesh, int thread_count = 0);
    ~PreparedMesh();
    // Its components refer to it.
    PreparedMesh(const PreparedMesh&) = delete;
    PreparedMesh& operator=(const PreparedMesh&) = delete;

    const TriangleMesh& mesh() const { return mesh_; }
    const DualGraph& dual_graph() const { return dual_graph_; }
    const MeshReport& report() const { return report_; }
    /// The map to the sphere. Throws InvalidInput unless the mesh is closed and of genus 0
    /// (closed_genus_zero_error), OutOfMemory, Cancelled.
    const Parametrization& parametrization(int thread_count = 0, const Progress& progress = {});
    /// Uses a map made before, one position per vertex; returns false and changes nothing when it
    /// is not valid, or when the mesh can not be mapped.
    bool set_parametrization(std::vector<Vec3> sphere_positions);
    /// Its edge-connected components (component.h), made on first use and kept.
    std::vector<Component>& components();

private:
    TriangleMesh mesh_;
    DualGraph dual_graph_;
    MeshReport report_;
    std::vector<Component> components_;
    std::optional<Parametrization> parametrization_;
};

/// Measures of labels of a prepared mesh, as `measure` of measures.h, but faster where the mesh is
/// known to be manifold.
Measures measure(const PreparedMesh& mesh,
                 const std::vector<int>& labels,
                 int submesh_count,
                 int thread_count);

/// k that `options` ask for on a mesh of `face_count` faces: by initial labels, else by
/// `triangles_per_submesh`, else by `submesh_count`, else 200 or fewer. Not checked: may be below 1
/// or above `face_count`.
int requested_submesh_count(const SegmentOptions& options, int face_count);

/// Cuts the mesh into k sub-meshes. `fast` takes any mesh whose edges have one or two faces each,
/// with as many sub-meshes as components or more; `all_pairs` one closed, consistently oriented,
/// manifold component of genus 0.
/// `fast`: each is one edge-connected piece without bowties, inside one component; triangle counts
/// differ as little as the sizes of the components allow (`share_submeshes`), by one at most when
/// there is one component. If that could not be reached, the measures say so. Depends on
/// connectivity, options and seed, never on threads; on coordinates only where areas are the
/// weights, and on a map that was set (`set_parametrization`) with Effort::high only.
/// With `Balance::weight`, the heaviest sub-mesh is as near to the mean as could be reached
/// instead; with `initial_labels` that are valid already, there are no more boundary edges than
/// before (where the balance is by weight: none more, or a better balance), and labels keep their
/// numbers as far as possible, compacted in increasing order. `all_pairs`: the paper word for word:
/// triangle counts differ by at most one; pieces and bowties may remain. Throws InvalidInput,
/// InvalidOptions, Cancelled, OutOfMemory, and DeviceError where there is no usable device although
/// `cuda` is asked for; the prepared mesh stays usable after any of them.
Segmentation
segment(PreparedMesh& mesh, const SegmentOptions& options, const Progress& progress = {});

} // namespace spheroseg
