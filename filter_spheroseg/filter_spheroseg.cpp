// SPDX-License-Identifier: GPL-3.0-or-later
#include "filter_spheroseg.h"

#include "coloring.h"
#include "generate_layers.h"
#include "help.h"
#include "interrupt.h"
#include "mesh_adapter.h"
#include "new_layers.h"
#include "parameters.h"

#include <algorithm>

using namespace spheroseg;

// The Python package searches the library file for this text (install.py), to say what a plugin
// that can not be loaded was built for.
extern "C" [[gnu::used]] Q_DECL_EXPORT const char spheroseg_host[] =
    "SpheroSeg built for MeshLab " meshlab_xstr(MESHLAB_VERSION) " (" meshlab_xstr(
        MESHLAB_SCALAR) ")";

namespace {

Progress to_progress(vcg::CallBackPos* callback, const InterruptWatch& watch) {
    return [callback, &watch](double fraction, const char* step) {
        return !watch.interrupted() &&
            (!callback || callback(static_cast<int>(100.0 * fraction), step));
    };
}

/// MeshLab handles its user's input while progress is reported. So a filter may be called while
/// another one runs, which is refused, and the mesh may be gone or changed when it has finished.
class ExclusiveRun {
public:
    explicit ExclusiveRun(std::atomic<bool>& running) : running_(running) {
        if (running_.exchange(true)) {
            throw MLException("A SpheroSeg filter is already running. Wait until it has ended.");
        }
    }
    ~ExclusiveRun() { running_ = false; }
    ExclusiveRun(const ExclusiveRun&) = delete;
    ExclusiveRun& operator=(const ExclusiveRun&) = delete;

private:
    std::atomic<bool>& running_;
};

/// As read_labels; throws InvalidInput for a mesh without faces, too.
std::vector<int> read_labels_of_faces(const CMeshO& mesh, const HostMesh& host) {
    std::vector<int> labels = read_labels(mesh, host);
    if (labels.empty()) {
        throw InvalidInput("At least one face is expected, but the mesh has none. Open a triangle "
                           "mesh first.");
    }
    return labels;
}

/// The model that was read when the filter began. Throws InvalidInput when it is gone or changed.
MeshModel& still_the_same(MeshDocument& document,
                          int mesh_id,
                          const HostMesh& host,
                          const PreparedMesh& prepared) {
    MeshModel* model = document.getMesh(mesh_id);
    if (!model || !has_same_elements(model->cm, host, prepared.mesh().faces)) {
        throw InvalidInput("The mesh was removed or changed while the filter ran. Nothing was "
                           "written; apply the filter again.");
    }
    return *model;
}

void add_sphere_layer(NewLayers& layers, MeshModel& model, const std::vector<Vec3>& positions) {
    // Not addNewMesh(mesh, ...): it would also switch on the unset vertex colours, and MeshLab
    // would show these instead of the face colours.
    MeshModel& layer = layers.add(layer_name(model, "(sphere)"));
    layer.cm = model.cm;
    layer.updateDataMask(&model);
    copy_texture_images(model, layer);
    // Copying leaves deleted elements out: the copy has indices of its own.
    const HostMesh copied = read_mesh(layer.cm);
    write_sphere_positions(layer.cm, copied, positions);
    move_vertices(layer.cm, copied, positions);
}

} // namespace

FilterSpheroSegPlugin::FilterSpheroSegPlugin() {
    typeList = {SEGMENTATION, PARAMETRIZATION, MEASURES, LAYERS};
    for (ActionIDType filter : types()) {
        actionList.push_back(new QAction(filterName(filter), this));
    }
}

QString FilterSpheroSegPlugin::pluginName() const {
    return "FilterSpheroSeg";
}

QString FilterSpheroSegPlugin::vendor() const {
    return "SpheroSeg";
}

QString FilterSpheroSegPlugin::filterName(ActionIDType filter) const {
    switch (filter) {
    case SEGMENTATION:
        return "Balanced Segmentation (SpheroSeg)";
    case PARAMETRIZATION:
        return "Spherical Parametrization (SpheroSeg)";
    case MEASURES:
        return "Segmentation Measures (SpheroSeg)";
    case LAYERS:
        return "Split into Sub-mesh Layers (SpheroSeg)";
    }
    return {};
}

QString FilterSpheroSegPlugin::pythonFilterName(ActionIDType filter) const {
    switch (filter) {
    case SEGMENTATION:
        return "compute_scalar_by_balanced_segmentation_per_face";
    case PARAMETRIZATION:
        return "compute_spherical_parametrization_per_vertex";
    case MEASURES:
        return "get_segmentation_measures";
    case LAYERS:
        return "generate_submesh_layers";
    }
    return {};
}

QString FilterSpheroSegPlugin::filterInfo(ActionIDType filter) const {
    switch (filter) {
    case SEGMENTATION:
        return kSegmentationHelp;
    case PARAMETRIZATION:
        return kParametrizationHelp;
    case MEASURES:
        return kMeasuresHelp;
    case LAYERS:
        return kLayersHelp;
    }
    return {};
}

FilterPlugin::FilterClass FilterSpheroSegPlugin::getClass(const QAction* action) const {
    return ID(action) == LAYERS ? FilterPlugin::Layer : FilterPlugin::Quality;
}

FilterPlugin::FilterArity FilterSpheroSegPlugin::filterArity(const QAction*) const {
    return FilterPlugin::SINGLE_MESH;
}

int FilterSpheroSegPlugin::getPreConditions(const QAction* action) const {
    const bool needs_labels = ID(action) == MEASURES || ID(action) == LAYERS;
    return needs_labels ? MeshModel::MM_FACENUMBER | MeshModel::MM_FACEQUALITY
                        : MeshModel::MM_FACENUMBER;
}

int FilterSpheroSegPlugin::postCondition(const QAction* action) const {
    return ID(action) == SEGMENTATION ? MeshModel::MM_FACEQUALITY | MeshModel::MM_FACECOLOR
                                      : MeshModel::MM_NONE;
}

RichParameterList FilterSpheroSegPlugin::initParameterList(const QAction* action,
                                                           const MeshDocument& document) {
    switch (ID(action)) {
    case SEGMENTATION:
        return segmentation_parameters(document.mm() ? document.mm()->cm.fn : 0);
    case PARAMETRIZATION:
        return parametrization_parameters();
    }
    return {};
}

std::map<std::string, QVariant>
FilterSpheroSegPlugin::applyFilter(const QAction* action,
                                   const RichParameterList& parameters,
                                   MeshDocument& document,
                                   unsigned int& post_condition_mask,
                                   vcg::CallBackPos* callback) {
    const ExclusiveRun exclusive(running_);
    const InterruptWatch watch;
    const Progress progress = to_progress(callback, watch);
    try {
        if (!document.mm()) {
            throw InvalidInput("A mesh is expected, but the document has none. Open one first.");
        }
        switch (ID(action)) {
        case SEGMENTATION:
            return segment(document, parameters, post_condition_mask, progress);
        case PARAMETRIZATION:
            return parametrize(document, parameters, progress);
        case MEASURES:
            return measure(*document.mm());
        case LAYERS:
            // Without the host's callback: events are not to be handled while half of the layers
            // are there.
            return generate_layers(document, to_progress(nullptr, watch));
        }
    } catch (const MLException&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw MLException(OutOfMemory().what());
    } catch (const std::exception& error) {
        throw MLException(error.what());
    }
    wrongActionCalled(action);
    return {};
}

Results FilterSpheroSegPlugin::segment(MeshDocument& document,
                                       const RichParameterList& parameters,
                                       unsigned int& post_condition_mask,
                                       const Progress& progress) {
    SegmentOptions options = segment_options(parameters);
    const bool colorize = parameters.getBool("colorize");
    const int mesh_id = document.mm()->id();
    HostMesh host = read_mesh(document.mm()->cm);
    if (starts_from_face_quality(parameters)) {
        options.initial_labels = read_labels(document.mm()->cm, host);
    } else {
        // More sub-meshes than faces are the engine's to refuse: it names the number of faces.
        const int face_count = host.mesh.face_count();
        check_label_range(std::min(requested_submesh_count(options, face_count), face_count));
    }
    const std::string weight_attribute = parameters.getString("weight_attribute").toStdString();
    if (!weight_attribute.empty()) {
        options.face_weights = read_face_attribute(document.mm()->cm, host, weight_attribute);
    }
    auto sphere_positions = read_sphere_positions(document.mm()->cm, host);
    const bool has_positions = sphere_positions.has_value();
    PreparedMesh& prepared =
        cache_.prepare(std::move(host.mesh), std::move(sphere_positions), options.thread_count);
    if (has_positions && !cache_.uses_given_positions()) {
        log(GLLogStream::WARNING,
            "The attribute sphere_position does not fit this mesh any more; it is ignored.");
    }

    const Segmentation segmentation = spheroseg::segment(prepared, options, progress);
    std::vector<Rgb> colors;
    if (colorize) {
        colors = submesh_colors(prepared.mesh(),
                                prepared.dual_graph(),
                                segmentation.labels,
                                segmentation.measures.submesh_count);
    }

    MeshModel& model = still_the_same(document, mesh_id, host, prepared);
    const int written =
        MeshModel::MM_FACEQUALITY | (colorize ? MeshModel::MM_FACECOLOR : MeshModel::MM_NONE);
    model.updateDataMask(written); // before anything is written, as it takes memory
    write_labels(model.cm, host, segmentation.labels);
    if (colorize) {
        write_face_colors(model.cm, host, segmentation.labels, colors);
    }
    post_condition_mask = written;
    log(GLLogStream::FILTER, summary(segmentation));
    const std::string missing = shortcomings(segmentation);
    if (!missing.empty()) {
        log(GLLogStream::WARNING, "The result has " + missing + ".");
    }
    memory_return_.count(host.face_index.size());
    return segmentation_results(segmentation);
}

Results FilterSpheroSegPlugin::parametrize(MeshDocument& document,
                                           const RichParameterList& parameters,
                                           const Progress& progress) {
    const StopWatch watch;
    const int mesh_id = document.mm()->id();
    HostMesh host = read_mesh(document.mm()->cm);
    PreparedMesh& prepared = cache_.prepare(std::move(host.mesh), std::nullopt, 0);
    // Measured as the host stores them: single precision may flip a tiny triangle.
    const std::vector<Vec3> positions =
        rounded_to_host(prepared.parametrization(0, progress).positions);
    const ParametrizationQuality quality = measure_parametrization(prepared.mesh(), positions);

    MeshModel& model = still_the_same(document, mesh_id, host, prepared);
    NewLayers layers(document);
    if (parameters.getBool("new_layer")) {
        add_sphere_layer(layers, model, positions);
    }
    write_sphere_positions(model.cm, host, positions);
    layers.keep();
    const double seconds = watch.elapsed_seconds();
    log("%i vertices on the sphere; %i flipped triangles, mean area distortion %.3g; %.3g s",
        static_cast<int>(positions.size()),
        quality.flipped_triangle_count,
        quality.area_distortion_mean,
        seconds);
    return parametrization_results(quality, seconds);
}

Results FilterSpheroSegPlugin::measure(const MeshModel& model) {
    const HostMesh host = read_mesh(model.cm);
    const std::vector<int> labels = read_labels_of_faces(model.cm, host);
    const int submesh_count = *std::max_element(labels.begin(), labels.end()) + 1;
    const DualGraph dual_graph = build_dual_graph(host.mesh);
    const Measures measures = spheroseg::measure(host.mesh, dual_graph, labels, submesh_count, 0);
    log(GLLogStream::FILTER, summary(measures));
    return measure_results(measures);
}

Results FilterSpheroSegPlugin::generate_layers(MeshDocument& document, const Progress& progress) {
    const MeshModel& source = *document.mm();
    const HostMesh host = read_mesh(source.cm);
    const std::vector<int> labels = read_labels_of_faces(source.cm, host);
    const int layer_count = generate_submesh_layers(document, source, host, labels, progress);
    log("%s made, one for each sub-mesh", counted(layer_count, "layer", "s").c_str());
    return {{"layer_count", layer_count}};
}

MESHLAB_PLUGIN_NAME_EXPORTER(FilterSpheroSegPlugin)
