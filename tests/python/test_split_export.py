# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import collections
import contextlib
import errno
import itertools
import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from colours import bytes_of_linear
from judge import Judge
from mesh_paths import REPOSITORY
from shapes import bumpy_sphere, octahedron
from surfaces import SURFACES

from spheroseg import atomic
from spheroseg.batch import inputs
from spheroseg.cli import main
from spheroseg.errors import InputError
from spheroseg.export import export, glb_bytes, vertex_normals
from spheroseg.palette import colour_indices, palette
from spheroseg.ply import colour_properties, ply_bytes
from spheroseg.split import write_split
from spheroseg.submeshes import MAX_SHORT_VERTICES, split_into_submeshes

# Bytes of glTF's types: unsigned short, unsigned int, float.
COMPONENT_SIZES = {5123: 2, 5125: 4, 5126: 4}


def sectors(vertices: np.ndarray, faces: np.ndarray, k: int) -> np.ndarray:
    """Labels by longitude: k sub-meshes like slices of an orange."""
    centre = vertices[faces].mean(axis=1)
    turn = np.arctan2(centre[:, 1], centre[:, 0]) / (2 * np.pi) % 1
    return np.minimum((turn * k).astype(int), k - 1)


@pytest.fixture
def labelled():
    vertices, faces = bumpy_sphere(3, 5)
    return vertices, faces, sectors(vertices, faces, 7)


def test_octahedron_halves_by_hand():
    vertices, faces = octahedron()
    submeshes = split_into_submeshes(vertices, faces, [0, 0, 0, 0, 1, 1, 1, 1])
    assert submeshes.vertex_starts.tolist() == [0, 5, 10]
    assert submeshes.source_vertices.tolist() == [0, 1, 2, 3, 4, 0, 1, 2, 3, 5]
    assert submeshes.on_boundary.tolist() == [True] * 4 + [False] + [True] * 4 + [False]
    assert submeshes.triangle_starts.tolist() == [0, 4, 8]
    assert submeshes.triangles[4:].tolist() == [[2, 0, 4], [1, 2, 4], [3, 1, 4], [0, 3, 4]]
    assert submeshes.neighbours.tolist() == [1, 0]
    assert submeshes.shared_edges.tolist() == [4, 4]


def test_blocks_map_back_to_the_mesh(labelled):
    vertices, faces, labels = labelled
    submeshes = split_into_submeshes(vertices, faces, labels)
    assert sorted(submeshes.source_triangles.tolist()) == list(range(len(faces)))
    for submesh in range(submeshes.count):
        positions, triangles = submeshes.block(submesh)
        first = submeshes.vertex_starts[submesh]
        source = submeshes.source_triangles[slice(*submeshes.triangle_starts[submesh:][:2])]
        assert set(labels[source]) == {submesh}
        assert np.array_equal(
            submeshes.source_vertices[first + triangles.astype(int)], faces[source]
        )
        assert np.array_equal(positions[triangles], vertices[faces[source]].astype(np.float32))


def test_adjacency_counts_boundary_edges_of_both_sides(labelled):
    vertices, faces, labels = labelled
    submeshes = split_into_submeshes(vertices, faces, labels)
    edges = {}
    for face, corners in enumerate(faces.tolist()):
        for i in range(3):
            edges.setdefault(frozenset((corners[i], corners[i - 1])), []).append(face)
    expected = np.zeros((7, 7), dtype=int)
    for one, other in edges.values():
        if labels[one] != labels[other]:
            expected[labels[one], labels[other]] += 1
            expected[labels[other], labels[one]] += 1
    found = np.zeros((7, 7), dtype=int)
    owner = np.repeat(np.arange(7), np.diff(submeshes.neighbour_starts))
    found[owner, submeshes.neighbours] = submeshes.shared_edges
    assert found.tolist() == expected.tolist()


def test_empty_submesh_has_an_empty_block():
    vertices, faces = octahedron()
    submeshes = split_into_submeshes(vertices, faces, [0] * 4 + [2] * 4, submesh_count=4)
    assert np.diff(submeshes.triangle_starts).tolist() == [4, 0, 4, 0]
    assert np.diff(submeshes.vertex_starts).tolist() == [5, 0, 5, 0]


@pytest.mark.parametrize("vertex_count", [MAX_SHORT_VERTICES, MAX_SHORT_VERTICES + 1])
def test_indices_are_short_where_they_fit(vertex_count):
    # A fan around vertex 0.
    rim = np.arange(1, vertex_count - 1)
    faces = np.column_stack((np.zeros_like(rim), rim, rim + 1))
    submeshes = split_into_submeshes(np.zeros((vertex_count, 3)), faces, np.zeros(len(faces)))
    assert submeshes.triangles.dtype == (
        np.uint16 if vertex_count <= MAX_SHORT_VERTICES else np.uint32
    )
    assert submeshes.triangles.max() == vertex_count - 1


@pytest.mark.parametrize(
    ("labels", "message"),
    [
        ([0] * 7, "one entry per face: 8, got 7"),
        ([0, 0, 0, -1, 0, 0, 0, 0], "face 3 has -1"),
        ([0, 0.5, 0, 0, 0, 0, 0, 0], r"the entry at \(1,\) is 0.5"),
        ([0, 0, np.nan, 0, 0, 0, 0, 0], r"the entry at \(2,\) is nan"),
        ([0, 0, 0, 0, 2**31, 0, 0, 0], f"face 4 has {2**31}"),
        ([0, 0, 0, 0, 0, 2.0**40, 0, 0], "face 5 has 1099511627776.0"),
    ],
)
def test_wrong_labels_are_named(labels, message):
    with pytest.raises(ValueError, match=message):
        split_into_submeshes(*octahedron(), labels)


def test_labels_that_would_make_millions_of_empty_submeshes_are_refused():
    assert split_into_submeshes(*octahedron(), [0] * 7 + [65535]).count == 65536
    with pytest.raises(InputError, match=r"face 6 has the label 65536.* 65,537 sub-meshes of 8"):
        split_into_submeshes(*octahedron(), [0] * 6 + [65536, 7])


@pytest.mark.parametrize(
    ("faces", "message"),
    [
        ([[0, 1, 2], [0, 1, 3], [1, 0, 4]], "between vertices 0 and 1 has more than two triangles"),
        ([[0, 1, 2], [0, 2, 6]], "face 1 names vertex 6"),
        ([[0, 1, -1]], "face 0 names vertex -1"),
        (np.zeros((0, 3), int), "at least one triangle"),
        ([[0, 1, 2, 3]], r"must have the shape \(F, 3\)"),
    ],
)
def test_wrong_faces_are_named(faces, message):
    with pytest.raises(InputError, match=message):
        split_into_submeshes(octahedron()[0], faces, np.zeros(len(faces), int))


def test_label_beyond_the_given_count_is_named():
    with pytest.raises(ValueError, match=r"in \[0, 2\); face 7 has 2"):
        split_into_submeshes(*octahedron(), [0] * 7 + [2], submesh_count=2)


def test_npz_holds_the_documented_arrays(labelled, tmp_path):
    submeshes = split_into_submeshes(*labelled)
    export(submeshes, tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as stored:
        assert set(stored.files) == set(submeshes.arrays())
        for name, array in submeshes.arrays().items():
            assert stored[name].dtype == array.dtype
            assert np.array_equal(stored[name], array)


# Metres, as in UTM coordinates, where single precision tells apart 0.5.
FAR_AWAY = np.array([448_251.75, 5_411_932.5, 35.0])


@pytest.mark.parametrize("shift", [FAR_AWAY, 1e-3 * FAR_AWAY])
def test_a_mesh_far_from_the_origin_keeps_its_shape(labelled, tmp_path, shift):
    vertices, faces, labels = labelled
    vertices = vertices + shift
    submeshes = split_into_submeshes(vertices, faces, labels)
    assert np.abs(submeshes.positions).max() < 2
    export(submeshes, tmp_path / "out.npz")
    with np.load(tmp_path / "out.npz") as stored:
        positions = stored["positions"] + stored["origin"]
        assert positions == pytest.approx(vertices[stored["source_vertices"]], rel=0, abs=1e-6)


def test_only_a_mesh_far_from_the_origin_gets_another(labelled):
    vertices, faces, labels = labelled
    size = np.ptp(vertices, axis=0).max()
    for far, is_moved in [(15, False), (17, True), (1e300, False)]:
        moved = vertices + [0, 0, far * size]
        assert split_into_submeshes(moved, faces, labels).origin.any() == is_moved
    unnamed = np.vstack([vertices, [[1e9, np.nan, 0]]])
    assert not split_into_submeshes(unnamed, faces, labels).origin.any()


def test_glb_far_from_the_origin_is_where_the_mesh_is(labelled, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("pygltflib")
    vertices, faces, labels = labelled
    export(split_into_submeshes(vertices + FAR_AWAY, faces, labels), tmp_path / "out.glb")
    scene = trimesh.load_scene(tmp_path / "out.glb")
    bounds = np.array([vertices.min(axis=0), vertices.max(axis=0)]) + FAR_AWAY
    assert scene.bounds == pytest.approx(bounds, rel=0, abs=1e-6)


def test_glb_is_read_by_trimesh_with_one_primitive_per_submesh(labelled, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    pytest.importorskip("pygltflib")
    vertices, faces, labels = labelled
    submeshes = split_into_submeshes(vertices, faces, labels)
    export(submeshes, tmp_path / "out.glb")
    scene = trimesh.load_scene(tmp_path / "out.glb")
    assert len(scene.geometry) == 7
    counts = [len(mesh.faces) for mesh in scene.geometry.values()]
    assert counts == np.bincount(labels).tolist()
    area = np.linalg.norm(
        np.cross(*(vertices[faces[:, i]] - vertices[faces[:, 0]] for i in (1, 2))), axis=1
    )
    for label, mesh in enumerate(scene.geometry.values()):
        assert mesh.area == pytest.approx(area[labels == label].sum() / 2, rel=1e-5)


def test_glb_is_drawn_by_vtk_with_all_triangles(labelled, tmp_path):
    pyvista = pytest.importorskip("pyvista")
    pytest.importorskip("pygltflib")
    export(split_into_submeshes(*labelled), tmp_path / "out.glb")
    blocks = pyvista.read(tmp_path / "out.glb")
    assert blocks.combine(merge_points=False).n_cells == len(labelled[1])


def test_glb_header_buffers_and_materials_agree(labelled):
    pytest.importorskip("pygltflib")
    submeshes = split_into_submeshes(*labelled)
    data = glb_bytes(submeshes)
    assert data[:4] == b"glTF"
    assert int.from_bytes(data[8:12], "little") == len(data)
    json_length = int.from_bytes(data[12:16], "little")
    document = json.loads(data[20 : 20 + json_length])
    assert (
        int.from_bytes(data[20 + json_length :][:4], "little")
        >= (document["buffers"][0]["byteLength"])
    )
    width = {"SCALAR": 1, "VEC3": 3}
    ends = [0] * len(document["bufferViews"])
    for accessor in document["accessors"]:
        assert accessor["byteOffset"] == ends[accessor["bufferView"]]
        size = COMPONENT_SIZES[accessor["componentType"]] * width[accessor["type"]]
        assert document["bufferViews"][accessor["bufferView"]].get("byteStride", size) == size
        ends[accessor["bufferView"]] += size * accessor["count"]
    assert [view["byteLength"] for view in document["bufferViews"]] == ends
    primitives = document["meshes"][0]["primitives"]
    assert [p["extras"]["submesh"] for p in primitives] == list(range(7))
    for submesh, primitive in enumerate(primitives):
        around = submeshes.neighbours[slice(*submeshes.neighbour_starts[submesh:][:2])]
        assert primitive["material"] not in {primitives[other]["material"] for other in around}
    assert all(material["doubleSided"] for material in document["materials"])


def test_glb_arrays_are_aligned_to_their_components():
    pytest.importorskip("pygltflib")
    # Odd numbers of triangles have 16-bit indices that end between two floats.
    data = glb_bytes(split_into_submeshes(*octahedron(), [0] * 3 + [1] * 5))
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    accessors = document["accessors"]
    assert [a["count"] for a in accessors if a["type"] == "SCALAR"] == [9, 15]
    for accessor in accessors:
        view = document["bufferViews"][accessor["bufferView"]]
        offset = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        assert offset % COMPONENT_SIZES[accessor["componentType"]] == 0


def glb_colours(data: bytes) -> list[list[int]]:
    """The colour of each primitive, as it is in a PLY file."""
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    linear = [
        material["pbrMetallicRoughness"]["baseColorFactor"][:3]
        for material in document["materials"]
    ]
    colours = bytes_of_linear(linear).tolist()
    return [colours[part["material"]] for part in document["meshes"][0]["primitives"]]


def test_glb_has_the_colours_of_the_faces_where_each_submesh_has_its_own(labelled):
    pytest.importorskip("pygltflib")
    vertices, faces, labels = labelled
    submeshes = split_into_submeshes(vertices, faces, labels)
    colours = np.array([[10 * i, 200, 30] for i in range(7)], dtype=np.uint8)
    assert glb_colours(glb_bytes(submeshes, colours[labels])) == colours.tolist()
    one_face_differs = colours[labels].copy()
    one_face_differs[100] = 0
    own = glb_colours(glb_bytes(submeshes))
    assert glb_colours(glb_bytes(submeshes, one_face_differs)) == own
    assert glb_colours(glb_bytes(submeshes, np.full_like(one_face_differs, 200))) == own


def test_glb_gives_every_shade_back(labelled):
    pytest.importorskip("pygltflib")
    vertices, faces, _ = labelled
    labels = np.arange(len(faces)) % 256
    shades = np.repeat(np.arange(256, dtype=np.uint8)[:, None], 3, axis=1)
    shades[:, 2] = 255 - shades[:, 2]
    submeshes = split_into_submeshes(vertices, faces, labels)
    assert glb_colours(glb_bytes(submeshes, shades[labels])) == shades.tolist()


def test_export_command_keeps_the_colours_of_the_filter(labelled_files, monkeypatch):
    pytest.importorskip("pygltflib")
    monkeypatch.chdir(labelled_files)
    assert main(["segment", "bare.ply", "-k", "6", "-o", "painted.ply", "-q"]) == 0
    assert main(["export", "painted.ply", "-o", "painted.glb"]) == 0
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh("painted.ply")
    mesh = meshes.current_mesh()
    labels = mesh.face_scalar_array().astype(int)
    painted = np.round(255 * mesh.face_color_matrix()[:, :3]).astype(int)
    first = [int(np.argmax(labels == label)) for label in range(6)]
    assert glb_colours(Path("painted.glb").read_bytes()) == painted[first].tolist()


def test_glb_leaves_out_an_empty_submesh():
    pytest.importorskip("pygltflib")
    vertices, faces = octahedron()
    data = glb_bytes(split_into_submeshes(vertices, faces, [0] * 4 + [2] * 4))
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    assert [p["extras"]["submesh"] for p in document["meshes"][0]["primitives"]] == [0, 2]


def test_glb_keeps_the_colours_where_the_last_submesh_is_empty():
    pytest.importorskip("pygltflib")
    vertices, faces = octahedron()
    labels = np.array([0] * 4 + [1] * 4)
    colours = np.array([[10, 200, 30], [40, 50, 60]], dtype=np.uint8)
    submeshes = split_into_submeshes(vertices, faces, labels, 3)
    assert glb_colours(glb_bytes(submeshes, colours[labels])) == colours.tolist()


def test_normals_point_outwards_and_survive_a_degenerate_triangle():
    vertices, faces = octahedron()
    assert vertex_normals(vertices, faces) == pytest.approx(vertices)
    flat = vertex_normals(np.zeros((3, 3)), np.array([[0, 1, 2]]))
    assert flat.tolist() == [[0, 0, 1]] * 3


def test_export_refuses_another_suffix(labelled, tmp_path):
    with pytest.raises(ValueError, match=r"must end in one of \.npz, \.glb"):
        export(split_into_submeshes(*labelled), tmp_path / "out.stl")


@pytest.mark.parametrize("name", ["o.npz", "o.glb"])
def test_coordinates_too_large_for_an_export_are_refused(name, tmp_path):
    vertices, faces = octahedron()
    vertices = vertices * 1e38
    export(split_into_submeshes(vertices, faces, [0] * 8), tmp_path / name)
    vertices[5] *= 10
    large = split_into_submeshes(vertices, faces, [0] * 8)
    with pytest.raises(InputError, match=r"vertex 5 has a coordinate beyond 3\.4e\+38"):
        export(large, tmp_path / name)
    manifest = write_split(large, vertices, tmp_path / "parts", "source.ply")
    part = pymeshlab.MeshSet()
    part.load_new_mesh(str(next(manifest.parent.glob("*.ply"))))
    assert np.abs(part.current_mesh().vertex_matrix()).max() == 1e39


def test_split_files_give_back_the_mesh(labelled, tmp_path):
    vertices, faces, labels = labelled
    colours = palette(7)[labels]
    path = write_split(
        split_into_submeshes(*labelled), vertices, tmp_path / "parts", "source.ply", colours
    )
    manifest = json.loads(path.read_text())
    assert manifest["source"] == "source.ply"
    assert manifest["submesh_count"] == 7
    total = 0
    for entry in manifest["submeshes"]:
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(tmp_path / "parts" / entry["file"]))
        mesh = meshes.current_mesh()
        assert mesh.face_number() == entry["triangle_count"]
        assert mesh.vertex_number() == entry["vertex_count"]
        assert set(mesh.face_scalar_array()) == {float(entry["submesh"])}
        inside = vertices[faces[labels == entry["submesh"]]]
        assert np.array_equal(mesh.vertex_matrix()[mesh.face_matrix()], inside)
        expected = np.column_stack(
            (colours[labels == entry["submesh"]] / 255.0, np.ones(len(inside)))
        )
        assert mesh.face_color_matrix() == pytest.approx(expected)
        total += mesh.face_number()
    assert total == len(faces)


def test_split_and_batch_keep_the_colours_of_vertices(labelled, tmp_path):
    vertices, faces, _ = labelled
    colours = np.random.default_rng(4).integers(0, 256, (len(vertices), 4), dtype=np.uint8)
    mesh = tmp_path / "mesh.ply"
    mesh.write_bytes(ply_bytes(vertices, faces, colour_properties(colours)))
    of_place = dict(zip(map(tuple, vertices.tolist()), colours.tolist(), strict=True))
    assert main(["split", str(mesh), "-k", "3", "-o", str(tmp_path / "parts")]) == 0
    assert main(["batch", str(mesh), "-k", "3", "-o", str(tmp_path / "out")]) == 0
    written = [*(tmp_path / "parts").glob("*.ply"), tmp_path / "out" / "mesh.ply"]
    assert len(written) == 4
    for path in written:
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(path))
        found = np.round(255 * meshes.current_mesh().vertex_color_matrix()).tolist()
        places = map(tuple, meshes.current_mesh().vertex_matrix().tolist())
        assert found == [of_place[place] for place in places]


def test_split_writes_the_source_indices(labelled, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    vertices, faces, labels = labelled
    write_split(split_into_submeshes(*labelled), vertices, tmp_path, "source.ply")
    mesh = trimesh.load_mesh(tmp_path / "submesh_0002.ply", process=False)
    columns = mesh.metadata["_ply_raw"]
    source_vertex = columns["vertex"]["data"]["source_vertex"]
    source_face = columns["face"]["data"]["source_face"]
    assert np.array_equal(vertices[source_vertex], mesh.vertices)
    assert np.array_equal(source_face, np.flatnonzero(labels == 2))
    assert np.array_equal(source_vertex[mesh.faces], faces[source_face])


def test_split_of_an_empty_submesh_says_null(tmp_path):
    vertices, faces = octahedron()
    submeshes = split_into_submeshes(vertices, faces, [0] * 4 + [2] * 3 + [3])
    path = write_split(submeshes, vertices, tmp_path, "octahedron")
    entries = json.loads(path.read_text())["submeshes"]
    files = [entry["file"] for entry in entries]
    assert files == ["submesh_0000.ply", None, "submesh_0002.ply", "submesh_0003.ply"]
    assert [entry["triangle_count"] for entry in entries] == [4, 0, 3, 1]
    assert sorted(p.name for p in tmp_path.glob("*.ply")) == list(filter(None, files))


@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
@pytest.mark.parametrize("name", ["there", "new/parts"])
def test_a_split_that_fails_leaves_only_what_was_there(
    labelled, tmp_path, monkeypatch, name, error
):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "submesh_0000.ply").touch()
    (tmp_path / "there" / "notes.txt").touch()
    before = sorted(tmp_path.rglob("*"))
    folder = tmp_path / name
    write = atomic.write_bytes

    def fail_at_the_manifest(path, data):
        if path.name == "manifest.json":
            assert len(list(folder.glob("*.ply"))) == 7
            raise error
        write(path, data)

    monkeypatch.setattr(atomic, "write_bytes", fail_at_the_manifest)
    with pytest.raises(error):
        write_split(split_into_submeshes(*labelled), labelled[0], folder, "source.ply")
    assert sorted(tmp_path.rglob("*")) == before


def interrupted_at(line, call):
    """Calls it, with a KeyboardInterrupt at the n-th line that Python runs meanwhile, and returns
    that; None where there are fewer."""
    lines = itertools.count(1)
    before = sys.gettrace()

    def trace(_frame, event, _argument):
        if event == "line" and next(lines) == line:
            sys.settrace(before)
            raise KeyboardInterrupt
        return trace

    sys.settrace(trace)
    try:
        call()
    except KeyboardInterrupt as interrupt:
        return interrupt
    finally:
        sys.settrace(before)
    return None


def test_files_that_belong_together_are_there_all_or_not_at_all_after_an_interrupt(tmp_path):
    """At whichever line it comes, those of the library included."""
    folder = tmp_path / "new" / "parts"
    outcomes = collections.Counter()

    def write_both():
        with atomic.all_or_none(folder) as write:
            write("first", b"1")
            write("second", b"2")

    # Its traceback keeps what was interrupted alive, as it does until the program has said so.
    for line in itertools.count(1):
        interrupt = interrupted_at(line, write_both)
        outcomes[tuple(sorted(path.name for path in tmp_path.rglob("*")))] += 1
        shutil.rmtree(tmp_path / "new", ignore_errors=True)
        if interrupt is None:
            break
    assert line > 100
    assert outcomes.keys() == {(), ("first", "new", "parts", "second")}
    assert outcomes[()] > line / 2


def test_ply_keeps_doubles_that_floats_would_lose():
    vertices, faces = octahedron()
    assert b"property float x" in ply_bytes(vertices, faces)
    assert b"property double x" in ply_bytes(vertices + 1e-12, faces)


@pytest.mark.parametrize(
    ("property_array", "message"),
    [(np.zeros(8, dtype=np.int64), "type int64"), (np.zeros(7, dtype=np.int32), "8 entries")],
)
def test_ply_refuses_a_property_that_does_not_fit(property_array, message):
    with pytest.raises(ValueError, match=message):
        ply_bytes(*octahedron(), face_properties={"extra": property_array})


def test_palette_has_no_red_and_no_repeats():
    colours = palette(36)
    assert len({tuple(c) for c in colours.tolist()}) == 36
    assert not np.any((colours[:, 0] > 150) & (colours[:, 1] < 90) & (colours[:, 2] < 90))
    assert colour_properties(colours)["alpha"].tolist() == [255] * 36


def test_neighbouring_submeshes_differ_in_colour_on_random_labels():
    vertices, faces = bumpy_sphere(3, 0)
    labels = np.random.default_rng(0).integers(0, 30, size=len(faces))
    submeshes = split_into_submeshes(vertices, faces, labels, submesh_count=30)
    colours = colour_indices(30, submeshes.neighbour_starts, submeshes.neighbours)
    owner = np.repeat(np.arange(30), np.diff(submeshes.neighbour_starts))
    assert np.all(colours[owner] != colours[submeshes.neighbours])
    assert colours.min() == 0


def interrupted_write(target):
    with atomic.atomic_path(target) as temporary:
        temporary.write_text("new")
        raise RuntimeError("halfway")


def test_failed_write_leaves_the_old_file_and_no_temporary(tmp_path):
    target = tmp_path / "result.txt"
    atomic.write_text(target, "old")
    with pytest.raises(RuntimeError, match="halfway"):
        interrupted_write(target)
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["result.txt"]


def test_a_file_is_on_the_disk_before_it_takes_its_place(tmp_path, monkeypatch):
    path = tmp_path / "result.txt"
    synced = []
    monkeypatch.setattr(
        os, "fsync", lambda number: synced.append((os.fstat(number).st_size, path.exists()))
    )
    atomic.write_text(path, "whole")
    assert synced == [(5, False)]


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_full_disk_is_said_with_the_file(tmp_path, number):
    with (
        pytest.raises(atomic.DiskFullError, match=r"no room left on the disk for .*result\.ply"),
        atomic.atomic_path(tmp_path / "result.ply"),
    ):
        raise OSError(number, os.strerror(number))


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path):
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "result.txt").write_text("old")
    (tmp_path / "link.txt").symlink_to(tmp_path / "far" / "result.txt")
    atomic.write_text(tmp_path / "link.txt", "new")
    assert (tmp_path / "link.txt").is_symlink()
    assert (tmp_path / "far" / "result.txt").read_text() == "new"


def test_nobody_else_may_read_what_is_about_to_replace_a_file(tmp_path):
    (tmp_path / "secret").touch(0o600)
    with atomic.atomic_path(tmp_path / "secret") as temporary:
        temporary.write_text("new")
        assert temporary.stat().st_mode & 0o777 == 0o600


def test_an_error_names_the_file_that_was_wanted(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        atomic.write_text(tmp_path / "none" / "result.txt", "")
    assert caught.value.filename == str(tmp_path / "none" / "result.txt")


def test_an_error_of_a_file_system_that_is_read_only_names_it_too(tmp_path, monkeypatch):
    def refuse(self, *_, **__):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(self))

    monkeypatch.setattr(Path, "write_bytes", refuse)
    monkeypatch.setattr(Path, "unlink", refuse)  # as Linux does, even of what is not there
    with pytest.raises(OSError, match="Read-only") as caught:
        atomic.write_text(tmp_path / "result.txt", "")
    assert caught.value.filename == str(tmp_path / "result.txt")


@contextlib.contextmanager
def killed_while_it_writes(folder):
    """After a process was killed that wrote `folder/mesh.ply`; nobody has asked about it yet."""
    script = "import os, sys\nfrom spheroseg import atomic\n"
    script += "with atomic.atomic_path(sys.argv[1]) as temporary:\n"
    script += "    temporary.write_text('half')\n    os.kill(os.getpid(), 9)\n"
    environment = dict(os.environ, PYTHONPATH=str(REPOSITORY / "python"))
    command = [sys.executable, "-c", script, str(folder / "mesh.ply")]
    with subprocess.Popen(command, env=environment) as process:
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
        yield


def test_leftovers_of_a_killed_run_are_removed(tmp_path):
    (tmp_path / "deep").mkdir()
    (tmp_path / "mesh.ply").write_text("whole")
    with killed_while_it_writes(tmp_path / "deep"):
        assert len(list((tmp_path / "deep").iterdir())) == 1
        assert atomic.remove_leftovers(tmp_path) == 1
    assert not list((tmp_path / "deep").iterdir())
    assert (tmp_path / "mesh.ply").exists()


def test_what_another_process_is_writing_is_left_alone(tmp_path):
    (tmp_path / "whole.ply").touch()
    with atomic.atomic_path(tmp_path / "mesh.ply", ".ply") as temporary:
        temporary.write_text("half")
        assert atomic.remove_leftovers(tmp_path) == 0
        assert [source.name for source in inputs.collect([str(tmp_path)])] == ["whole"]
    assert (tmp_path / "mesh.ply").read_text() == "half"


def test_what_another_machine_is_writing_is_left_alone_for_a_day(tmp_path):
    part = tmp_path / f".mesh.ply.123@another.host{atomic.TEMPORARY_SUFFIX}"
    part.touch()
    assert atomic.remove_leftovers(tmp_path) == 0
    day_ago = time.time() - 24 * 3600 - 60
    os.utime(part, (day_ago, day_ago))
    assert atomic.remove_leftovers(tmp_path) == 1


@pytest.fixture
def labelled_files(labelled, tmp_path):
    vertices, faces, labels = labelled
    (tmp_path / "bare.ply").write_bytes(ply_bytes(vertices, faces))
    quality = {"quality": labels.astype(np.float32)}
    (tmp_path / "own.ply").write_bytes(ply_bytes(vertices, faces, face_properties=quality))
    np.save(tmp_path / "labels.npy", labels)
    whole = {"quality": labels.astype(np.int32)}
    (tmp_path / "int.ply").write_bytes(ply_bytes(vertices, faces, face_properties=whole))
    half = {"quality": np.full(len(faces), 0.5, dtype=np.float32)}
    (tmp_path / "half.ply").write_bytes(ply_bytes(vertices, faces, face_properties=half))
    vertices, faces = octahedron()
    finned = np.vstack([vertices, [[3.0, 3.0, 3.0]]]), np.vstack([faces, [[*faces[0][:2], 6]]])
    (tmp_path / "fin.ply").write_bytes(ply_bytes(*finned))
    np.savetxt(tmp_path / "labels9.txt", np.arange(9) // 5, fmt="%d")
    return tmp_path


@pytest.mark.parametrize("source", [["own.ply"], ["bare.ply", "--labels", "labels.npy"]])
def test_export_command_reads_labels_of_the_mesh_or_of_a_file(
    source, labelled, labelled_files, monkeypatch
):
    monkeypatch.chdir(labelled_files)
    assert main(["export", *source, "-o", "out.npz"]) == 0
    expected = split_into_submeshes(*labelled)
    with np.load("out.npz") as stored:
        assert np.array_equal(stored["triangles"], expected.triangles)
        assert np.array_equal(stored["positions"], expected.positions)


def test_glb_without_its_package_is_refused_in_one_line(labelled_files, monkeypatch, capsys):
    monkeypatch.chdir(labelled_files)
    monkeypatch.setitem(sys.modules, "pygltflib", None)
    assert main(["export", "bare.ply", "-k", "0", "-o", "o.glb"]) == 2  # before the bad k
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "needs the package 'pygltflib'" in said
    assert "pip install pygltflib'" in said
    with pytest.raises(ImportError, match="pygltflib"):
        glb_bytes(split_into_submeshes(*octahedron(), [0] * 8))


def test_split_command_segments_a_bare_mesh(labelled_files, monkeypatch):
    monkeypatch.chdir(labelled_files)
    assert main(["split", "bare.ply", "-k", "6", "-o", "parts"]) == 0
    manifest = json.loads((labelled_files / "parts" / "manifest.json").read_text())
    counts = [entry["triangle_count"] for entry in manifest["submeshes"]]
    assert sorted(counts) == [85, 85, 85, 85, 86, 86]  # 512 = 4 * 85 + 2 * 86


def test_export_command_segments_a_labelled_mesh_anew_when_asked(labelled_files, monkeypatch):
    monkeypatch.chdir(labelled_files)
    for options, count in (([], 7), (["-k", "9", "--seed", "3"], 9)):
        assert main(["export", "own.ply", *options, "-o", "o.npz"]) == 0
        with np.load("o.npz") as stored:
            assert len(stored["triangle_starts"]) == count + 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["export", "bare.ply", "-o", "o.npz"], "bare.ply has no labels"),
        (["export", "int.ply", "-o", "o.npz"], "a property 'quality' of the type float or double"),
        (["measure", "int.ply"], "a property 'quality' of the type float or double"),
        (["export", "own.ply", "-o", "o.stl"], "must end in .npz or .glb"),
        (["export", "bare.ply", "--labels", "labels.npy", "-k", "2", "-o", "o.npz"], "--labels"),
        (["split", "own.ply", "-o", "."], "must be a new or an empty folder"),
        (["split", "gone.ply", "-o", "parts"], "gone.ply: no such file"),
        (["split", "fin.ply", "--labels", "labels9.txt", "-o", "p"], "fin.ply: the edge between"),
        (["split", "own.ply", "--labels", "labels9.txt", "-o", "p"], "labels9.txt: labels must"),
        (["measure", "own.ply", "--labels", "labels9.txt"], "labels9.txt: labels must have one"),
        (["export", "half.ply", "-o", "o.npz"], "half.ply: labels must be whole numbers"),
        (["export", "own.ply", "--threads", "1", "-o", "o.npz"], "own.ply has labels, which --th"),
        (["split", "own.ply", "--seed", "3", "-o", "parts"], "segment the mesh anew with -k N"),
    ],
)
def test_commands_refuse_in_one_line(arguments, message, labelled_files, monkeypatch, capsys):
    monkeypatch.chdir(labelled_files)
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("name", SURFACES)
def test_any_surface_can_be_split_and_exported(tmp_path, name):
    vertices, faces = SURFACES[name].make()
    labels = np.arange(len(faces)) * 9 // len(faces)
    submeshes = split_into_submeshes(vertices, faces, labels)
    write_split(submeshes, vertices, tmp_path, name)
    assert len(list(tmp_path.glob("*.ply"))) == 9
    export(submeshes, tmp_path / "all.glb")
    judge = Judge(faces)
    assert submeshes.shared_edges.sum() == 2 * judge.judge(labels, 9).boundary_edge_count
