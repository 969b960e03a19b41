# SPDX-License-Identifier: GPL-3.0-or-later
import functools
import math
import os
import re
import subprocess
import sys
from xml.etree import ElementTree

import numpy as np
import pymeshlab
import pytest
from host_meshes import (
    MEASURES,
    PARAMETRIZATION,
    SEGMENTATION,
    document,
    edge_pairs,
    ellipsoid,
    labels_of,
    state,
)
from mesh_paths import REPOSITORY
from shapes import subdivided_sphere

MEASURE_KEYS = {
    "boundary_edge_count",
    "max_triangle_count_difference",
    "coefficient_of_variation",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
    "boundary_edge_ratio",
}
SEGMENTATION_KEYS = MEASURE_KEYS | {
    "submesh_count",
    "triangle_count",
    "min_submesh_triangles",
    "max_submesh_triangles",
    "component_count",
    "best_max_triangle_count_difference",
    "may_be_balanced",
    "weight_imbalance",
    "cohesion_iterations",
    "refinement_iterations",
    "parametrization_seconds",
    "cohesion_seconds",
    "refinement_seconds",
    "total_seconds",
    "time_limit_hit",
    "used_cuda",
    "boundary_edges_by_iteration",
    "seconds_by_iteration",
    "energy_by_iteration",
}
ITERATION_KEYS = ["boundary_edges_by_iteration", "seconds_by_iteration", "energy_by_iteration"]


def test_filters_are_methods_of_mesh_set():
    for name in (SEGMENTATION, PARAMETRIZATION, MEASURES):
        assert name in pymeshlab.filter_list()
        assert callable(getattr(pymeshlab.MeshSet, name))


def test_parameters_have_their_documented_defaults(sample):
    parameters = sample("cow.obj").filter_parameter_values(SEGMENTATION)
    assert parameters == {
        "method": 0,
        "submesh_count": 200,
        "triangles_per_submesh": 0,
        "effort": 1,
        "device": 0,
        "seed": 0,
        "thread_count": 0,
        "max_cohesion_iterations": 0,
        "max_refinement_iterations": 0,
        "time_limit_seconds": 0.0,
        "balance": 0,
        "weight_attribute": "",
        "initial_labels": 0,
        "colorize": True,
    }


def test_small_mesh_gets_fewer_submeshes_by_default():
    default = ellipsoid(2).filter_parameter_values(SEGMENTATION)["submesh_count"]
    assert default == 13  # 128 / 10 = 12.8


def test_returns_the_documented_keys_and_types(sample):
    result = sample("bone.ply").apply_filter(SEGMENTATION, submesh_count=50)
    assert set(result) == SEGMENTATION_KEYS
    iterations = result["cohesion_iterations"] + result["refinement_iterations"]
    assert iterations > 0
    for key in ITERATION_KEYS:
        assert result[key].shape == (iterations,)
    for key in ("may_be_balanced", "time_limit_hit", "used_cuda"):
        assert isinstance(result[key], bool)
    for key in ("submesh_count", "boundary_edge_count", "cohesion_iterations"):
        assert isinstance(result[key], int)


def test_help_names_every_returned_key():
    # PyMeshLab does not hand out the text of filterInfo.
    source = (REPOSITORY / "filter_spheroseg" / "help.cpp").read_text()
    text = "".join(re.findall(r'"([^"]*)"', source))
    assert {key for key in SEGMENTATION_KEYS if f"<i>{key}</i>" not in text} == set()


@pytest.mark.parametrize("submesh_count", [1, 2, 7, 60])
def test_labels_in_face_quality_are_balanced(submesh_count):
    mesh_set = ellipsoid()
    result = mesh_set.apply_filter(SEGMENTATION, submesh_count=submesh_count)
    quality = mesh_set.current_mesh().face_scalar_array()
    assert (quality == quality.astype(int)).all()
    counts = np.bincount(quality.astype(int), minlength=submesh_count)
    assert len(counts) == submesh_count
    assert set(counts) <= {512 // submesh_count, -(-512 // submesh_count)}
    assert result["submesh_count"] == submesh_count
    assert result["triangle_count"] == 512
    assert result["min_submesh_triangles"] == counts.min()
    assert result["max_submesh_triangles"] == counts.max()


def test_triangles_per_submesh_sets_the_count():
    result = ellipsoid().apply_filter(SEGMENTATION, submesh_count=3, triangles_per_submesh=100)
    assert result["submesh_count"] == math.ceil(512 / 100)


def test_returned_measures_are_those_of_the_labels(sample):
    mesh_set = sample("bone.ply")
    result = mesh_set.apply_filter(SEGMENTATION, submesh_count=40)
    measures = mesh_set.apply_filter(MEASURES)
    assert {key: result[key] for key in MEASURE_KEYS} == {k: measures[k] for k in MEASURE_KEYS}
    labels = labels_of(mesh_set)
    pairs = edge_pairs(mesh_set.current_mesh().face_matrix())
    assert result["boundary_edge_count"] == (labels[pairs[:, 0]] != labels[pairs[:, 1]]).sum()
    counts = np.bincount(labels)
    assert result["max_triangle_count_difference"] == np.ptp(counts)
    assert result["coefficient_of_variation"] == pytest.approx(counts.std() / counts.mean())


def test_neighboring_submeshes_have_different_colors(sample):
    mesh_set = sample("bone.ply")
    mesh_set.apply_filter(SEGMENTATION, submesh_count=100)
    colors = np.rint(255 * mesh_set.current_mesh().face_color_matrix()).astype(int)
    labels = labels_of(mesh_set)
    for label in range(100):
        assert len(np.unique(colors[labels == label], axis=0)) == 1
    pairs = edge_pairs(mesh_set.current_mesh().face_matrix())
    pairs = pairs[labels[pairs[:, 0]] != labels[pairs[:, 1]]]
    difference = np.abs(colors[pairs[:, 0]] - colors[pairs[:, 1]])[:, :3]
    assert (difference.sum(axis=1) > 30).all()


def test_without_colorize_the_colors_stay():
    mesh_set = ellipsoid(2)
    assert not mesh_set.current_mesh().has_face_color()
    mesh_set.apply_filter(SEGMENTATION, submesh_count=4, colorize=False)
    assert not mesh_set.current_mesh().has_face_color()


def test_only_quality_and_colors_change():
    mesh_set = ellipsoid(2)
    before = state(mesh_set)
    mesh_set.apply_filter(SEGMENTATION, submesh_count=4)
    after = state(mesh_set)
    changed = {key for key in before if before[key] != after[key]}
    assert changed == {"quality", "colors"}


def test_same_seed_gives_same_labels_for_any_thread_count_and_again():
    mesh_set = ellipsoid()
    labels = []
    for thread_count, submesh_count in [(1, 20), (2, 33), (2, 20), (0, 20)]:
        mesh_set.apply_filter(
            SEGMENTATION, submesh_count=submesh_count, seed=5, thread_count=thread_count
        )
        labels.append(labels_of(mesh_set))
    np.testing.assert_array_equal(labels[0], labels[2])
    np.testing.assert_array_equal(labels[0], labels[3])
    fresh = ellipsoid()
    fresh.apply_filter(SEGMENTATION, submesh_count=20, seed=5)
    np.testing.assert_array_equal(labels[0], labels_of(fresh))


def test_another_k_prepares_the_same_mesh_only_once():
    mesh_set = ellipsoid(5)
    first = mesh_set.apply_filter(SEGMENTATION, submesh_count=10)["parametrization_seconds"]
    later = min(
        mesh_set.apply_filter(SEGMENTATION, submesh_count=k)["parametrization_seconds"]
        for k in (11, 12, 13)
    )
    assert later < first / 4


def test_a_changed_mesh_is_not_taken_for_the_last_one():
    mesh_set = ellipsoid()
    mesh_set.apply_filter(SEGMENTATION, submesh_count=10)
    mesh_set.apply_filter("apply_coord_laplacian_smoothing")
    mesh_set.apply_filter(SEGMENTATION, submesh_count=10)
    mesh = mesh_set.current_mesh()
    fresh = pymeshlab.MeshSet()
    fresh.add_mesh(pymeshlab.Mesh(mesh.vertex_matrix(), mesh.face_matrix()))
    # A mesh in between, so that nothing is left of the other one.
    ellipsoid(1).apply_filter(SEGMENTATION, submesh_count=2)
    fresh.apply_filter(SEGMENTATION, submesh_count=10)
    np.testing.assert_array_equal(labels_of(mesh_set), labels_of(fresh))


def test_iteration_limits_hold():
    result = ellipsoid().apply_filter(
        SEGMENTATION, submesh_count=20, method="all_pairs", max_cohesion_iterations=1
    )
    assert result["cohesion_iterations"] == 1
    assert result["max_triangle_count_difference"] == 1


def test_time_limit_is_reported_and_the_result_balanced(sample):
    result = sample("bone.ply").apply_filter(
        SEGMENTATION, submesh_count=40, method="all_pairs", time_limit_seconds=1e-9
    )
    assert result["time_limit_hit"]
    assert result["max_triangle_count_difference"] <= 1


def test_a_mesh_after_deleting_a_part_of_it_is_as_a_clean_one():
    (small, small_faces), (large, large_faces) = subdivided_sphere(1), subdivided_sphere(3)
    large = large * [1.0, 1.5, 2.0]
    mesh_set = document(
        np.vstack([small + 10.0, large]), np.vstack([small_faces, large_faces + len(small)])
    )
    mesh_set.apply_filter("compute_selection_by_condition_per_face", condselect="x0 > 5")
    mesh_set.apply_filter("meshing_remove_selected_vertices_and_faces")
    mesh_set.apply_filter(SEGMENTATION, submesh_count=12)
    clean = document(large, large_faces)
    clean.apply_filter(SEGMENTATION, submesh_count=12)
    np.testing.assert_array_equal(labels_of(mesh_set), labels_of(clean))
    np.testing.assert_array_equal(
        mesh_set.current_mesh().face_color_matrix(), clean.current_mesh().face_color_matrix()
    )


@pytest.mark.parametrize("name", ["cow.obj", "bone.ply", "airplane.obj", "bunny.obj"])
def test_sample_meshes_of_pymeshlab(sample, name):
    mesh_set = sample(name)
    result = mesh_set.apply_filter(
        SEGMENTATION, submesh_count=200, max_cohesion_iterations=2, max_refinement_iterations=1
    )
    counts = np.bincount(labels_of(mesh_set), minlength=200)
    assert len(counts) == 200
    assert np.ptp(counts) <= 1
    assert result["max_triangle_count_difference"] == np.ptp(counts)


@pytest.mark.parametrize("method", ["fast", "all_pairs"])
def test_labels_do_not_depend_on_the_coordinates(sample, method):
    # So MeshLab, in single precision, and PyMeshLab, in double, give the same labels.
    given = sample("cow.obj")
    there = given.current_mesh()
    moved = document(there.vertex_matrix().astype(np.float32), there.face_matrix())
    shaken = document(
        np.random.default_rng(7).normal(size=(there.vertex_number(), 3)), there.face_matrix()
    )
    labels = []
    for mesh_set in (given, moved, shaken):
        mesh_set.apply_filter(
            SEGMENTATION,
            submesh_count=20,
            method=method,
            max_cohesion_iterations=3,
            max_refinement_iterations=1,
        )
        labels.append(labels_of(mesh_set))
    assert np.array_equal(labels[0], labels[1])
    assert np.array_equal(labels[0], labels[2])


LOGGED = """
import numpy as np
import spheroseg
from host_meshes import PARAMETRIZATION, SEGMENTATION, document
from shapes import star_of_strips, subdivided_sphere

def verbose(vertices, faces):
    mesh_set = document(vertices, faces)
    mesh_set.set_verbosity(True)
    return mesh_set

large, medium, small = [subdivided_sphere(levels) for levels in (3, 2, 1)]
"""
OF_TWO_COMPONENTS = """
vertices = np.concatenate([large[0], small[0] + 5.0])
faces = np.concatenate([large[1], small[1] + len(large[0])])
result = verbose(vertices, faces).apply_filter(SEGMENTATION, submesh_count={submesh_count})
print("best", result["best_max_triangle_count_difference"])
"""
OF_ONE_COMPONENT = """
one = verbose(*small)
one.apply_filter(SEGMENTATION, submesh_count=1)
one.apply_filter("generate_submesh_layers")
verbose(*star_of_strips(6)).apply_filter(SEGMENTATION, submesh_count=2)
"""
OF_A_MAPPED_SPHERE = """
mesh_set = verbose(*medium)
for name in [PARAMETRIZATION, *{changes}]:
    mesh_set.apply_filter(name)
print("difference", mesh_set.apply_filter(SEGMENTATION)["max_triangle_count_difference"])
"""
OF_ALL_PAIRS = """
few = {"max_cohesion_iterations": 1, "max_refinement_iterations": 1}
result = verbose(*medium).apply_filter(SEGMENTATION, method="all_pairs", submesh_count=40, **few)
print(f"found {result['disconnected_submesh_count']}, {result['bowtie_count']}")
"""


@functools.cache
def logged(calls):
    """In a process of its own: the host's log is whole when it has ended."""
    done = subprocess.run(
        [sys.executable, "-c", LOGGED + calls],
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(path for path in sys.path if path)),
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout + done.stderr


@pytest.mark.parametrize(("submesh_count", "difference"), [(3, 224), (50, 1), (17, 0)])
def test_the_log_warns_where_triangle_counts_differ_by_more_than_one(submesh_count, difference):
    """Components of 512 and 32 triangles: in three sub-meshes 256, 256 and 32 is the best."""
    said = logged(OF_TWO_COMPONENTS.format(submesh_count=submesh_count))
    assert f"best {difference}\n" in said
    count = "1 triangle" if difference == 1 else f"{difference} triangles"
    assert f"; 2 components, which allow a difference of {count} at best" in said
    warning = (
        f"The result has {difference} triangles between the largest and the smallest sub-mesh, the "
        "fewest that its components allow."
    )
    assert (warning in said) == (difference > 1)
    assert said.count("The result has") == (difference > 1)


def test_the_log_says_where_no_cut_is_balanced():
    """A face with strips of six on its sides, in two: 6 and 13."""
    said = logged(OF_ONE_COMPONENT)
    assert (
        "The result has 7 triangles between the largest and the smallest sub-mesh (no cut into "
        "so many connected ones is balanced, as parts of the mesh hang on the rest by "
        "single edges)."
    ) in said
    assert said.count("The result has") == 1
    assert "components" not in said


def test_the_log_counts_one_and_many():
    many = logged(OF_TWO_COMPONENTS.format(submesh_count=3))
    assert "544 triangles in 3 sub-meshes of 32 to 256; " in many
    one = logged(OF_ONE_COMPONENT)
    assert "32 triangles in 1 sub-mesh of 32 to 32; 0 boundary edges, 0 bowties, " in one
    assert "1 layer made, one for each sub-mesh" in one


def test_the_log_names_pieces_and_bowties():
    said = logged(OF_ALL_PAIRS)
    pieces, bowties = map(int, re.search(r"found (\d+), (\d+)", said).groups())
    assert (pieces > 1, bowties > 1) == (True, True)
    shortcomings = f"{pieces} sub-meshes in more than one piece, {bowties} bowties"
    assert f"The result has {shortcomings}." in said
    assert "; 1 cohesion and 1 refinement iteration, " in said


@pytest.mark.parametrize("changes", [[], ["meshing_invert_face_orientation"]])
def test_the_log_warns_of_a_map_that_does_not_fit(changes):
    said = logged(OF_A_MAPPED_SPHERE.format(changes=changes))
    assert "difference 1\n" in said
    warning = "The attribute sphere_position does not fit this mesh any more; it is ignored."
    assert said.count(warning) == len(changes)
    assert "The result has" not in said


@pytest.mark.parametrize("is_below", [True, False])
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("method", "fast, all_pairs (0 to 1)"),
        ("effort", "draft, standard, high (0 to 2)"),
        ("device", "auto, cpu, cuda (0 to 2)"),
        ("balance", "triangle_count, weight (0 to 1)"),
        ("initial_labels", "none, face_quality (0 to 1)"),
    ],
)
def test_a_filter_script_with_a_choice_that_is_not_there_is_refused(
    tmp_path, name, words, is_below
):
    """PyMeshLab checks the numbers of words in a call, but not in a script; nor does MeshLab."""
    number = -1 if is_below else words.count(",") + 1
    mesh_set = ellipsoid(1)
    mesh_set.apply_filter(SEGMENTATION, submesh_count=4)
    script = tmp_path / "history.mlx"
    mesh_set.save_filter_script(str(script))
    history = ElementTree.fromstring(script.read_text())
    history.find(f".//Param[@name='{name}']").set("value", str(number))
    script.write_text(ElementTree.tostring(history, encoding="unicode"))

    replayed = ellipsoid(1)
    replayed.load_filter_script(str(script))
    before = state(replayed)
    message = re.escape(f"{name} must be one of {words}, found {number}. ")
    with pytest.raises(pymeshlab.PyMeshLabException, match=message):
        replayed.apply_filter_script()
    assert state(replayed) == before
