// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "segment.h"

#include <QVariant>

#include <map>
#include <string>

namespace spheroseg {

/// What a filter returns to its caller: int, double, bool and Eigen::VectorXd only, because
/// PyMeshLab drops everything else.
using Results = std::map<std::string, QVariant>;

Results segmentation_results(const Segmentation& segmentation);
Results measure_results(const Measures& measures);
Results parametrization_results(const ParametrizationQuality& quality, double seconds);

/// As in "1 sub-mesh" and "2 sub-meshes"; `plural`: what is added to `one`.
std::string counted(int count, const std::string& one, const char* plural);

/// One line for MeshLab's log.
std::string summary(const Segmentation& segmentation);
std::string summary(const Measures& measures);

/// What the labels fall short of (balance, connectedness, no bowtie); empty when of nothing.
std::string shortcomings(const Segmentation& segmentation);

} // namespace spheroseg
