# SPDX-License-Identifier: GPL-3.0-or-later
"""The filter that makes a layer for each sub-mesh."""

import shutil
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from host_meshes import (
    PARAMETRIZATION,
    SEGMENTATION,
    document,
    ellipsoid,
    labels_of,
    mesh_count,
    require_attributes_from_python,
    state,
)
from shapes import bumpy_sphere, octahedron

LAYERS = "generate_submesh_layers"


def labelled(labels, vertices=None, faces=None, **attributes):
    if vertices is None:
        vertices, faces = octahedron()
    mesh_set = pymeshlab.MeshSet()
    scalars = np.asarray(labels, float)
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces, f_scalar_array=scalars, **attributes))
    return mesh_set


def layers(mesh_set):
    """The meshes after the first."""
    return [mesh_set.mesh(index) for index in range(1, mesh_count(mesh_set))]


def test_is_a_method_that_returns_the_number_of_layers():
    mesh_set = labelled([0, 0, 0, 0, 1, 1, 1, 1])
    assert mesh_set.generate_submesh_layers() == {"layer_count": 2}


def test_halves_of_an_octahedron_by_hand():
    mesh_set = labelled([0, 0, 0, 0, 1, 1, 1, 1])
    mesh_set.apply_filter(LAYERS)
    upper, lower = layers(mesh_set)
    assert upper.vertex_custom_scalar_attribute_array("source_vertex").tolist() == [0, 1, 2, 3, 4]
    assert lower.vertex_custom_scalar_attribute_array("source_vertex").tolist() == [0, 1, 2, 3, 5]
    assert lower.face_custom_scalar_attribute_array("source_face").tolist() == [4, 5, 6, 7]
    assert lower.face_matrix().tolist() == [[2, 0, 4], [1, 2, 4], [3, 1, 4], [0, 3, 4]]
    assert upper.bounding_box().min().tolist() == [-1, -1, 0]


def test_layers_of_a_segmentation_put_the_mesh_together_again():
    mesh_set = ellipsoid()
    mesh_set.apply_filter(SEGMENTATION, submesh_count=9)
    source = mesh_set.current_mesh()
    vertices, faces, labels = source.vertex_matrix(), source.face_matrix(), labels_of(mesh_set)
    colors = source.face_color_matrix()
    mesh_set.apply_filter(LAYERS)
    assert mesh_count(mesh_set) == 10
    seen = []
    for label, layer in enumerate(layers(mesh_set)):
        source_vertex = layer.vertex_custom_scalar_attribute_array("source_vertex").astype(int)
        source_face = layer.face_custom_scalar_attribute_array("source_face").astype(int)
        assert np.array_equal(source_face, np.flatnonzero(labels == label))
        assert np.array_equal(source_vertex[layer.face_matrix()], faces[source_face])
        assert np.array_equal(source_vertex, np.unique(faces[source_face]))
        assert np.array_equal(layer.vertex_matrix(), vertices[source_vertex])
        assert np.array_equal(layer.face_color_matrix(), colors[source_face])
        assert set(layer.face_scalar_array()) == {float(label)}
        seen += source_face.tolist()
    assert sorted(seen) == list(range(len(faces)))


def test_attributes_of_vertices_and_faces_are_kept():
    require_attributes_from_python()
    vertices, faces = bumpy_sphere(2, 0)
    generator = np.random.default_rng(0)
    labels = generator.integers(0, 5, size=len(faces))
    mesh_set = labelled(
        labels,
        vertices,
        faces,
        v_color_matrix=generator.integers(0, 256, size=(len(vertices), 4)) / 255,
        v_scalar_array=generator.random(len(vertices)),
        v_normals_matrix=generator.random((len(vertices), 3)),
        v_tex_coords_matrix=generator.random((len(vertices), 2)),
        w_tex_coords_matrix=generator.random((3 * len(faces), 2)),
    )
    source = mesh_set.current_mesh()
    source.add_vertex_custom_scalar_attribute(generator.random(len(vertices)), "warmth")
    source.add_vertex_custom_point_attribute(generator.random((len(vertices), 3)), "flow")
    source.add_face_custom_scalar_attribute(generator.random(len(faces)), "age")
    source.add_face_custom_point_attribute(generator.random((len(faces), 3)), "wind")

    def per_vertex(mesh):
        return [
            mesh.vertex_color_matrix(),
            mesh.vertex_scalar_array(),
            mesh.vertex_normal_matrix(),
            mesh.vertex_tex_coord_matrix(),
            mesh.vertex_custom_scalar_attribute_array("warmth"),
            mesh.vertex_custom_point_attribute_matrix("flow"),
        ]

    def per_face(mesh):
        return [
            mesh.wedge_tex_coord_matrix().reshape(-1, 6),
            mesh.face_custom_scalar_attribute_array("age"),
            mesh.face_custom_point_attribute_matrix("wind"),
        ]

    of_vertices, of_faces = per_vertex(source), per_face(source)
    mesh_set.apply_filter(LAYERS)
    for layer in layers(mesh_set):
        source_vertex = layer.vertex_custom_scalar_attribute_array("source_vertex").astype(int)
        source_face = layer.face_custom_scalar_attribute_array("source_face").astype(int)
        for kept, original in zip(per_vertex(layer), of_vertices, strict=True):
            assert np.array_equal(kept, original[source_vertex])
        for kept, original in zip(per_face(layer), of_faces, strict=True):
            assert np.array_equal(kept, original[source_face])


def test_textures_of_new_layers_are_saved_with_them(tmp_path):
    vertices, faces = bumpy_sphere(2, 0)
    samples = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
    shutil.copy(samples / "TextureDouble_A.png", tmp_path / "bricks.png")
    (tmp_path / "wall.mtl").write_text("newmtl wall\nmap_Kd bricks.png\n")
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += ["mtllib wall.mtl", "usemtl wall", "vt 0 0", "vt 1 0", "vt 0 1"]
    lines += [f"f {a}/1 {b}/2 {c}/3" for a, b, c in np.asarray(faces) + 1]
    (tmp_path / "sphere.obj").write_text("\n".join(lines))
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(tmp_path / "sphere.obj"))
    mesh_set.apply_filter(SEGMENTATION, submesh_count=2)
    mesh_set.apply_filter(LAYERS)
    mesh_set.apply_filter(PARAMETRIZATION, new_layer=True)
    images = []
    for index in range(4):
        (tmp_path / str(index)).mkdir()
        mesh_set.set_current_mesh(index)
        mesh_set.save_current_mesh(str(tmp_path / str(index) / "layer.obj"))
        images.append((tmp_path / str(index) / "bricks.png").read_bytes())
    assert images == 4 * images[:1]


def test_layers_of_cut_polygons_are_saved_with_all_their_triangles(tmp_path):
    cube = tmp_path / "cube.obj"
    corners = [f"v {i & 1} {i >> 1 & 1} {i >> 2}" for i in range(8)]
    squares = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]
    cube.write_text("\n".join(corners + [f"f {square}" for square in squares]))
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(cube))
    # An odd number of triangles each, so that squares are cut.
    mesh_set.apply_filter(SEGMENTATION, submesh_count=4)
    mesh_set.apply_filter(LAYERS)
    sizes = []
    for index in range(1, 5):
        mesh_set.set_current_mesh(index)
        mesh_set.save_current_mesh(str(tmp_path / "layer.obj"))
        text = (tmp_path / "layer.obj").read_text()
        faces = [line.split()[1:] for line in text.splitlines() if line.startswith("f ")]
        assert all(len(set(face)) == len(face) for face in faces)
        assert sum(len(face) - 2 for face in faces) == 3
        sizes += [len(face) for face in faces]
    # What was not cut is a square still.
    assert set(sizes) == {3, 4}


def test_source_stays_current_and_unchanged():
    mesh_set = ellipsoid()
    mesh_set.apply_filter(SEGMENTATION, submesh_count=4)
    before = state(mesh_set) | {"mesh_count": 5}
    mesh_set.apply_filter(LAYERS)
    assert mesh_set.current_mesh_id() == 0
    assert state(mesh_set) == before


def test_the_place_of_the_mesh_is_kept_but_not_its_selection():
    mesh_set = labelled([0, 0, 0, 0, 1, 1, 1, 1])
    mesh_set.compute_matrix_from_translation(axisx=5, freeze=False)
    mesh_set.set_selection_all()
    mesh_set.apply_filter(LAYERS)
    for layer in layers(mesh_set):
        # what PyMeshLab 2022.2 has, too: its transform_matrix has another name
        moved = layer.transformed_vertex_matrix() - layer.vertex_matrix()
        np.testing.assert_allclose(moved, np.tile([5, 0, 0], (len(moved), 1)), atol=1e-12)
        assert layer.selected_face_number() == 0
        assert layer.selected_vertex_number() == 0


def test_a_label_without_faces_gets_no_layer():
    mesh_set = labelled([0, 0, 0, 0, 7, 7, 7, 7])
    assert mesh_set.apply_filter(LAYERS) == {"layer_count": 2}
    assert [set(layer.face_scalar_array()) for layer in layers(mesh_set)] == [{0.0}, {7.0}]


def test_a_layer_can_be_split_again_and_worked_on():
    mesh_set = labelled([0, 0, 0, 0, 1, 1, 1, 1])
    mesh_set.apply_filter(LAYERS)
    mesh_set.set_current_mesh(1)
    assert mesh_set.apply_filter(LAYERS) == {"layer_count": 1}
    mesh_set.set_current_mesh(3)
    again = mesh_set.current_mesh().vertex_custom_scalar_attribute_array("source_vertex")
    assert again.tolist() == [0, 1, 2, 3, 4]
    border = mesh_set.apply_filter("get_topological_measures")
    assert border["boundary_edges"] == 4


@pytest.mark.parametrize("value", [0.5, -1.0, np.nan])
def test_rejects_a_quality_that_is_no_label(value):
    mesh_set = labelled([0, 0, 0, value, 1, 1, 1, 1])
    before = state(mesh_set)
    with pytest.raises(pymeshlab.PyMeshLabException, match="face 3 has"):
        mesh_set.apply_filter(LAYERS)
    assert state(mesh_set) == before


def test_rejects_a_mesh_without_face_quality():
    mesh_set = document(*octahedron())
    with pytest.raises(pymeshlab.PyMeshLabException, match=r"(?i)quality"):
        mesh_set.apply_filter(LAYERS)
    assert mesh_count(mesh_set) == 1
