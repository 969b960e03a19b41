# SPDX-License-Identifier: GPL-3.0-or-later
"""segment, parametrize and measure on arrays; the filters as methods of MeshSet."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
from concurrent import futures
from fractions import Fraction

import numpy as np
import pymeshlab
import pytest
import recount
from mesh_paths import PYMESHLAB_MESHES, REPOSITORY, SAMPLES, load_arrays
from processes import is_filter_running, run_python
from shapes import bumpy_sphere, star_of_strips, subdivided_sphere

import spheroseg
from spheroseg import api, mesh_files

FILTERS = [
    "compute_scalar_by_balanced_segmentation_per_face",
    "compute_spherical_parametrization_per_vertex",
    "get_segmentation_measures",
]
# all_pairs costs O(F^2) per iteration.
FEW = {"max_cohesion_iterations": 3, "max_refinement_iterations": 2}
SMALL_SAMPLES = ["cube.obj", "flat_leaf.ply", "sliver_rod.ply", "spindle.ply"]


def segment(arrays, submesh_count=None, **options):
    return spheroseg.segment(*arrays, submesh_count, **{**FEW, **options})


SECTION_KEYS = {
    "boundary_edge_count",
    "max_triangle_count_difference",
    "coefficient_of_variation",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
    "boundary_edge_ratio",
}


def assert_same_measures(found, expected):
    assert set(found) >= SECTION_KEYS
    for key in set(found) & set(expected):
        value = expected[key]
        assert np.allclose(found[key], value, rtol=1e-12), (key, found[key], value)


@pytest.mark.parametrize("name", FILTERS)
def test_import_binds_each_filter_as_a_documented_method(cube, name):
    text = getattr(pymeshlab.MeshSet, name).__doc__
    assert "(SpheroSeg)" in text
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(*cube))
    for parameter in mesh_set.filter_parameter_values(name):
        assert parameter in text


def test_docstring_and_manual_name_the_default_of_each_choice(cube):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(*cube))
    defaults = mesh_set.filter_parameter_values(api.SEGMENT_FILTER)
    docstring = " ".join(getattr(pymeshlab.MeshSet, api.SEGMENT_FILTER).__doc__.split())
    manual = (REPOSITORY / "docs" / "python.md").read_text()
    choices = (api.METHODS, api.EFFORTS, api.DEVICES, api.BALANCES)
    for name, words in zip(("method", "effort", "device", "balance"), choices, strict=True):
        default = words[defaults[name]]
        assert f" {name} (default '{default}'" in docstring
        assert re.search(rf"^\| `{name}` \| [^|]*`{default}` \(default\)", manual, re.M), name


@pytest.mark.parametrize("page", ["README.md", "docs/python.md", "docs/weights.md"])
def test_the_examples_of_the_manual_run(page, tmp_path, monkeypatch):
    cow = shutil.copy(mesh_files.sample_mesh("cow.obj"), tmp_path)
    monkeypatch.chdir(tmp_path)
    vertices, faces = load_arrays(cow)
    names = {"spheroseg": spheroseg, "pymeshlab": pymeshlab, "vertices": vertices, "faces": faces}
    names |= {"weights": np.arange(len(faces)) / 2, "labels": np.arange(len(faces)) // 30}
    examples = re.findall(r"^```python\n(.*?)^```", (REPOSITORY / page).read_text(), re.M | re.S)
    assert len(examples) == 2
    for example in examples:
        exec(example, names)


def test_the_methods_work_as_the_manual_shows(sample_arrays):
    vertices, faces = sample_arrays["flat_leaf.ply"]
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces))
    report = mesh_set.compute_scalar_by_balanced_segmentation_per_face(submesh_count=20, **FEW)
    labels = mesh_set.current_mesh().face_scalar_array().astype(int)
    assert report["submesh_count"] == 20
    assert np.bincount(labels).tolist() == [64] * 20
    assert (
        mesh_set.get_segmentation_measures()["boundary_edge_count"]
        == (report["boundary_edge_count"])
    )


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"submesh_count": 12 / 4, "seed": 1}, r"^submesh_count must be a whole .*, got 3\.0"),
        ({"submesh_count": 2**40}, r"^submesh_count must be .* of 32 bits, got 10995"),
        ({"seed": "one", "colorize": "no"}, r"^seed must .* got 'one' .*; colorize must be a"),
        ({"submesh_count": 3, "time_limit_seconds": "1"}, r"^time_limit_seconds must be a number"),
        ({"weight_attribute": 3}, r"^weight_attribute must be a string, got 3"),
        ({"method": 0.5, "effort": "high"}, r"^method must be .*, got 0\.5"),
    ],
)
def test_parameters_of_a_wrong_type_are_named_and_the_mesh_is_left_alone(cube, parameters, message):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(*cube))
    with pytest.raises(spheroseg.InputError, match=message):
        mesh_set.compute_scalar_by_balanced_segmentation_per_face(**parameters)
    assert not mesh_set.current_mesh().has_face_scalar()
    assert not mesh_set.current_mesh().has_face_color()


@pytest.mark.parametrize("name", SMALL_SAMPLES)
@pytest.mark.parametrize("submesh_count", [1, 7, 12])
def test_labels_are_balanced_for_any_k_and_measured_rightly(sample_arrays, name, submesh_count):
    vertices, faces = sample_arrays[name]
    result = segment((vertices, faces), submesh_count)
    counts = np.bincount(result.labels, minlength=submesh_count)
    assert result.labels.dtype == np.int32
    assert len(counts) == submesh_count
    assert counts.sum() == len(faces)
    assert counts.max() - counts.min() <= 1
    assert_same_measures(result.measures, recount.measures(faces, result.labels))


def test_results_can_be_unpacked(cube):
    result = spheroseg.segment(*cube, 3)
    labels, measures = result
    assert (labels is result.labels, measures is result.measures) == (True, True)
    result = spheroseg.parametrize(*cube)
    positions, measures = result
    assert (positions is result.positions, measures is result.measures) == (True, True)


@pytest.mark.parametrize(
    ("name", "face_count", "k"),
    [("cube.obj", 12, 2), ("flat_leaf.ply", 1_280, 128), ("displaced_sphere.ply", 5_120, 200)],
)
def test_k_is_200_by_default_or_a_tenth_of_the_triangles(sample_arrays, name, face_count, k):
    vertices, faces = sample_arrays[name]
    assert len(faces) == face_count
    options = {"max_cohesion_iterations": 1, "max_refinement_iterations": 1}
    assert spheroseg.segment(vertices, faces, **options).measures["submesh_count"] == k


def test_triangles_per_submesh_gives_the_ceiling(sample_arrays):
    result = segment(sample_arrays["flat_leaf.ply"], triangles_per_submesh=300)
    assert result.measures["submesh_count"] == 5  # 1280 / 300 = 4.27


@pytest.mark.parametrize("name", SMALL_SAMPLES)
@pytest.mark.parametrize("method", [{}, {"method": "all_pairs"}], ids=["default", "all_pairs"])
def test_labels_depend_on_the_seed_but_not_on_threads_or_the_run(sample_arrays, name, method):
    def labels(seed, thread_count):
        arrays = sample_arrays[name]
        return segment(arrays, 6, seed=seed, thread_count=thread_count, **method).labels

    first = labels(5, 1)
    assert np.array_equal(first, labels(5, 2))
    assert np.array_equal(first, labels(5, 2))
    # By chance a small mesh may have the same labels for another seed, but not for each.
    assert not all(np.array_equal(first, labels(seed, 1)) for seed in (6, 7, 8))


def test_the_callers_arrays_stay_as_they_are(sample_arrays):
    vertices, faces = (array.copy() for array in sample_arrays["cube.obj"])
    segment((vertices, faces), 3)
    assert np.array_equal(vertices, sample_arrays["cube.obj"][0])
    assert np.array_equal(faces, sample_arrays["cube.obj"][1])


def test_lists_and_any_number_type_and_memory_order_will_do(cube):
    expected = segment(cube, 4).labels
    vertices, faces = cube
    for form in (
        (vertices.tolist(), faces.tolist()),
        (vertices.astype(np.float32), faces.astype(np.uint64)),
        (vertices.astype(int), faces.astype(float)),
        (np.asfortranarray(vertices), np.asfortranarray(faces)),
    ):
        assert np.array_equal(segment(form, 4).labels, expected)


def test_vertices_of_no_face_are_allowed(cube):
    vertices, faces = cube
    unused = np.full((2, 3), 7.0)
    behind = segment((np.concatenate([vertices, unused]), faces), 4)
    assert np.array_equal(behind.labels, segment(cube, 4).labels)
    before = segment((np.concatenate([unused, vertices]), faces + 2), 4)
    assert np.bincount(before.labels).tolist() == [3, 3, 3, 3]


@pytest.mark.parametrize("path", SAMPLES + PYMESHLAB_MESHES, ids=lambda path: path.name)
def test_parametrization_has_no_flipped_triangle(path):
    vertices, faces = load_arrays(path)
    result = spheroseg.parametrize(vertices, faces)
    assert result.positions.shape == vertices.shape
    assert np.abs(np.linalg.norm(result.positions, axis=1) - 1).max() < 1e-12
    assert result.measures["flipped_triangle_count"] == 0
    assert recount.flipped_triangle_count(result.positions, faces) == 0


@pytest.mark.parametrize("name", SMALL_SAMPLES)
@pytest.mark.parametrize("share", [0.0, 0.02, 0.4, 1.0])
def test_measures_of_random_labels_equal_an_independent_count(sample_arrays, name, share):
    vertices, faces = sample_arrays[name]
    generator = np.random.default_rng(len(faces))
    submesh_count = max(1, int(share * len(faces)))
    labels = generator.integers(submesh_count, size=len(faces))
    labels[generator.integers(len(faces))] = submesh_count - 1
    assert_same_measures(
        spheroseg.measure(vertices, faces, labels), recount.measures(faces, labels)
    )


def test_measures_of_bands_with_holes_equal_an_independent_count(sample_arrays):
    # Annuli, discs and pieces: labels by height, and by the sign of a wave.
    vertices, faces = sample_arrays["displaced_sphere.ply"]
    middle = vertices[faces].mean(axis=1)
    bands = np.clip(((middle[:, 2] + 1.5) * 3).astype(int), 0, 8)
    waves = 2 * bands + (np.sin(4 * middle[:, 0]) > 0)
    for labels in (np.unique(array, return_inverse=True)[1] for array in (bands, waves)):
        expected = recount.measures(faces, labels)
        assert_same_measures(spheroseg.measure(vertices, faces, labels), expected)
    assert 0 < expected["disk_count"] < expected["submesh_count"]


def replaced(array, index, value):
    changed = array.astype(float)
    changed[index] = value
    return changed


BAD_ARRAYS = {
    "vertex shape": (
        lambda v, f: (v[:, :2], f),
        r"vertices must have the shape \(V, 3\).*\(8, 2\)",
    ),
    "face shape": (lambda v, f: (v, f.reshape(-1)), r"faces must have the shape.*\(36,\)"),
    "ragged": (lambda v, f: (v, [[0, 1, 2], [3]]), r"faces must be an array of shape"),
    "words": (lambda v, f: ([["a", "b", "c"]], f), r"vertices must be numbers"),
    "NaN": (lambda v, f: (replaced(v, (5, 1), np.nan), f), r"vertex 5 has y = nan"),
    "infinite": (lambda v, f: (replaced(v, (2, 2), -np.inf), f), r"vertex 2 has z = -inf"),
    "index too large": (lambda v, f: (v, replaced(f, (3, 0), 8)), r"face 3 names vertex 8"),
    "negative index": (lambda v, f: (v, replaced(f, (4, 2), -1)), r"face 4 names vertex -1"),
    "half index": (lambda v, f: (v, replaced(f, (0, 1), 1.5)), r"\(0, 1\) is 1.5"),
    "NaN index": (lambda v, f: (v, replaced(f, (0, 1), np.nan)), r"\(0, 1\) is nan"),
    "no faces": (lambda v, f: (v, f[:0]), r"at least one triangle"),
    "face twice": (lambda v, f: (v, np.vstack([f, f[:1]])), r"(?i)duplicate|non-manifold"),
    "corner twice": (lambda v, f: (v, np.vstack([f, [[0, 0, 1]]])), r"(?i)degenerate|twice"),
}


NOT_SPHERES = {
    "one face": (lambda v, f: (v, f[:1]), r"open border"),
    "hole": (lambda v, f: (v, f[1:]), r"3 open border edges"),
    "turned face": (lambda v, f: (v, np.vstack([f[:1, ::-1], f[1:]])), r"(?i)orient"),
    "two pieces": (lambda v, f: (np.vstack([v, v + 3]), np.vstack([f, f + 8])), r"2 .*component"),
}


@pytest.mark.parametrize("case", NOT_SPHERES)
def test_fast_cuts_surfaces_that_have_no_map_to_the_sphere(cube, case):
    change, message = NOT_SPHERES[case]
    with pytest.raises(spheroseg.InputError, match=message):
        spheroseg.parametrize(*change(*cube))
    count = 1 if case == "one face" else 3
    result = segment(change(*cube), count)
    assert set(result.labels) == set(range(count))
    assert (
        result.measures["max_triangle_count_difference"]
        == (result.measures["best_max_triangle_count_difference"])
    )
    assert result.measures["component_count"] == (2 if case == "two pieces" else 1)


def test_more_pieces_than_submeshes_are_refused(cube):
    vertices, faces = cube
    with pytest.raises(spheroseg.InputError, match=r"\(1\).*2 components.*Merge Close Vertices"):
        segment((np.vstack([vertices, vertices + 3]), np.vstack([faces, faces + 8])), 1)


@pytest.mark.parametrize("case", BAD_ARRAYS)
def test_a_bad_mesh_is_refused_with_the_reason_and_the_next_call_works(cube, case):
    spoil, message = BAD_ARRAYS[case]
    for function in (segment, lambda arrays: spheroseg.parametrize(*arrays)):
        with pytest.raises(spheroseg.InputError, match=message):
            function(spoil(*cube))
    assert len(segment(cube, 4).labels) == 12


BAD_OPTIONS = [
    ({"method": np.array(["fast", "fast"])}, r"method must be one of fast, all_pairs, got array"),
    ({"effort": ["high"]}, r"effort must be one of .*, got \['high'\]"),
    ({"submesh_count": 0}, r"submesh_count.*0"),
    ({"submesh_count": -3}, r"submesh_count.*-3"),
    ({"submesh_count": 13}, r"submesh_count.*13"),
    ({"submesh_count": 2.5}, r"submesh_count must be a whole number, got 2.5"),
    ({"submesh_count": True}, r"submesh_count must be a number, got True"),
    ({"submesh_count": "4"}, r"submesh_count must be a number, got '4'"),
    ({"triangles_per_submesh": -1}, r"triangles_per_submesh.*-1"),
    ({"method": "best"}, r"method must be one of fast, all_pairs, got 'best'"),
    ({"effort": "max"}, r"effort must be one of draft, standard, high"),
    ({"device": "gpu"}, r"device must be one of auto, cpu, cuda, got 'gpu'"),
    ({"seed": 2**40}, r"seed must fit into 32 bits, got 1099511627776"),
    ({"thread_count": -2}, r"thread_count.*-2"),
    ({"max_cohesion_iterations": -1}, r"max_cohesion_iterations.*-1"),
    ({"max_refinement_iterations": -1}, r"max_refinement_iterations.*-1"),
    ({"time_limit_seconds": -0.5}, r"time_limit_seconds.*-0.5"),
    ({"time_limit_seconds": float("nan")}, r"time_limit_seconds must be finite, got nan"),
    ({"time_limit_seconds": 10**400}, r"time_limit_seconds must be finite, got 1000"),
    ({"weight_attribute": "w"}, r"weight_attribute='w' needs balance='weight'"),
    (
        {"balance": "weight", "face_weights": np.ones(12), "weight_attribute": "w"},
        r"either weights for the faces or weight_attribute, not both",
    ),
    ({"colours": 3}, r"no option 'colours'; it has submesh_count"),
]


@pytest.mark.parametrize(("options", "message"), BAD_OPTIONS)
def test_a_bad_option_is_refused_with_its_value(cube, options, message):
    with pytest.raises(spheroseg.InputError, match=message):
        spheroseg.segment(*cube, **options)


def test_a_time_limit_may_be_any_real_number(cube):
    for limit in (Fraction(1, 2), np.float16(0.5), 1):
        assert len(spheroseg.segment(*cube, 3, time_limit_seconds=limit).labels) == 12


def test_labels_and_faces_may_be_of_16_bits(cube):
    vertices, faces = cube
    labels = np.repeat(np.arange(3), 4)
    halves = labels.astype(np.float16)
    expected = spheroseg.measure(vertices, faces, labels)
    np.testing.assert_equal(spheroseg.measure(vertices, faces, halves), expected)
    result = spheroseg.segment(vertices, faces, initial_labels=halves)
    assert result.measures["submesh_count"] == 3
    many = np.pad(vertices, ((0, 70_000), (0, 0)))  # more than that type's largest number
    measured = spheroseg.measure(many, faces.astype(np.float16), labels)
    np.testing.assert_equal(measured, expected)


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        (np.zeros(11), "one entry per face: 12, got 11"),
        (np.zeros((12, 1)), r"shape \(F,\), got \(12, 1\)"),
        (np.full(12, 0.5), r"\(0,\) is 0.5"),
        ([0] * 11 + [-4], "face 11 has -4"),
        ([0] * 11 + [2**24], r"in \[0, 16777216\); face 11 has 16777216"),
        ([0] * 11 + [2**31], "face 11 has 2147483648"),
        (["a"] * 12, "labels must be numbers"),
    ],
)
def test_bad_labels_are_refused_with_the_reason(cube, labels, message):
    with pytest.raises(spheroseg.InputError, match=message):
        spheroseg.measure(*cube, labels)
    with pytest.raises(spheroseg.InputError, match=message) as said:
        spheroseg.segment(*cube, initial_labels=labels)
    assert str(said.value).startswith("initial_labels")


def test_an_unknown_option_is_answered_with_those_that_arrays_take(cube):
    with pytest.raises(spheroseg.InputError) as said:
        spheroseg.segment(*cube, weights=[1] * 12)
    known = str(said.value).partition("it has ")[2].split(", ")
    assert {"submesh_count", "face_weights", "initial_labels", "seed"} < set(known)
    assert "weight_attribute" not in known


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        ({"submesh_count": 1}, "submesh_count=1 asks for 1 sub-mesh, but"),
        ({"submesh_count": 4}, "submesh_count=4 asks for 4 sub-meshes, but"),
        ({"triangles_per_submesh": 5}, "triangles_per_submesh=5 asks for 3 sub-meshes, but"),
    ],
)
def test_another_k_than_that_of_initial_labels_is_refused(cube, wish, message):
    with pytest.raises(
        spheroseg.InputError, match=f"{message} k is the number of different initial labels, 2;"
    ):
        spheroseg.segment(*cube, initial_labels=[0, 5] * 6, **wish)


@pytest.mark.parametrize("wish", [{"submesh_count": 2}, {"triangles_per_submesh": 7}, {}])
def test_the_k_of_initial_labels_may_be_given(cube, wish):
    result = spheroseg.segment(*cube, initial_labels=[0, 5] * 6, **wish)
    assert result.measures["submesh_count"] == 2


def test_results_can_be_kept_in_sets(cube):
    results = [spheroseg.segment(*cube, 2), spheroseg.segment(*cube, 2)]
    assert len(set(results)) == 2
    assert results[0] != results[1]


def test_the_largest_label_is_taken(cube):
    labels = [0] * 11 + [2**24 - 1]
    assert spheroseg.measure(*cube, labels)["max_triangle_count_difference"] == 11
    assert spheroseg.segment(*cube, initial_labels=labels).labels.max() == 1


def test_meshes_can_be_loaded_after_a_refused_call():
    # PyMeshLab alone crashes here; see spheroseg._plugin.forget_failed_call.
    script = """
import numpy, spheroseg, pymeshlab, sys
other = pymeshlab.MeshSet()  # now, as later it could take the place of the refused one
refused = pymeshlab.MeshSet()
refused.add_mesh(pymeshlab.Mesh(numpy.eye(3), numpy.array([[0, 1, 2]], numpy.int32)))
try:
    refused.compute_scalar_by_balanced_segmentation_per_face(submesh_count=2)
except pymeshlab.PyMeshLabException as error:
    print("refused" if "submesh_count" in str(error) else error)
del refused
other.load_new_mesh(sys.argv[1])
print("loaded")
"""
    fill_freed_memory = {"MALLOC_PERTURB_": "165"}
    done = run_python("-c", script, PYMESHLAB_MESHES[0], **fill_freed_memory)
    assert (done.returncode, done.stdout) == (0, "refused\nloaded\n"), done.stderr


def test_calls_of_several_threads_wait_for_one_another(sample_arrays):
    arrays = sample_arrays["flat_leaf.ply"]
    expected = segment(arrays, 20).labels
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(*arrays))
    together = threading.Barrier(8)

    def call(number):
        together.wait()
        if number == 0:
            mesh_set.compute_scalar_by_balanced_segmentation_per_face(submesh_count=20, **FEW)
            return mesh_set.current_mesh().face_scalar_array()
        return segment(arrays, 20).labels

    with futures.ThreadPoolExecutor(8) as pool:
        for labels in pool.map(call, range(8)):
            assert np.array_equal(labels, expected)


@pytest.mark.parametrize(
    ("label", "prefix"),
    [
        ("a.cow.obj", "a.cow "),
        ("COW.PLY", "COW "),
        ("", ""),
        ("my.mesh v1.2 ä", "my.mesh v1.2 ä "),
        ("my.mesh v1 18", "my.mesh v1 18 "),
        ("a/b: 1.obj 3", "a/b: 1.obj 3 "),
    ],
)
def test_layers_are_named_after_the_mesh(cube, label, prefix):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(*cube))
    mesh_set.current_mesh().set_label(label)
    mesh_set.compute_spherical_parametrization_per_vertex(new_layer=True)
    mesh_set.compute_scalar_by_balanced_segmentation_per_face(submesh_count=2)
    mesh_set.generate_submesh_layers()
    names = [mesh_set.mesh(index).label() for index in range(mesh_set.mesh_number())]
    assert names == [label, f"{prefix}(sphere)", f"{prefix}0", f"{prefix}1"]


@pytest.mark.parametrize("unreferenced_count", [1, 40])
def test_sphere_layer_of_a_mesh_with_deleted_vertices(unreferenced_count):
    vertices, faces = subdivided_sphere(2)
    unreferenced = np.full((unreferenced_count, 3), 50.0)
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(
        pymeshlab.Mesh(np.vstack([unreferenced, vertices]), faces + unreferenced_count)
    )
    # It deletes them, and PyMeshLab then refuses the mesh, but leaves it in the set.
    with pytest.raises(pymeshlab.PyMeshLabException, match="Compactness"):
        mesh_set.apply_coord_two_steps_smoothing()
    mesh_set.compute_spherical_parametrization_per_vertex(new_layer=True)
    layer = mesh_set.mesh(1)
    assert layer.vertex_number() == len(vertices)
    assert layer.face_matrix().tolist() == faces.tolist()
    positions = layer.vertex_matrix()
    assert np.allclose(np.linalg.norm(positions, axis=1), 1, atol=1e-6)
    attribute = layer.vertex_custom_point_attribute_matrix("sphere_position")
    assert np.array_equal(attribute, positions)


FORK = """
import os, signal, sys
import numpy, spheroseg
from spheroseg.api import TETRAHEDRON

def call(thread_count):
    if thread_count >= 0:
        spheroseg.segment(*TETRAHEDRON, 2, thread_count=thread_count)

call(int(sys.argv[1]))
child = os.fork()
if child == 0:
    signal.alarm(20)
    try:
        call(int(sys.argv[2]))
    except spheroseg.PluginError as error:
        os._exit(3 if "forkserver" in str(error) else 4)
    os._exit(0)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


@pytest.mark.parametrize(
    ("in_parent", "in_child", "code"),
    [(2, 2, 3), (0, 2, 3), (2, 1, 0), (1, 2, 0), (-1, 2, 0)],
)
def test_a_forked_process_does_its_work_or_says_why_not(in_parent, in_child, code):
    done = run_python("-c", FORK, in_parent, in_child)
    assert done.returncode == code, done.stderr


FORK_AFTER_THREADS = """
import os, signal, sys
import numpy, spheroseg
from shapes import bumpy_sphere

vertices, faces = bumpy_sphere(5, 0)  # 20,480 triangles: enough for two threads everywhere
sphere = vertices, faces
count = len(vertices)
pair = numpy.concatenate([vertices, vertices + 3]), numpy.concatenate([faces, faces + count])
FEW = {"max_cohesion_iterations": 1, "max_refinement_iterations": 1}

def call(thread_count):
    def segment(arrays, k=20, **options):
        return spheroseg.segment(*arrays, k, thread_count=thread_count, **options).labels
    labels = segment(sphere)
    segment(sphere, 50, effort="high", max_refinement_iterations=20)
    segment(sphere, method="all_pairs", **FEW)
    segment(sphere, initial_labels=labels)
    segment(sphere, initial_labels=labels, balance="weight")
    segment(pair, initial_labels=segment(pair))

call(2)
child = os.fork()
if child == 0:
    signal.alarm(60)
    call(1)
    os._exit(0)
sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


def test_one_thread_is_one_thread_with_all_options_as_a_fork_shows():
    # OpenMP waits for ever in a forked process as soon as it is asked for a second thread.
    paths = os.pathsep.join([str(REPOSITORY / "python"), str(REPOSITORY / "tests" / "python")])
    done = subprocess.run(
        [sys.executable, "-c", FORK_AFTER_THREADS],
        env={**os.environ, "PYTHONPATH": paths},
    )
    assert done.returncode == 0


def test_a_fork_waits_for_the_filter_of_another_thread(cube):
    with futures.ThreadPoolExecutor(1) as pool:
        other = pool.submit(spheroseg.segment, *bumpy_sphere(5, 0), 200, effort="high")
        while not (is_filter_running() or other.done()):
            time.sleep(0.01)
        assert not other.done()
        child = os.fork()
        if child == 0:
            signal.alarm(20)
            with contextlib.suppress(BaseException):
                segment(cube, 4, thread_count=1)
                os._exit(0)
            os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
        other.result()


DAEMONS = """
import atexit, sys, threading, time
calls = []
# After what the package does then: no filter runs any more.
atexit.register(lambda: print(len(calls), _plugin._one_at_a_time.acquire(timeout=0.5)))
import spheroseg
from processes import is_filter_running
from shapes import bumpy_sphere
from spheroseg import _plugin

arrays = bumpy_sphere(int(sys.argv[1]), 0)

def call():
    while True:
        calls.append(spheroseg.segment(*arrays, 10, effort=sys.argv[2]))

for _ in range(2):
    threading.Thread(target=call, daemon=True).start()
while len(calls) < int(sys.argv[3]) or not is_filter_running():
    time.sleep(0.001)
"""


def finished_calls(program, *case):
    """Of a program that ends well while its daemon threads call filters."""
    done = run_python("-c", program, *case, PYTHONPATH=os.pathsep.join(sys.path))
    assert (done.returncode, done.stderr) == (0, "")
    finished, is_none_running = done.stdout.split()
    assert is_none_running == "True"
    return int(finished)


@pytest.mark.parametrize("case", [(2, "draft", 3), (6, "high", 0)], ids=["short", "long"])
def test_calls_in_daemon_threads_end_with_the_program(case):
    finished = finished_calls(DAEMONS, *case)
    assert finished >= 3 if case[0] == 2 else finished == 0  # the long one, of some 3 s


def test_a_program_with_the_interrupt_ignored_waits_for_calls_in_daemon_threads():
    ignored = "import signal\nsignal.signal(signal.SIGINT, signal.SIG_IGN)\n"
    assert finished_calls(ignored + DAEMONS, 6, "high", 0) <= 1


def test_shortcomings_count_one_and_many():
    found = {
        "max_triangle_count_difference": 3,
        "best_max_triangle_count_difference": 1,
        "may_be_balanced": True,
        "disconnected_submesh_count": 1,
        "bowtie_count": 2,
    }
    assert api.shortcomings(found) == (
        "3 triangles between the largest and the smallest sub-mesh, "
        "1 sub-mesh in more than one piece, 2 bowties"
    )
    found |= {"disconnected_submesh_count": 2, "bowtie_count": 1}
    assert api.shortcomings(found).endswith(", 2 sub-meshes in more than one piece, 1 bowtie")
    best = {"max_triangle_count_difference": 224, "best_max_triangle_count_difference": 224}
    assert api.shortcomings(found | best).startswith(
        "224 triangles between the largest and the smallest sub-mesh, the fewest that its "
        "components allow, 2 sub-meshes"
    )


def test_a_star_of_strips_has_no_halves_and_the_measures_say_so():
    halves = spheroseg.segment(*star_of_strips(600), 2).measures
    assert (halves["min_submesh_triangles"], halves["max_submesh_triangles"]) == (600, 1201)
    assert halves["may_be_balanced"] is False
    assert api.shortcomings(halves) == (
        "601 triangles between the largest and the smallest sub-mesh (no cut into so many "
        "connected ones is balanced, as parts of the mesh hang on the rest by single edges)"
    )
    thirds = spheroseg.segment(*star_of_strips(600), 3).measures
    assert thirds["may_be_balanced"] is True
    assert api.shortcomings(thirds) == ""


def test_area_distortion_does_not_depend_on_the_unit(cube):
    vertices, faces = cube
    expected = spheroseg.parametrize(vertices, faces).measures["area_distortion_max"]
    for scale in (1e200, 1e-200):
        measures = spheroseg.parametrize(vertices * scale, faces).measures
        assert measures["area_distortion_max"] == pytest.approx(expected)
    assert spheroseg.parametrize(vertices * 0, faces).measures["area_distortion_max"] == 0


def test_no_faces_are_an_input_error():
    nothing = np.zeros((0, 3)), np.zeros((0, 3), int)
    for call in (
        lambda: spheroseg.segment(*nothing, 1),
        lambda: spheroseg.measure(*nothing, []),
        lambda: spheroseg.parametrize(*nothing),
    ):
        with pytest.raises(spheroseg.InputError, match="at least one triangle"):
            call()


def test_numbers_beyond_double_precision_are_refused_without_a_warning(cube):
    vertices, faces = cube
    beyond = np.full(len(vertices), np.finfo(np.longdouble).max)
    with pytest.raises(spheroseg.InputError, match="vertex 0 has x = inf"):
        spheroseg.segment(np.stack([beyond] * 3, axis=1), faces, 2)
    weights = np.full(len(faces), np.finfo(np.longdouble).max)
    with pytest.raises(spheroseg.InputError, match="face 0 with inf"):
        spheroseg.segment(vertices, faces, 2, balance="weight", face_weights=weights)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_vertices_that_no_face_names_need_not_be_finite(sample_arrays, value):
    vertices, faces = sample_arrays["flat_leaf.ply"]
    loose = np.vstack((vertices, [[value, 0, -value]]))
    expected, result = segment((vertices, faces), 5), segment((loose, faces), 5)
    assert np.array_equal(result.labels, expected.labels)
    for labelled in (result.labels, expected.labels):
        assert (
            spheroseg.measure(loose, faces, labelled)["boundary_edge_count"]
            == (expected.measures["boundary_edge_count"])
        )
