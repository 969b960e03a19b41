// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh_adapter.h"
#include "progress.h"

#include <common/ml_document/mesh_document.h>

namespace spheroseg {

/// Per-vertex and per-face scalar attributes of a sub-mesh's layer: the indices in the source
/// mesh, counted without its deleted elements. A single precision host holds them exactly up to
/// 2^24.
inline constexpr const char* kSourceVertex = "source_vertex";
inline constexpr const char* kSourceFace = "source_face";

/// Name of a layer that is `part` of `source`: behind the label of that without the suffix of a
/// mesh file, because MeshLab's list of layers shows a label only up to its first dot.
QString layer_name(const MeshModel& source, const QString& part);

/// Gives the images of the source's textures to a layer that has their names already: MeshLab can
/// not save a layer without them.
void copy_texture_images(const MeshModel& source, MeshModel& layer);

/// Adds a layer for each label that has faces, in the order of the labels: its faces and their
/// vertices with all attributes, the textures and the transformation of `source`, normals
/// included. `labels` has one entry per face of `host`, which was read from `source`. `source`
/// stays the current mesh and is not changed. Returns the number of layers. When memory runs out
/// or it is cancelled the layers made so far are removed again. O(F log F + V). Throws InvalidInput
/// when a face uses a deleted vertex, Cancelled when the progress callback asks for it.
int generate_submesh_layers(MeshDocument& document,
                            const MeshModel& source,
                            const HostMesh& host,
                            const std::vector<int>& labels,
                            const Progress& progress);

} // namespace spheroseg
