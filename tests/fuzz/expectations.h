// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fuzz_case.h"

#include <string>
#include <vector>

namespace spheroseg::fuzz {

/// When the options can not be met: a part of what the error must say, which names the first face
/// where it is about faces. Empty when they are good for this mesh.
std::string expected_refusal(const FuzzCase& one);

/// Number of sub-meshes that the options ask for, where they are accepted.
int expected_submesh_count(const FuzzCase& one);

/// Weights that the balance goes by, worked out anew; ones when it goes by triangle counts.
std::vector<long double> expected_weights(const FuzzCase& one);

/// The areas are so small beside the coordinates that they are nothing but rounding.
bool has_vague_weights(const FuzzCase& one);

/// Heaviest load over the mean.
double recount_imbalance(const std::vector<long double>& weights,
                         const std::vector<int>& labels,
                         int submesh_count);

} // namespace spheroseg::fuzz
