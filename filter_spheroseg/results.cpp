// SPDX-License-Identifier: GPL-3.0-or-later
#include "results.h"

// Declares Eigen::VectorXd to QVariant.
#include <common/plugins/interfaces/filter_plugin.h>

#include <algorithm>
#include <sstream>
#include <string>

namespace spheroseg {

namespace {

template <typename T> QVariant to_vector(const std::vector<T>& values) {
    Eigen::VectorXd vector(static_cast<Eigen::Index>(values.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
        vector[static_cast<Eigen::Index>(i)] = static_cast<double>(values[i]);
    }
    return QVariant::fromValue(vector);
}

Results quality_results(const Measures& measures) {
    return {{"boundary_edge_count", measures.boundary_edge_count},
            {"max_triangle_count_difference", measures.max_triangle_count_difference},
            {"coefficient_of_variation", measures.coefficient_of_variation},
            {"bowtie_count", measures.bowtie_count},
            {"disconnected_submesh_count", measures.disconnected_submesh_count},
            {"disk_count", measures.disk_count},
            {"boundary_edge_ratio", measures.boundary_edge_ratio}};
}

} // namespace

std::string counted(int count, const std::string& one, const char* plural) {
    return std::to_string(count) + " " + one + (count == 1 ? "" : plural);
}

Results segmentation_results(const Segmentation& segmentation) {
    const Measures& measures = segmentation.measures;
    Results results = quality_results(measures);
    results["submesh_count"] = measures.submesh_count;
    results["triangle_count"] = measures.triangle_count;
    results["min_submesh_triangles"] = measures.min_submesh_triangles;
    results["max_submesh_triangles"] = measures.max_submesh_triangles;
    results["component_count"] = segmentation.component_count;
    results["best_max_triangle_count_difference"] = segmentation.best_max_triangle_count_difference;
    results["may_be_balanced"] = segmentation.may_be_balanced;
    results["weight_imbalance"] = segmentation.weight_imbalance;
    results["cohesion_iterations"] = segmentation.cohesion_iterations;
    results["refinement_iterations"] = segmentation.refinement_iterations;
    results["parametrization_seconds"] = segmentation.parametrization_seconds;
    results["cohesion_seconds"] = segmentation.cohesion_seconds;
    results["refinement_seconds"] = segmentation.refinement_seconds;
    results["total_seconds"] = segmentation.total_seconds;
    results["time_limit_hit"] = segmentation.time_limit_hit;
    results["used_cuda"] = segmentation.used_cuda;
    results["boundary_edges_by_iteration"] = to_vector(segmentation.boundary_edges_by_iteration);
    results["seconds_by_iteration"] = to_vector(segmentation.seconds_by_iteration);
    results["energy_by_iteration"] = to_vector(segmentation.energy_by_iteration);
    return results;
}

Results measure_results(const Measures& measures) {
    Results results = quality_results(measures);
    results["submesh_triangles"] = to_vector(measures.submesh_triangles);
    return results;
}

Results parametrization_results(const ParametrizationQuality& quality, double seconds) {
    return {{"flipped_triangle_count", quality.flipped_triangle_count},
            {"min_triangle_area", quality.min_triangle_area},
            {"area_distortion_mean", quality.area_distortion_mean},
            {"area_distortion_max", quality.area_distortion_max},
            {"seconds", seconds}};
}

std::string summary(const Measures& measures) {
    std::ostringstream text;
    text << counted(measures.triangle_count, "triangle", "s") << " in "
         << counted(measures.submesh_count, "sub-mesh", "es") << " of "
         << measures.min_submesh_triangles << " to " << measures.max_submesh_triangles << "; "
         << counted(measures.boundary_edge_count, "boundary edge", "s") << ", "
         << counted(measures.bowtie_count, "bowtie", "s") << ", "
         << counted(measures.disconnected_submesh_count, "disconnected sub-mesh", "es");
    return text.str();
}

std::string summary(const Segmentation& segmentation) {
    std::ostringstream text;
    text.precision(3);
    text << summary(segmentation.measures) << "; " << segmentation.cohesion_iterations
         << " cohesion and "
         << counted(segmentation.refinement_iterations, "refinement iteration", "s") << ", "
         << segmentation.total_seconds << " s";
    if (segmentation.component_count > 1) {
        text << "; " << segmentation.component_count << " components, which allow a difference of "
             << counted(segmentation.best_max_triangle_count_difference, "triangle", "s")
             << " at best";
    }
    if (segmentation.balance == Balance::weight) {
        text << "; heaviest sub-mesh " << segmentation.weight_imbalance << " times the mean";
    }
    if (segmentation.time_limit_hit) {
        text << " (time limit hit)";
    }
    return text.str();
}

std::string shortcomings(const Segmentation& segmentation) {
    const Measures& measures = segmentation.measures;
    std::ostringstream text;
    const char* separator = "";
    const auto add = [&](bool present, const std::string& what) {
        if (present) {
            text << separator << what;
            separator = ", ";
        }
    };
    const int difference = measures.max_triangle_count_difference;
    const int best = segmentation.best_max_triangle_count_difference;
    add(segmentation.balance == Balance::triangle_count && difference > 1,
        std::to_string(difference) + " triangles between the largest and the smallest sub-mesh" +
            (difference > best ? "" : ", the fewest that its components allow") +
            (segmentation.may_be_balanced
                 ? ""
                 : " (no cut into so many connected ones is balanced, as parts of the mesh hang on "
                   "the rest by single edges)"));
    add(measures.disconnected_submesh_count > 0,
        counted(measures.disconnected_submesh_count, "sub-mesh", "es") + " in more than one piece");
    add(measures.bowtie_count > 0, counted(measures.bowtie_count, "bowtie", "s"));
    return text.str();
}

} // namespace spheroseg
