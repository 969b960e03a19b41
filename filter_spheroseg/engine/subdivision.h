// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "collapse_mesh.h"

namespace spheroseg {

/// The vertices that a subdivision has put on edges, where a mesh came from one by splitting each
/// triangle in four: those are joined by new edges, so each old triangle became three *corners* and
/// the *middle* between them. Entry v holds the ends of the edge that vertex v lies on, {-1, -1}
/// where it is of the old mesh. Empty for all other meshes, which most often shows after
/// looking at a few faces; else O(F). Positions are not used. After Taubin, "Detecting and
/// Reconstructing Subdivision Connectivity", The Visual Computer 18, 2002. `live_faces` and
/// `live_vertices` are what there is of the mesh, increasing. A mesh that is not connected is none.
std::vector<std::array<int, 2>> find_subdivision(const CollapseMesh& mesh,
                                                 const std::vector<int>& live_faces,
                                                 const std::vector<int>& live_vertices);

} // namespace spheroseg
