// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "component.h"

namespace spheroseg {

/// Which of the labels that a user gave a component starts from.
struct ComponentLabels {
    /// One number in [0, the component's number of sub-meshes) per face of it, or -1 where the
    /// face's label belongs to another component; a number may be missing.
    std::vector<int> labels;
    /// The label of the whole mesh that each number stands for.
    std::vector<int> names;
};

/// Shares the labels of the whole mesh (0 to k - 1, none missing) out to its components of
/// `submesh_counts` sub-meshes each, k in all. A label belongs to the component where it has the
/// most faces (of equals, the first). A component with too many labels gives up those with the
/// fewest faces, one with too few gets labels that others gave up. O(F log F).
std::vector<ComponentLabels> share_labels(const std::vector<Component>& components,
                                          const std::vector<int>& submesh_counts,
                                          const std::vector<int>& labels);

} // namespace spheroseg
