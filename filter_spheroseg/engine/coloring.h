// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dual_graph.h"

namespace spheroseg {

using Rgb = std::array<std::uint8_t, 3>;

/// Eight colours, any two of which are more than 20 apart in CIELAB (Euclidean distance), as seen
/// by people with normal sight, protanopia, deuteranopia and tritanopia.
extern const std::array<Rgb, 8> kPalette;

/// A colour index for each sub-mesh, different for any two sub-meshes that share an edge; two that
/// share only a vertex differ too where the palette has a colour left. Where the sub-meshes of a
/// mesh of genus 0 are connected, their graph is planar and the palette suffices; on other surfaces
/// they may need colours beyond it. Does not depend on threads.
/// `labels`: one per face, each in [0, submesh_count). O(F + b log b) for b corners at boundaries
/// of sub-meshes.
std::vector<int> color_submeshes(const TriangleMesh& mesh,
                                 const DualGraph& dual_graph,
                                 const std::vector<int>& labels,
                                 int submesh_count);

/// The colour of an index: the palette, then lighter and darker variants of it.
Rgb palette_color(int color_index);

/// One colour per sub-mesh.
std::vector<Rgb> submesh_colors(const TriangleMesh& mesh,
                                const DualGraph& dual_graph,
                                const std::vector<int>& labels,
                                int submesh_count);

} // namespace spheroseg
