# SPDX-License-Identifier: GPL-3.0-or-later
"""Balance by weight, and labels in the face quality as a start."""

import numpy as np
import pymeshlab
import pytest
from host_meshes import (
    SEGMENTATION,
    document,
    ellipsoid,
    labels_of,
    require_attributes_from_python,
    state,
)
from recount import areas, weight_imbalance
from shapes import subdivided_sphere


def imbalance_of(mesh_set, weights):
    return weight_imbalance(labels_of(mesh_set), weights)


def with_labels(labels, levels=3):
    vertices, faces = subdivided_sphere(levels)
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(
        pymeshlab.Mesh(vertices, faces.astype(np.int32), f_scalar_array=np.asarray(labels, float))
    )
    return mesh_set


def refused(mesh_set, **parameters):
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException) as error:
        mesh_set.apply_filter(SEGMENTATION, **parameters)
    assert state(mesh_set) == before
    return str(error.value)


def test_areas_are_balanced_when_no_attribute_is_named():
    mesh_set = ellipsoid(4)
    result = mesh_set.apply_filter(SEGMENTATION, submesh_count=20, balance="weight")
    mesh = mesh_set.current_mesh()
    weights = areas(mesh.vertex_matrix(), mesh.face_matrix())
    assert result["weight_imbalance"] == pytest.approx(imbalance_of(mesh_set, weights))
    assert result["weight_imbalance"] <= 1.02
    assert result["bowtie_count"] == 0
    assert result["disconnected_submesh_count"] == 0


def test_counts_are_the_weights_by_default():
    mesh_set = ellipsoid()
    result = mesh_set.apply_filter(SEGMENTATION, submesh_count=7)
    assert result["weight_imbalance"] == pytest.approx(imbalance_of(mesh_set, np.ones(512)))


def test_an_attribute_is_balanced_and_kept():
    require_attributes_from_python()
    mesh_set = ellipsoid(4)
    weights = np.random.default_rng(1).integers(1, 11, 2048).astype(float)
    mesh_set.current_mesh().add_face_custom_scalar_attribute(weights, "cost")
    result = mesh_set.apply_filter(
        SEGMENTATION, submesh_count=20, balance="weight", weight_attribute="cost"
    )
    assert result["weight_imbalance"] == pytest.approx(imbalance_of(mesh_set, weights))
    assert result["weight_imbalance"] <= 1.02
    kept = mesh_set.current_mesh().face_custom_scalar_attribute_array("cost")
    assert (kept == weights).all()


def test_a_missing_attribute_is_an_error_that_lists_those_there():
    require_attributes_from_python()
    mesh_set = ellipsoid()
    options = {"submesh_count": 5, "balance": "weight", "weight_attribute": "cost"}
    assert "the mesh has none" in refused(mesh_set, **options)
    mesh_set.current_mesh().add_face_custom_scalar_attribute(np.ones(512), "price")
    assert "the mesh has only price" in refused(mesh_set, **options)


@pytest.mark.parametrize(
    ("value", "message"),
    [(-1.0, "face 3 with -1"), (np.nan, "face 3 with"), (np.inf, "face 3 with inf")],
)
def test_bad_weights_are_an_error_with_the_first_face(value, message):
    require_attributes_from_python()
    mesh_set = ellipsoid()
    weights = np.ones(512)
    weights[[3, 8]] = value
    mesh_set.current_mesh().add_face_custom_scalar_attribute(weights, "cost")
    text = refused(mesh_set, submesh_count=5, balance="weight", weight_attribute="cost")
    assert message in text
    assert "2 of 512" in text


def test_an_attribute_without_the_balance_by_weight_is_an_error():
    require_attributes_from_python()
    mesh_set = ellipsoid()
    mesh_set.current_mesh().add_face_custom_scalar_attribute(np.ones(512), "cost")
    assert 'Use balance "weight"' in refused(mesh_set, submesh_count=5, weight_attribute="cost")


def test_all_pairs_refuses_weights_and_labels():
    assert "all_pairs" in refused(ellipsoid(), balance="weight", method="all_pairs")
    mesh_set = with_labels(np.arange(512) % 4)
    assert "all_pairs" in refused(mesh_set, initial_labels="face_quality", method="all_pairs")


def test_labels_are_repaired_and_set_the_number_of_submeshes():
    mesh_set = with_labels(10 * (np.arange(512) % 6) + 3)
    result = mesh_set.apply_filter(SEGMENTATION, submesh_count=0, initial_labels="face_quality")
    assert result["submesh_count"] == 6
    assert sorted(set(labels_of(mesh_set))) == list(range(6))
    assert result["max_triangle_count_difference"] <= 1
    assert result["disconnected_submesh_count"] == 0
    assert result["bowtie_count"] == 0


def test_refining_a_valid_result_makes_it_no_worse():
    mesh_set = ellipsoid(4)
    first = mesh_set.apply_filter(SEGMENTATION, submesh_count=30, effort="draft")
    labels = labels_of(mesh_set)
    again = mesh_set.apply_filter(SEGMENTATION, initial_labels="face_quality")
    assert again["boundary_edge_count"] <= first["boundary_edge_count"]
    assert again["max_triangle_count_difference"] <= 1
    assert (labels_of(mesh_set) == labels).mean() > 0.5


@pytest.mark.parametrize("value", [-1.0, 0.5, np.nan])
def test_bad_labels_are_the_error_that_the_measures_give(value):
    labels = np.zeros(512)
    labels[7] = value
    assert "face 7" in refused(with_labels(labels), initial_labels="face_quality")


def test_a_mesh_without_quality_has_no_labels():
    vertices, faces = subdivided_sphere(1)
    text = refused(document(vertices, faces), initial_labels="face_quality")
    assert "face quality" in text
