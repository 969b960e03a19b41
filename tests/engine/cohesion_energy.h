// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cohesion_state.h"

namespace spheroseg::test {

/// Sum over the faces of the chord distance between a face's centroid and that of its sub-mesh,
/// which is the mean of the centroids of its faces, projected onto the sphere. In the arithmetic
/// of `cohere_all_pairs` (distances in single precision, their sum in double).
inline double cohesion_energy(const std::vector<Vec3>& face_centroids,
                              const std::vector<int>& labels,
                              int submesh_count) {
    ChordSwapState state = make_cohesion_state(face_centroids, labels);
    assign_centroids(state, submesh_centroids(state, submesh_count));
    return energy_of(state);
}

} // namespace spheroseg::test
