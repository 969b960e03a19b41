# SPDX-License-Identifier: GPL-3.0-or-later
"""What `fast` refuses, through every door: counts, the first index, the filter that mends it."""

from dataclasses import dataclass

import numpy as np
import pymeshlab
import pytest
from host_meshes import SEGMENTATION, document, state
from surfaces import globe, joined, soup, spheres

import spheroseg
from spheroseg import cli
from spheroseg.ply import ply_bytes

VERTICES, FACES = globe(8, 6)  # 80 faces, 42 vertices


@dataclass(frozen=True)
class Refused:
    vertices: np.ndarray
    faces: np.ndarray
    submesh_count: int
    words: tuple[str, ...]
    #: PyMeshLab's name of the filter that the message names, its options, and k after it.
    cure: str = ""
    options: tuple = ()
    submesh_count_after: int = 5


def with_faces(*more):
    return np.concatenate((FACES, np.array(more, dtype=FACES.dtype)))


def with_coordinate(vertex, value):
    changed = VERTICES.copy()
    changed[vertex, 1] = value
    return changed


def fin():
    """A face that stands on the edge between faces 6 and 20, and one on another edge."""
    vertices = np.concatenate((VERTICES, [[0, 0, 3.0], [0, 3.0, 0]]))
    return vertices, with_faces([*FACES[20][:2], 42], [*FACES[51][:2], 43])


def glued_apart():
    """Each face of the globe with corners of its own: a soup until its vertices are merged."""
    corners = FACES.ravel()
    return VERTICES[corners], np.arange(len(corners), dtype=np.int32).reshape(-1, 3)


def with_crumbs():
    return joined([globe(12, 12), *[(v * 0.01, f) for v, f in [soup(4)]]])


REFUSED = {
    "an edge with three faces": Refused(
        *fin(),
        5,
        ("2 edges with more than two faces", "face 6", "Repair non Manifold Edges"),
        "meshing_repair_non_manifold_edges",
    ),
    "a duplicate face": Refused(
        VERTICES,
        with_faces(FACES[7], FACES[9][::-1]),
        5,
        ("2 faces with the same vertices", "face 80", "Remove Duplicate Faces"),
        "meshing_remove_duplicate_faces",
    ),
    "a face that names a vertex twice": Refused(
        VERTICES,
        with_faces([3, 3, 5], [4, 9, 4], [2, 2, 2]),
        5,
        ("3 faces that name a vertex twice", "face 80", "Remove Zero Area Faces"),
        "meshing_remove_null_faces",
    ),
    "a NaN coordinate": Refused(
        with_coordinate(6, np.nan), FACES, 5, ("1 vertex with a NaN or infinite", "vertex 6")
    ),
    "an infinite coordinate": Refused(
        with_coordinate(11, -np.inf), FACES, 5, ("1 vertex with a NaN or infinite", "vertex 11")
    ),
    "more components than sub-meshes": Refused(
        *spheres(12), 11, ("12 components", "(11)", "Remove Isolated pieces (wrt Face Num.)")
    ),
    "crumbs": Refused(
        *with_crumbs(),
        3,
        ("5 components", "(3)", "Remove Isolated pieces (wrt Face Num.)"),
        "meshing_remove_connected_component_by_face_number",
        (("mincomponentsize", 10),),
    ),
    "a soup": Refused(
        *glued_apart(),
        5,
        ("triangle soup", "80 faces", "(5)", "Merge Close Vertices"),
        "meshing_merge_close_vertices",
    ),
}


@pytest.mark.parametrize("case", REFUSED.values(), ids=REFUSED)
def test_the_filter_says_what_where_and_what_to_do_and_changes_nothing(case):
    mesh_set = document(case.vertices, case.faces)
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException) as caught:
        mesh_set.apply_filter(SEGMENTATION, submesh_count=case.submesh_count)
    for words in case.words:
        assert words in str(caught.value)
    assert state(mesh_set) == before


@pytest.mark.parametrize("case", REFUSED.values(), ids=REFUSED)
def test_arrays_are_refused_with_the_same_words(case):
    with pytest.raises(spheroseg.InputError) as caught:
        spheroseg.segment(case.vertices, case.faces, case.submesh_count)
    if np.isfinite(case.vertices).all():
        for words in case.words:
            assert words in str(caught.value)
    else:
        assert "finite" in str(caught.value)


@pytest.mark.parametrize("case", REFUSED.values(), ids=REFUSED)
def test_the_command_line_ends_with_2_and_one_line(case, tmp_path, capsys):
    path = tmp_path / "mesh.ply"
    path.write_bytes(ply_bytes(case.vertices, case.faces))
    output = tmp_path / "labels.npy"
    code = cli.main(["segment", str(path), "-k", str(case.submesh_count), "--labels", str(output)])
    shown, errors = capsys.readouterr()
    assert code == 2
    assert errors.count("\n") == 1
    assert "Traceback" not in errors + shown
    assert not output.exists()


@pytest.mark.parametrize(
    "case", [case for case in REFUSED.values() if case.cure], ids=lambda case: case.cure
)
def test_the_named_filter_mends_it(case):
    mesh_set = document(case.vertices, case.faces)
    mesh_set.apply_filter(case.cure, **dict(case.options))
    report = mesh_set.apply_filter(SEGMENTATION, submesh_count=case.submesh_count_after)
    assert report["bowtie_count"] == 0
    assert report["disconnected_submesh_count"] == 0
