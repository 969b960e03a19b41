// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "collapse_mesh.h"

namespace spheroseg {

/// Recognises a connected mesh that comes from a coarser one by 1-to-4 subdivision: every edge got
/// a new vertex, and every old triangle became three *corners* and the *middle* between them. Entry
/// v of the result holds the ends of the old edge that vertex v lies on, {-1, -1} for a vertex of
/// the coarser mesh. Empty for any other mesh. `live_faces` and `live_vertices` are the faces and
/// vertices of the mesh that are left, increasing. Positions are not used. O(F), but most other
/// meshes are rejected after a few faces.
/// Source: Taubin, Detecting and Reconstructing Subdivision Connectivity, The Visual Computer 18,
/// 2002.
std::vector<std::array<int, 2>> find_subdivision(const CollapseMesh& mesh,
                                                 const std::vector<int>& live_faces,
                                                 const std::vector<int>& live_vertices);

} // namespace spheroseg
