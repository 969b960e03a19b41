# SPDX-License-Identifier: GPL-3.0-or-later
"""What holds for every mesh, labelling and option, with inputs that Hypothesis makes up."""

import numpy as np
import pytest
import recount
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from mesh_paths import SAMPLE_FOLDER
from shapes import subdivided_sphere

import spheroseg
from spheroseg import cli, mesh_files
from spheroseg.arrays import as_faces, as_labels, as_mesh
from spheroseg.batch import inputs
from spheroseg.errors import InputError

CUBE = SAMPLE_FOLDER / "cube.obj"


@st.composite
def closed_surfaces(draw):
    """Spheres of 8 to some hundred triangles with random faces split in three, in random order."""
    vertices, faces = subdivided_sphere(draw(st.integers(0, 2)))
    vertices, faces = vertices.tolist(), faces.tolist()
    for pick in draw(st.lists(st.integers(0, 10**6), max_size=40)):
        a, b, c = faces[pick % len(faces)]
        new = len(vertices)
        vertices.append(np.mean([vertices[a], vertices[b], vertices[c]], axis=0).tolist())
        faces[pick % len(faces)] = [a, b, new]
        faces += [[b, c, new], [c, a, new]]
    order = np.random.default_rng(draw(st.integers(0, 99))).permutation(len(faces))
    return np.array(vertices), np.array(faces)[order]


@st.composite
def any_faces(draw):
    """Triangles on few vertices: surfaces of every kind, and mostly none."""
    vertex_count = draw(st.integers(3, 9))
    corner = st.integers(0, vertex_count - 1)
    faces = draw(st.lists(st.tuples(corner, corner, corner), min_size=1, max_size=24))
    grid = np.arange(3 * vertex_count, dtype=float).reshape(-1, 3)
    return np.sin(7 * grid), np.array(faces)


@given(closed_surfaces(), st.data())
def test_every_segmentation_of_a_closed_surface_is_balanced_connected_and_measured_rightly(
    surface, data
):
    vertices, faces = surface
    submesh_count = data.draw(st.integers(1, len(faces)))
    method = data.draw(st.sampled_from(["fast", "fast", "all_pairs"]))
    seed = data.draw(st.integers(0, 2**31 - 1))
    before = vertices.tobytes(), faces.tobytes()
    options = {"method": method, "effort": "draft", "seed": seed}
    result = spheroseg.segment(vertices, faces, submesh_count, thread_count=1, **options)
    assert (vertices.tobytes(), faces.tobytes()) == before
    counts = np.bincount(result.labels, minlength=submesh_count)
    assert counts.size == submesh_count
    assert counts.max() - counts.min() == (len(faces) % submesh_count != 0)
    expected = recount.measures(faces, result.labels)
    for key in expected.keys() - {"submesh_triangles"}:
        assert np.isclose(result.measures[key], expected[key]), key
    if method == "fast":
        assert expected["bowtie_count"] == expected["disconnected_submesh_count"] == 0
    again = spheroseg.segment(vertices, faces, submesh_count, thread_count=2, **options)
    assert np.array_equal(again.labels, result.labels)


@given(any_faces(), st.integers(-1, 30))
def test_any_faces_are_segmented_or_refused_with_a_reason(surface, submesh_count):
    vertices, faces = surface
    try:
        labels = spheroseg.segment(vertices, faces, submesh_count, effort="draft").labels
    except InputError as error:
        assert len(str(error)) > 20  # noqa: PT017
    else:
        assert labels.shape == (len(faces),)
        assert labels.min() >= 0
        assert labels.max() < submesh_count


@given(any_faces(), st.data())
def test_any_labels_are_measured_or_refused_with_a_reason(surface, data):
    vertices, faces = surface
    labels = np.array(
        data.draw(st.lists(st.integers(-1, 5), min_size=len(faces), max_size=len(faces)))
    )
    if labels.min() < 0:
        with pytest.raises(InputError, match="face"):
            spheroseg.measure(vertices, faces, labels)
    else:
        counts = np.bincount(labels)
        measures = spheroseg.measure(vertices, faces, labels)
        assert measures["submesh_triangles"].tolist() == counts.tolist()
        assert measures["max_triangle_count_difference"] == counts.max() - counts.min()


any_array = st.one_of(
    arrays.arrays(
        st.one_of(arrays.scalar_dtypes(), arrays.unicode_string_dtypes()),
        arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4),
    ),
    st.lists(st.lists(st.one_of(st.floats(), st.integers(), st.none(), st.text()))),
    st.none(),
    st.text(),
)


@given(any_array)
def test_whatever_is_given_as_an_array_is_taken_or_refused(value):
    def named_vertices(vertices):
        return as_mesh(vertices, [[0, 1, 2]])[0][:3]

    for check in (named_vertices, lambda v: as_faces(v, 3), lambda v: as_labels(v, 2)):
        try:
            checked = check(value)
        except InputError as error:
            assert str(error)  # noqa: PT017
        else:
            assert np.isfinite(checked).all()


numbers = st.one_of(
    st.integers(-(2**40), 2**40).map(str), st.integers(-2, 14).map(str), st.floats().map(str)
)
words = st.one_of(numbers, st.sampled_from(["", "fast", "all_pairs", "high", "cpu", "cuda", "ä"]))
options = st.sampled_from(
    ["-k", "--triangles-per-submesh", "--method", "--effort", "--device", "--seed", "--threads"]
    + ["--time-limit", "--max-cohesion-iterations", "--max-refinement-iterations", "--json", "-z"]
)


@given(st.lists(st.tuples(options, words), max_size=3))
def test_any_options_of_the_command_line_work_or_cost_one_line(capsys, pairs):
    arguments = [part for pair in pairs for part in pair]
    try:
        code = cli.main(["segment", str(CUBE), "-q", *arguments])
    except SystemExit as stop:
        code = stop.code
    shown = capsys.readouterr()
    assert shown.out == ""
    if code != 0:
        assert code == 2
        assert shown.err.count("\n") == 1
        assert shown.err.startswith("spheroseg")


@given(st.sampled_from(["l.npy", "l.txt"]), st.binary(max_size=300), st.booleans())
def test_any_bytes_are_labels_or_refused(tmp_path_factory, name, content, is_npy):
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(b"\x93NUMPY\x01\x00v\x00" + content if is_npy else content)
    try:
        labels = mesh_files.read_labels(path)
    except InputError as error:
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert isinstance(labels, np.ndarray)


@given(
    st.one_of(
        st.binary(max_size=200), st.text(max_size=100).map(lambda t: ("mesh,k\n" + t).encode())
    )
)
def test_any_bytes_are_a_list_of_meshes_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "list.csv"
    path.write_bytes(content)
    try:
        sources = inputs.collect([str(path)])
    except InputError as error:
        assert str(error)  # noqa: PT017
    else:
        assert all(source.submesh_count is None or source.submesh_count > 0 for source in sources)
