// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "component.h"

namespace spheroseg {

/// The initial labels of one component, numbered from 0 on.
struct ComponentLabels {
    /// Per face of the component a number in [0, its number of sub-meshes), or -1 where the face's
    /// label belongs to another component. Not all numbers need occur.
    std::vector<int> labels;
    /// For each number the label of the whole mesh that it stands for.
    std::vector<int> names;
};

/// Distributes the labels of the whole mesh (0 to k - 1, none missing) over its components, of
/// which component i gets submesh_counts[i] of them, k in all. A label belongs to the component
/// where it has the most faces (of equals, the first). A component with too many labels gives up
/// those with the fewest faces; one with too few gets labels that others gave up. O(F log F).
std::vector<ComponentLabels> share_labels(const std::vector<Component>& components,
                                          const std::vector<int>& submesh_counts,
                                          const std::vector<int>& labels);

} // namespace spheroseg
