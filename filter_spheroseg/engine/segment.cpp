// SPDX-License-Identifier: GPL-3.0-or-later
#include "segment.h"

#include "all_pairs_segmentation.h"
#include "component.h"
#include "component_segmentation.h"
#include "device_groups.h"
#include "face_weights.h"
#include "warm_start.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace spheroseg {

namespace {

constexpr int kDefaultSubmeshCount = 200;
/// Meshes too small for the default get about so many faces per sub-mesh.
constexpr int kFacesPerDefaultSubmesh = 10;

void refuse_negative(double value, const char* name) {
    if (!(value >= 0.0)) {
        throw InvalidOptions(std::string(name) + " must be 0 or more, found " + to_text(value) +
                             ". Use 0 for the default.");
    }
}

/// Where `fast` anneals; null: on the cores, unless a device is asked for, since the one measured
/// was slower everywhere (docs/gpu.md).
std::unique_ptr<AnnealDevice> anneal_device(const SegmentOptions& options) {
    return options.device == Device::cuda
        ? std::make_unique<cuda::DeviceAnnealing>(cuda::open_device())
        : nullptr;
}

} // namespace

PreparedMesh::PreparedMesh(TriangleMesh mesh, int thread_count) try
    : mesh_(std::move(mesh)), dual_graph_(build_dual_graph(mesh_, thread_count)),
      report_(inspect(mesh_, dual_graph_, thread_count)) {
} catch (const std::bad_alloc&) {
    throw OutOfMemory();
}

PreparedMesh::~PreparedMesh() = default;

std::vector<Component>& PreparedMesh::components() {
    if (!components_.empty()) {
        return components_;
    }
    if (report_.component_count == 1 && report_.inconsistent_edge_count == 0) {
        components_.emplace_back(mesh_, dual_graph_);
        return components_;
    }
    std::vector<std::vector<int>> faces = faces_of_components(dual_graph_);
    std::vector<int> local_index(mesh_.face_count());
    for (const std::vector<int>& component : faces) {
        for (std::size_t i = 0; i < component.size(); ++i) {
            local_index[component[i]] = static_cast<int>(i);
        }
    }
    std::vector<Component> components;
    components.reserve(faces.size());
    for (std::vector<int>& component : faces) {
        components.emplace_back(mesh_, dual_graph_, std::move(component), local_index);
    }
    components_ = std::move(components);
    return components_;
}

const Parametrization& PreparedMesh::parametrization(int thread_count,
                                                     const Progress& progress) try {
    const std::string defect = closed_genus_zero_error(report_);
    if (!defect.empty()) {
        throw InvalidInput(defect);
    }
    if (!parametrization_) {
        const CollapseHierarchy& collapsed =
            components().front().hierarchy(thread_count, sub_progress(progress, 0.0, 0.4));
        parametrization_ =
            parametrize(mesh_, collapsed, thread_count, sub_progress(progress, 0.4, 1.0));
    }
    return *parametrization_;
} catch (const std::bad_alloc&) {
    throw OutOfMemory();
}

bool PreparedMesh::set_parametrization(std::vector<Vec3> sphere_positions) {
    if (!report_.is_closed_genus_zero() || !is_valid_parametrization(mesh_, sphere_positions)) {
        return false;
    }
    parametrization_ = Parametrization{std::move(sphere_positions)};
    return true;
}

Measures measure(const PreparedMesh& mesh,
                 const std::vector<int>& labels,
                 int submesh_count,
                 int thread_count) {
    return measure(mesh.mesh(),
                   mesh.dual_graph(),
                   labels,
                   submesh_count,
                   thread_count,
                   mesh.report().fans_per_vertex());
}

int requested_submesh_count(const SegmentOptions& options, int face_count) {
    if (!options.initial_labels.empty()) {
        return distinct_label_count(options.initial_labels);
    }
    if (options.triangles_per_submesh > 0) {
        return face_count / options.triangles_per_submesh +
            (face_count % options.triangles_per_submesh != 0);
    }
    if (options.submesh_count != 0) {
        return options.submesh_count;
    }
    const int small_mesh_count =
        (face_count + kFacesPerDefaultSubmesh - 1) / kFacesPerDefaultSubmesh;
    return std::clamp(small_mesh_count, 1, kDefaultSubmeshCount);
}

namespace {

void check_weights(const SegmentOptions& options, const TriangleMesh& mesh) {
    if (options.balance == Balance::triangle_count) {
        if (!options.face_weights.empty()) {
            throw InvalidOptions(
                "No face weights are expected with balance \"triangle_count\", but "
                "there are " +
                std::to_string(options.face_weights.size()) + ". Use balance \"weight\".");
        }
        return;
    }
    if (options.method != Method::fast) {
        throw InvalidOptions("Expected method \"fast\" with balance \"weight\", found "
                             "\"all_pairs\", which balances triangle counts only.");
    }
    check_face_weights(options, mesh);
}

void check_initial_labels(const SegmentOptions& options, int face_count) {
    const std::vector<int>& labels = options.initial_labels;
    if (labels.empty()) {
        return;
    }
    if (options.method != Method::fast) {
        throw InvalidOptions("Expected method \"fast\" with initial labels, found \"all_pairs\", "
                             "which starts from random labels.");
    }
    if (labels.size() != static_cast<std::size_t>(face_count)) {
        throw InvalidOptions("One initial label per face is expected (" +
                             std::to_string(face_count) + "), but there are " +
                             std::to_string(labels.size()) + ".");
    }
    const auto negative =
        std::find_if(labels.begin(), labels.end(), [](int label) { return label < 0; });
    if (negative != labels.end()) {
        throw InvalidOptions("Initial labels must be 0 or more, but face " +
                             std::to_string(negative - labels.begin()) + " has " +
                             std::to_string(*negative) + ". Correct the labels.");
    }
}

/// The only place that checks.
void validate(const SegmentOptions& options, const PreparedMesh& mesh) {
    const std::string defect = options.method == Method::fast
        ? surface_error(mesh.report())
        : closed_genus_zero_error(mesh.report());
    if (!defect.empty()) {
        throw InvalidInput(defect);
    }
    refuse_negative(options.triangles_per_submesh, "triangles_per_submesh");
    refuse_negative(options.thread_count, "thread_count");
    refuse_negative(options.max_cohesion_iterations, "max_cohesion_iterations");
    refuse_negative(options.max_refinement_iterations, "max_refinement_iterations");
    refuse_negative(options.time_limit_seconds, "time_limit_seconds");
    const int face_count = mesh.mesh().face_count();
    check_weights(options, mesh.mesh());
    check_initial_labels(options, face_count);
    const int submesh_count = requested_submesh_count(options, face_count);
    if (submesh_count < 1 || submesh_count > face_count) {
        throw InvalidOptions("submesh_count must lie in [1, " + std::to_string(face_count) +
                             "] (faces of the mesh), found " + std::to_string(submesh_count) +
                             ". Ask for fewer sub-meshes, or set triangles_per_submesh.");
    }
    if (options.method == Method::fast && submesh_count < mesh.report().component_count) {
        throw InvalidInput(too_many_components_error(mesh.report(), submesh_count));
    }
    if (options.device == Device::cuda) {
        cuda::open_device();
    }
}

} // namespace

Segmentation
segment(PreparedMesh& mesh, const SegmentOptions& options, const Progress& progress) try {
    const Deadline deadline(options.time_limit_seconds);
    validate(options, mesh);
    // More starts than expected, or a device that failed, must not let it fall back.
    const Progress rising = rising_progress(progress);
    report_progress(rising, 0.0, "Parametrization");
    const int submesh_count = requested_submesh_count(options, mesh.mesh().face_count());
    Segmentation result = options.method == Method::fast
        ? segment_fast(mesh, options, deadline, rising, anneal_device(options).get())
        : segment_all_pairs(mesh, options, deadline, rising);
    result.component_count = mesh.report().component_count;
    result.measures = measure(mesh, result.labels, submesh_count, options.thread_count);
    if (options.method == Method::fast && !result.boundary_edges_by_iteration.empty()) {
        // With what was done to balance it, or of the initial labels where these stay.
        result.boundary_edges_by_iteration.back() = result.measures.boundary_edge_count;
        result.energy_by_iteration.back() = result.measures.boundary_edge_count;
    }
    result.balance = options.balance;
    result.weight_imbalance = options.balance == Balance::weight
        ? weight_imbalance(weights_of(options, mesh.mesh()), result.labels, submesh_count)
        : static_cast<double>(result.measures.max_submesh_triangles) * submesh_count /
            mesh.mesh().face_count();
    result.total_seconds = deadline.elapsed_seconds();
    report_progress(rising, 1.0, "Done");
    return result;
} catch (const std::bad_alloc&) {
    throw OutOfMemory();
}

} // namespace spheroseg
