// SPDX-License-Identifier: GPL-3.0-or-later
#include "parameters.h"

namespace spheroseg {

namespace {

// In the order of the enums in options.h.
const QStringList kMethods = {"fast", "all_pairs"};
const QStringList kEfforts = {"draft", "standard", "high"};
const QStringList kDevices = {"auto", "cpu", "cuda"};
const QStringList kBalances = {"triangle_count", "weight"};
const QStringList kInitialLabels = {"none", "face_quality"};

/// The number of the word that is chosen. MeshLab takes any number from a filter script.
int choice(const RichParameterList& parameters, const QString& name, const QStringList& words) {
    const int number = parameters.getEnum(name);
    if (number < 0 || number >= words.size()) {
        throw InvalidOptions(name.toStdString() + " must be one of " +
                             words.join(", ").toStdString() + " (0 to " +
                             std::to_string(words.size() - 1) + "), found " +
                             std::to_string(number) + ". Correct the filter script.");
    }
    return number;
}

/// As of a large mesh where there is none yet.
int default_submesh_count(int face_count) {
    constexpr int kLargeMesh = 1 << 20;
    return requested_submesh_count(SegmentOptions(), face_count > 0 ? face_count : kLargeMesh);
}

// MeshLab shows these when asked to, so that the dialog fits the screen of a laptop.
constexpr bool kAdvanced = true;

void add_balance_and_start(RichParameterList& parameters, const SegmentOptions& defaults) {
    parameters.addParam(RichEnum("balance",
                                 static_cast<int>(defaults.balance),
                                 kBalances,
                                 "Balance",
                                 "'triangle_count': triangle counts differ by at most one, those "
                                 "of several components as little as their sizes allow. "
                                 "'weight': the heaviest sub-mesh is as near to the mean weight as "
                                 "can be reached; method 'fast' only.",
                                 kAdvanced));
    parameters.addParam(RichString("weight_attribute",
                                   "",
                                   "Weight attribute",
                                   "With the balance 'weight': name of a per-face custom scalar "
                                   "attribute with the weight of each face (0 or more). Empty: the "
                                   "areas of the triangles.",
                                   kAdvanced));
    parameters.addParam(RichEnum("initial_labels",
                                 0,
                                 kInitialLabels,
                                 "Start from labels",
                                 "'face_quality': repair, balance and refine the labels now in the "
                                 "face quality; the number of sub-meshes is that of the different "
                                 "labels, and the parameters for it are ignored. Method 'fast' "
                                 "only.",
                                 kAdvanced));
}

void add_device_and_limits(RichParameterList& parameters, const SegmentOptions& defaults) {
    parameters.addParam(RichEnum("device",
                                 static_cast<int>(defaults.device),
                                 kDevices,
                                 "Device",
                                 "'auto': the faster one that works, for 'fast' the cores. 'cuda' "
                                 "without a usable device is an error that says why. The labels "
                                 "are the same.",
                                 kAdvanced));
    parameters.addParam(RichInt("thread_count",
                                defaults.thread_count,
                                "Threads",
                                "Number of threads. 0: all cores.",
                                kAdvanced));
    parameters.addParam(
        RichInt("max_cohesion_iterations",
                defaults.max_cohesion_iterations,
                "Limit of cohesion iterations",
                "Stop the cohesion after so many iterations; where this ends it early, "
                "the method fast tries one layout only, where it would try several. 0: until "
                "converged.",
                kAdvanced));
    parameters.addParam(RichInt("max_refinement_iterations",
                                defaults.max_refinement_iterations,
                                "Limit of refinement iterations",
                                "Stop the refinement after so many iterations; where this ends it "
                                "early, the method fast tries one layout only, where it would try "
                                "several. 0: until converged.",
                                kAdvanced));
    parameters.addParam(RichFloat("time_limit_seconds",
                                  Scalarm(defaults.time_limit_seconds),
                                  "Time limit (seconds)",
                                  "Stop improving after this time, such as 0.5 (with a point). "
                                  "The result is still balanced and, by 'fast', valid; on large "
                                  "meshes that may take some seconds more. time_limit_hit says "
                                  "that it was cut short. 0: no limit.",
                                  kAdvanced));
}

} // namespace

RichParameterList segmentation_parameters(int face_count) {
    const SegmentOptions defaults;
    RichParameterList parameters;
    parameters.addParam(RichInt("submesh_count",
                                default_submesh_count(face_count),
                                "Sub-meshes",
                                "Number of sub-meshes, from 1 to the number of triangles."));
    parameters.addParam(RichInt("triangles_per_submesh",
                                defaults.triangles_per_submesh,
                                "Triangles per sub-mesh",
                                "If above 0, the number of sub-meshes is the number of triangles "
                                "over this value, rounded up, and 'Sub-meshes' is ignored."));
    parameters.addParam(RichEnum("method",
                                 static_cast<int>(defaults.method),
                                 kMethods,
                                 "Method",
                                 "'fast': for everyday use. 'all_pairs': the published method, "
                                 "which tests all pairs of triangles; its time grows with the "
                                 "square of the number of triangles."));
    parameters.addParam(RichEnum("effort",
                                 static_cast<int>(defaults.effort),
                                 kEfforts,
                                 "Effort",
                                 "How long 'fast' refines the boundaries. Every effort gives the "
                                 "same guarantees."));
    parameters.addParam(RichInt("seed",
                                static_cast<int>(defaults.seed),
                                "Seed",
                                "Same seed, same labels: on every run, for any number of "
                                "threads, unless a time limit was hit."));
    parameters.addParam(RichBool("colorize",
                                 true,
                                 "Colour the faces",
                                 "Give neighbouring sub-meshes clearly different face colours."));
    add_balance_and_start(parameters, defaults);
    add_device_and_limits(parameters, defaults);
    return parameters;
}

SegmentOptions segment_options(const RichParameterList& parameters) {
    SegmentOptions options;
    options.submesh_count = parameters.getInt("submesh_count");
    options.triangles_per_submesh = parameters.getInt("triangles_per_submesh");
    // The engine reads 0 as "choose"; here the default is written out, so 0 is a mistake.
    if (options.triangles_per_submesh == 0 && options.submesh_count < 1 &&
        !starts_from_face_quality(parameters)) {
        throw InvalidOptions("submesh_count must be at least 1, found " +
                             std::to_string(options.submesh_count) +
                             ". Ask for between 1 and as many sub-meshes as triangles.");
    }
    options.balance = static_cast<Balance>(choice(parameters, "balance", kBalances));
    options.method = static_cast<Method>(choice(parameters, "method", kMethods));
    options.effort = static_cast<Effort>(choice(parameters, "effort", kEfforts));
    options.device = static_cast<Device>(choice(parameters, "device", kDevices));
    options.seed = static_cast<std::uint64_t>(parameters.getInt("seed"));
    options.thread_count = parameters.getInt("thread_count");
    options.max_cohesion_iterations = parameters.getInt("max_cohesion_iterations");
    options.max_refinement_iterations = parameters.getInt("max_refinement_iterations");
    options.time_limit_seconds = static_cast<double>(parameters.getFloat("time_limit_seconds"));
    return options;
}

bool starts_from_face_quality(const RichParameterList& parameters) {
    const int number = choice(parameters, "initial_labels", kInitialLabels);
    return kInitialLabels.at(number) == "face_quality";
}

RichParameterList parametrization_parameters() {
    RichParameterList parameters;
    parameters.addParam(RichBool("new_layer",
                                 false,
                                 "New layer with the sphere",
                                 "Also make a layer whose vertices lie at their places on the unit "
                                 "sphere. The current layer stays current."));
    return parameters;
}

} // namespace spheroseg
