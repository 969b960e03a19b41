// SPDX-License-Identifier: GPL-3.0-or-later
#include "help.h"

#define SPHEROSEG_CITATION                                                                         \
    "<small><b>See</b> Huadong Zhang, Lizhou Cao, Chao Peng: <i>Spherical Parametric Measurement " \
    "for Continuous and Balanced Mesh Segmentation</i>, High-Performance Graphics, 2023.</small>"

namespace spheroseg {

const char* const kSegmentationHelp =
    "Cuts a surface into sub-meshes of equal triangle counts (of several components, as equal as "
    "their sizes allow), each in one piece and without bowties (<i>fast</i>), with short "
    "boundaries. Say how many sub-meshes there shall be, or how many triangles each shall have; "
    "the other parameters can stay as they are. Those below the arrow balance by weight instead, "
    "or repair existing labels.<br>"
    "<b>Needs</b> a triangle mesh with finite coordinates whose edges have one or two faces each; "
    "holes, handles, any orientation and up to as many components as sub-meshes are fine. "
    "<i>all_pairs</i> needs one closed, consistently oriented component of genus 0. Otherwise the "
    "filter fails, says what is wrong, and changes nothing.<br>"
    "<b>Writes</b> the label of each face, a whole number from 0 to the number of sub-meshes "
    "minus 1, as face quality, and face colours by which neighbouring sub-meshes can be told "
    "apart; measures are in the log.<br>"
    "<small><b>Returns</b> to PyMeshLab <i>submesh_count</i>, <i>triangle_count</i>, "
    "<i>min_submesh_triangles</i>, <i>max_submesh_triangles</i>, the measures of "
    "<i>get_segmentation_measures</i> but <i>submesh_triangles</i>, <i>component_count</i>, "
    "<i>best_max_triangle_count_difference</i>, <i>may_be_balanced</i>, <i>weight_imbalance</i>, "
    "<i>time_limit_hit</i>, <i>used_cuda</i>; <i>cohesion_iterations</i>, "
    "<i>refinement_iterations</i>, and of each "
    "<i>boundary_edges_by_iteration</i>, <i>seconds_by_iteration</i>, <i>energy_by_iteration</i>; "
    "<i>parametrization_seconds</i>, <i>cohesion_seconds</i>, <i>refinement_seconds</i>, "
    "<i>total_seconds</i>.</small><br>" SPHEROSEG_CITATION;

// MeshLab cuts off what makes the dialog higher than two thirds of the screen.
const char* const kParametrizationHelp =
    "Maps a mesh onto the unit sphere without flipped triangles: collapsed to a tetrahedron, it "
    "gets its vertices back, each where the shape of the triangles around it suffers least.<br>"
    "<b>Needs</b> a closed, consistently oriented, manifold triangle mesh of one connected "
    "component and genus 0 (a ball or an animal, not a ring) with finite coordinates. For any "
    "other mesh the filter fails, says what is wrong, and changes nothing.<br>"
    "<b>Writes</b> the place of each vertex as per-vertex custom point attribute "
    "<i>sphere_position</i>; an unreferenced vertex gets (0, 0, 1). Balanced Segmentation takes "
    "it where it needs a map: <i>all_pairs</i>, and <i>fast</i> with effort <i>high</i> on many "
    "triangles. With <i>new_layer</i> a copy of the mesh with its vertices at these places is "
    "added.<br>"
    "<small><b>Returns</b> to PyMeshLab <i>flipped_triangle_count</i>, <i>min_triangle_area</i> "
    "(on the sphere), <i>area_distortion_mean</i> and <i>area_distortion_max</i> (share of the "
    "sphere over share of the mesh, or its inverse if that is larger, per triangle), "
    "<i>seconds</i>. In single precision a few tiny triangles of a large mesh may count as "
    "flipped; a segmentation then makes its own map.</small><br>" SPHEROSEG_CITATION
    // MeshLab's dialog of so few parameters is too low for its help by half a line.
    "<br>&nbsp;";

const char* const kMeasuresHelp =
    "Measures the sub-meshes that are given by the labels in face quality, whoever wrote "
    "them.<br>"
    "<b>Needs</b> face quality with whole numbers from 0 to 16777215; anything else is an error. "
    "The mesh may be open and of any genus; an edge on an open border is no boundary edge.<br>"
    "<b>Writes</b> nothing.<br>"
    "<b>Returns</b> <i>boundary_edge_count</i> (edges between two sub-meshes), "
    "<i>max_triangle_count_difference</i> (largest minus smallest triangle count), "
    "<i>coefficient_of_variation</i> (of the triangle counts), <i>bowtie_count</i> (vertices "
    "where a sub-mesh touches itself), <i>disconnected_submesh_count</i>, <i>disk_count</i> "
    "(sub-meshes that are topological disks), <i>boundary_edge_ratio</i> (boundary edges over all "
    "edges), and <i>submesh_triangles</i> (triangle count of each label from 0 to the "
    "largest).<br>" SPHEROSEG_CITATION;

const char* const kLayersHelp =
    "Makes a new layer for each sub-mesh that is given by the labels in face quality, whoever "
    "wrote them; a label without faces gets none.<br>"
    "<b>Needs</b> face quality with whole numbers from 0 to 16777215; anything else is an error. "
    "The mesh may be open and of any genus.<br>"
    "<b>Writes</b> layers in the order of the labels, each with all attributes of its vertices and "
    "faces, the per-vertex custom attribute <i>source_vertex</i> and the per-face custom attribute "
    "<i>source_face</i>: the indices in the source mesh, counted without deleted elements. The "
    "source mesh stays current and is not changed.<br>"
    "<b>Returns</b> <i>layer_count</i>.<br>" SPHEROSEG_CITATION;

} // namespace spheroseg
