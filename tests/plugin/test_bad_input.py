# SPDX-License-Identifier: GPL-3.0-or-later
"""Every bad input gives its documented error and leaves the mesh as it was."""

import numpy as np
import pymeshlab
import pytest
from host_meshes import (
    PARAMETRIZATION,
    SEGMENTATION,
    document,
    ellipsoid,
    labels_of,
    state,
    torus,
    two_octahedra,
)
from shapes import octahedron, subdivided_sphere

VERTICES, FACES = octahedron()
SPHERE_VERTICES, SPHERE_FACES = subdivided_sphere(2)


def changed_row(array, row, value):
    array = array.copy()
    array[row] = value
    return array


BAD_MESHES = {
    "an edge with three faces": (
        np.vstack([VERTICES, [[2.0, 2.0, 2.0]]]),
        np.vstack([FACES, [[0, 2, 6]]]),
        "more than two faces",
    ),
    "a face with a vertex twice": (
        VERTICES,
        np.vstack([FACES, [[0, 0, 2]]]),
        "vertex twice",
    ),
    "a duplicate face": (VERTICES, np.vstack([FACES, FACES[:1]]), "same vertices"),
    "a NaN coordinate": (changed_row(VERTICES, 1, np.nan), FACES, "NaN"),
    "an infinite coordinate": (changed_row(VERTICES, 1, np.inf), FACES, "infinite"),
}

# Surfaces that can be cut, but not be mapped to the sphere.
NOT_SPHERES = {
    "one face": (VERTICES, FACES[:1], "open border"),
    "open boundary": (VERTICES, FACES[1:], "3 open border edges"),
    "genus one": (*torus(), "genus 1"),
    "several components": (*two_octahedra(shared_vertex=False), "2 components"),
    "touching in a vertex": (*two_octahedra(shared_vertex=True), "separate fans"),
    "a face the wrong way round": (
        VERTICES,
        changed_row(FACES, 0, FACES[0, ::-1]),
        "opposite orientation",
    ),
}


@pytest.mark.parametrize("name", [SEGMENTATION, PARAMETRIZATION])
@pytest.mark.parametrize(("vertices", "faces", "message"), BAD_MESHES.values(), ids=BAD_MESHES)
def test_rejects_faces_that_make_no_surface(name, vertices, faces, message):
    mesh_set = document(vertices, faces)
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        mesh_set.apply_filter(name)
    assert state(mesh_set) == before


@pytest.mark.parametrize(("vertices", "faces", "message"), NOT_SPHERES.values(), ids=NOT_SPHERES)
def test_only_fast_takes_a_surface_that_is_no_sphere(vertices, faces, message):
    mesh_set = document(vertices, faces)
    before = state(mesh_set)
    for name, options in ((PARAMETRIZATION, {}), (SEGMENTATION, {"method": "all_pairs"})):
        with pytest.raises(pymeshlab.PyMeshLabException, match=f"{message}.*fast.* takes"):
            mesh_set.apply_filter(name, **options)
        assert state(mesh_set) == before
    count = min(4, len(faces))
    report = mesh_set.apply_filter(SEGMENTATION, submesh_count=count)
    assert report["max_triangle_count_difference"] <= 1
    assert report["disconnected_submesh_count"] == 0
    assert report["bowtie_count"] == 0


@pytest.mark.parametrize("name", [SEGMENTATION, PARAMETRIZATION])
def test_rejects_a_mesh_without_faces(name):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(VERTICES))
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"(?i)faces"):
        mesh_set.apply_filter(name)
    assert mesh_set.current_mesh().vertex_number() == 6


@pytest.mark.parametrize("name", [SEGMENTATION, PARAMETRIZATION])
def test_rejects_an_empty_document(name):
    with pytest.raises(pymeshlab.PyMeshLabException):
        pymeshlab.MeshSet().apply_filter(name)


BAD_OPTIONS = {
    "no sub-mesh": ({"submesh_count": 0}, "submesh_count"),
    "negative count": ({"submesh_count": -3}, "-3"),
    "more sub-meshes than faces": ({"submesh_count": 129}, "129"),
    "more sub-meshes than labels": ({"submesh_count": 1 << 25}, r"must lie in \[1, 128\]"),
    "negative triangles": ({"triangles_per_submesh": -1}, "triangles_per_submesh"),
    "negative threads": ({"thread_count": -1}, "thread_count"),
    "negative cohesion limit": ({"max_cohesion_iterations": -1}, "max_cohesion_iterations"),
    "negative refinement limit": ({"max_refinement_iterations": -1}, "max_refinement_iterations"),
    "negative time": ({"time_limit_seconds": -1.0}, "time_limit_seconds"),
}


@pytest.mark.parametrize(("options", "message"), BAD_OPTIONS.values(), ids=BAD_OPTIONS)
def test_rejects_bad_options(options, message):
    mesh_set = ellipsoid(2)
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        mesh_set.apply_filter(SEGMENTATION, **options)
    assert state(mesh_set) == before


def test_an_error_keeps_the_labels_of_an_earlier_run():
    mesh_set = ellipsoid(2)
    mesh_set.apply_filter(SEGMENTATION, submesh_count=5)
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException):
        mesh_set.apply_filter(SEGMENTATION, submesh_count=10_000)
    assert state(mesh_set) == before


def test_a_call_after_an_error_works():
    broken = document(VERTICES, np.vstack([FACES, FACES[:1]]))
    good, fresh = ellipsoid(2), ellipsoid(2)
    fresh.apply_filter(SEGMENTATION, submesh_count=6)
    for bad in (lambda: broken.apply_filter(SEGMENTATION), lambda: broken.apply_filter("none")):
        with pytest.raises(pymeshlab.PyMeshLabException):
            bad()
    good.apply_filter(SEGMENTATION, submesh_count=6)
    np.testing.assert_array_equal(labels_of(good), labels_of(fresh))


def test_accepts_unreferenced_vertices():
    mesh_set = document(np.vstack([[[9.0, 9.0, 9.0]], VERTICES]), FACES + 1)
    mesh_set.apply_filter(SEGMENTATION, submesh_count=4)
    assert np.bincount(labels_of(mesh_set)).tolist() == [2, 2, 2, 2]
    mesh_set.apply_filter(PARAMETRIZATION)
    positions = mesh_set.current_mesh().vertex_custom_point_attribute_matrix("sphere_position")
    np.testing.assert_array_equal(positions[0], [0.0, 0.0, 1.0])


def test_accepts_zero_area_faces():
    vertices = SPHERE_VERTICES.copy()
    # A vertex on top of a neighbour: the faces along that edge have no area.
    vertices[SPHERE_FACES[0, 0]] = vertices[SPHERE_FACES[0, 1]]
    mesh_set = document(vertices, SPHERE_FACES)
    result = mesh_set.apply_filter(SEGMENTATION, submesh_count=16)
    assert result["max_triangle_count_difference"] == 0


def test_as_many_submeshes_as_faces():
    mesh_set = document(VERTICES, FACES)
    mesh_set.apply_filter(SEGMENTATION, submesh_count=8)
    assert sorted(labels_of(mesh_set)) == list(range(8))


def test_cuda_without_a_device_says_why():
    mesh_set = ellipsoid(2)
    before = state(mesh_set)
    try:
        result = mesh_set.apply_filter(SEGMENTATION, submesh_count=4, device="cuda")
    except pymeshlab.PyMeshLabException as error:
        assert "cuda" in str(error).lower()  # noqa: PT017 (a machine may have a device)
        assert state(mesh_set) == before
    else:
        assert result["used_cuda"]
