# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from host_meshes import (
    PARAMETRIZATION,
    SEGMENTATION,
    ellipsoid,
    labels_of,
    mesh_count,
    require_attributes_from_python,
    state,
)
from recount import flipped_triangle_count

ATTRIBUTE = "sphere_position"
ALL_PAIRS = {"submesh_count": 16, "method": "all_pairs"}


def sphere_positions(mesh_set):
    return mesh_set.current_mesh().vertex_custom_point_attribute_matrix(ATTRIBUTE)


def with_attribute(positions):
    require_attributes_from_python()
    mesh_set = ellipsoid()
    mesh_set.current_mesh().add_vertex_custom_point_attribute(positions, ATTRIBUTE)
    return mesh_set


def squeezed(positions, factor=3.0):
    """Moves everything towards the north pole by a map of the sphere that keeps angles."""
    x, y, z = positions.T
    plane = (x + 1j * y) / (1.0 + z) / factor
    square = np.abs(plane) ** 2
    return np.stack([2 * plane.real, 2 * plane.imag, 1 - square], axis=1) / (1 + square)[:, None]


def test_parameter_defaults():
    assert ellipsoid(1).filter_parameter_values(PARAMETRIZATION) == {"new_layer": False}


@pytest.mark.parametrize("name", ["cow.obj", "bone.ply", "airplane.obj", "bunny.obj"])
def test_sample_meshes_of_pymeshlab_have_no_flipped_triangle(sample, name):
    mesh_set = sample(name)
    result = mesh_set.apply_filter(PARAMETRIZATION)
    positions = sphere_positions(mesh_set)
    np.testing.assert_allclose(np.linalg.norm(positions, axis=1), 1.0, atol=1e-12)
    assert flipped_triangle_count(positions, mesh_set.current_mesh().face_matrix()) == 0
    assert result["flipped_triangle_count"] == 0
    assert result["min_triangle_area"] > 0.0
    assert result["area_distortion_max"] >= result["area_distortion_mean"] >= 1.0


def test_returns_the_documented_keys():
    result = ellipsoid(2).apply_filter(PARAMETRIZATION)
    assert set(result) == {
        "flipped_triangle_count",
        "min_triangle_area",
        "area_distortion_mean",
        "area_distortion_max",
        "seconds",
    }


def test_only_the_attribute_is_written():
    mesh_set = ellipsoid(2)
    before = state(mesh_set)
    mesh_set.apply_filter(PARAMETRIZATION)
    after = state(mesh_set)
    assert {key for key in before if before[key] != after[key]} == {"attributes"}


def test_new_layer_has_the_sphere_and_the_source_stays_current():
    mesh_set = ellipsoid(2)
    source = mesh_set.current_mesh().vertex_matrix()
    mesh_set.apply_filter(PARAMETRIZATION, new_layer=True)
    assert mesh_count(mesh_set) == 2
    assert mesh_set.current_mesh_id() == 0
    np.testing.assert_array_equal(mesh_set.current_mesh().vertex_matrix(), source)
    positions = sphere_positions(mesh_set)
    mesh_set.set_current_mesh(1)
    np.testing.assert_array_equal(mesh_set.current_mesh().vertex_matrix(), positions)
    assert mesh_set.current_mesh().face_number() == 128


def test_segmentation_uses_the_written_map():
    plain = ellipsoid()
    plain.apply_filter(SEGMENTATION, **ALL_PAIRS)
    prepared = ellipsoid()
    prepared.apply_filter(PARAMETRIZATION)
    prepared.apply_filter(SEGMENTATION, **ALL_PAIRS)
    np.testing.assert_array_equal(labels_of(plain), labels_of(prepared))


def test_segmentation_uses_a_valid_map_of_the_user_instead_of_its_own():
    plain = ellipsoid()
    plain.apply_filter(PARAMETRIZATION)
    positions = sphere_positions(plain)
    plain.apply_filter(SEGMENTATION, **ALL_PAIRS)
    other = with_attribute(squeezed(positions))
    result = other.apply_filter(SEGMENTATION, **ALL_PAIRS)
    assert flipped_triangle_count(squeezed(positions), other.current_mesh().face_matrix()) == 0
    assert (labels_of(plain) != labels_of(other)).any()
    assert result["max_triangle_count_difference"] <= 1
    np.testing.assert_array_equal(sphere_positions(other), squeezed(positions))
    # The map of the one call is not left over for a mesh without one.
    again = ellipsoid()
    again.apply_filter(SEGMENTATION, **ALL_PAIRS)
    np.testing.assert_array_equal(labels_of(plain), labels_of(again))


@pytest.mark.parametrize("defect", ["flipped", "not on the sphere", "nan"])
def test_an_invalid_map_is_ignored(defect):
    plain = ellipsoid()
    plain.apply_filter(PARAMETRIZATION)
    positions = sphere_positions(plain)
    plain.apply_filter(SEGMENTATION, **ALL_PAIRS)
    if defect == "flipped":
        positions = positions * [1.0, 1.0, -1.0]
    elif defect == "nan":
        positions[7] = np.nan
    else:
        positions = 2.0 * positions
    other = with_attribute(positions)
    other.apply_filter(SEGMENTATION, **ALL_PAIRS)
    np.testing.assert_array_equal(labels_of(plain), labels_of(other))
