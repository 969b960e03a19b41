# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pymeshlab
import pytest
from host_meshes import MEASURES, state
from shapes import octahedron

# Faces 0 to 3 of the octahedron lie around the upper pole, 4 to 7 around the lower one; each of
# them shares one edge with the face below or above it.


def labelled(labels):
    vertices, faces = octahedron()
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(
        pymeshlab.Mesh(vertices, faces, f_scalar_array=np.asarray(labels, dtype=float))
    )
    return mesh_set


def test_upper_and_lower_half():
    mesh_set = labelled([0, 0, 0, 0, 1, 1, 1, 1])
    before = state(mesh_set)
    result = mesh_set.apply_filter(MEASURES)
    triangles = result.pop("submesh_triangles")
    np.testing.assert_array_equal(triangles, [4.0, 4.0])
    assert result == {
        "boundary_edge_count": 4,
        "max_triangle_count_difference": 0,
        "coefficient_of_variation": 0.0,
        "bowtie_count": 0,
        "disconnected_submesh_count": 0,
        "disk_count": 2,
        "boundary_edge_ratio": 4 / 12,
    }
    assert state(mesh_set) == before


def test_two_opposite_faces_at_the_pole_make_a_bowtie_and_leave_a_gap_in_the_labels():
    # Label 3 has the opposite upper faces 0 and 2, which meet only at the pole; labels 1 and 2 are
    # empty. Label 0 has the rest: four lower faces and two upper ones.
    result = labelled([3, 0, 3, 0, 0, 0, 0, 0]).apply_filter(MEASURES)
    np.testing.assert_array_equal(result["submesh_triangles"], [6.0, 0.0, 0.0, 2.0])
    assert result["boundary_edge_count"] == 6
    assert result["max_triangle_count_difference"] == 6
    # At the pole both labels have two fans each.
    assert result["bowtie_count"] == 2


@pytest.mark.parametrize("value", [0.5, -1.0, np.nan, np.inf, 1e8])
def test_rejects_a_quality_that_is_no_label(value):
    mesh_set = labelled([0, 0, 0, value, 1, 1, 1, 1])
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException, match="face 3 has"):
        mesh_set.apply_filter(MEASURES)
    assert state(mesh_set) == before


def test_rejects_a_mesh_without_face_quality():
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(*octahedron()))
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"(?i)face quality"):
        mesh_set.apply_filter(MEASURES)


def test_an_open_border_is_no_boundary():
    vertices, faces = octahedron()
    mesh_set = pymeshlab.MeshSet()
    labels = np.array([0, 0, 0, 0, 1, 1, 1], dtype=float)
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces[:7], f_scalar_array=labels))
    result = mesh_set.apply_filter(MEASURES)
    assert result["boundary_edge_count"] == 3
    assert result["boundary_edge_ratio"] == 3 / 12


def test_an_edge_of_three_faces_joins_none_and_is_no_boundary():
    fins = [[0, 1, 2], [1, 0, 3], [0, 1, 4]]
    mesh_set = pymeshlab.MeshSet()
    labels = np.array([0, 0, 1], dtype=float)
    mesh_set.add_mesh(pymeshlab.Mesh(np.eye(5, 3), fins, f_scalar_array=labels))
    result = mesh_set.apply_filter(MEASURES)
    assert result["boundary_edge_count"] == 0
    assert result["disconnected_submesh_count"] == 1
