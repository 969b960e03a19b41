# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes as PyMeshLab documents, and what the tests ask about them."""

import numpy as np
import pymeshlab
import pytest
from shapes import octahedron, subdivided_sphere

import spheroseg
from spheroseg import install

SEGMENTATION = "compute_scalar_by_balanced_segmentation_per_face"
PARAMETRIZATION = "compute_spherical_parametrization_per_vertex"
MEASURES = "get_segmentation_measures"


def document(vertices, faces):
    """A MeshSet with one mesh."""
    mesh_set = pymeshlab.MeshSet()
    faces = np.asarray(faces, np.int32).reshape(-1, 3)
    mesh_set.add_mesh(pymeshlab.Mesh(np.asarray(vertices, float), faces))
    return mesh_set


def ellipsoid(levels=3):
    """8 * 4**levels triangles, stretched."""
    vertices, faces = subdivided_sphere(levels)
    return document(vertices * [1.0, 1.5, 2.0], faces)


def labels_of(mesh_set):
    return mesh_set.current_mesh().face_scalar_array().astype(int)


def edge_pairs(faces):
    """(E, 2) pairs of faces that share an edge; each edge must have two faces."""
    edges = np.sort(np.asarray(faces)[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    order = np.lexsort(edges.T)
    assert (edges[order[0::2]] == edges[order[1::2]]).all()
    return np.stack([order[0::2] // 3, order[1::2] // 3], axis=1)


def mesh_count(mesh_set):
    # PyMeshLab 2022.2 has the older name.
    return (getattr(mesh_set, "mesh_number", None) or mesh_set.number_meshes)()


def require_attributes_from_python():
    if install.plugin_host(spheroseg.plugin_path()).release == "2022.02":
        pytest.skip("PyMeshLab 2022.2 corrupts its memory when Python adds an attribute")


def state(mesh_set):
    """All that a filter could change in the current mesh."""
    mesh = mesh_set.current_mesh()
    return {
        "mesh_count": mesh_count(mesh_set),
        "vertices": mesh.vertex_matrix().tobytes(),
        "faces": mesh.face_matrix().tobytes(),
        "quality": mesh.face_scalar_array().tobytes() if mesh.has_face_scalar() else None,
        "colors": mesh.face_color_matrix().tobytes() if mesh.has_face_color() else None,
        "attributes": _point_attributes(mesh),
    }


def _point_attributes(mesh):
    try:
        return mesh.vertex_custom_point_attribute_matrix("sphere_position").tobytes()
    except pymeshlab.PyMeshLabException:
        return None


def torus():
    columns, rows = 12, 8
    around, tube = np.meshgrid(
        np.arange(columns) * 2 * np.pi / columns, np.arange(rows) * 2 * np.pi / rows
    )
    radius = 2.0 + np.cos(tube)
    vertices = np.stack([radius * np.cos(around), radius * np.sin(around), np.sin(tube)], axis=-1)
    index = np.arange(columns * rows).reshape(rows, columns)
    right, up = np.roll(index, -1, axis=1), np.roll(index, -1, axis=0)
    diagonal = np.roll(right, -1, axis=0)
    faces = np.concatenate(
        [np.stack([index, right, diagonal], axis=-1), np.stack([index, diagonal, up], axis=-1)]
    )
    return vertices.reshape(-1, 3), faces.reshape(-1, 3)


def two_octahedra(shared_vertex):
    """Two solids beside each other, or touching in one vertex."""
    vertices, faces = octahedron()
    other = faces + len(vertices)
    if shared_vertex:
        # Vertex 1 of the second, at (-1, 0, 0), becomes vertex 0 of the first, at (1, 0, 0).
        other = np.where(other == len(vertices) + 1, 0, other)
    offset = 2.0 if shared_vertex else 5.0
    return np.vstack([vertices, vertices + [offset, 0, 0]]), np.vstack([faces, other])
