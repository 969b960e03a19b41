# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands segment, parametrize and measure, and how the command line reports errors."""

import base64
import contextlib
import errno
import json
import os
import pty
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
import recount
from mesh_paths import PYMESHLAB_MESHES, REPOSITORY, SAMPLE_FOLDER, load_arrays
from processes import environment, run_program, run_python, run_shell
from terminal import read_terminal

import spheroseg
from spheroseg import cli, mesh_files
from spheroseg.commands import measure
from spheroseg.file_checks import checked_counts
from spheroseg.render import write_png

FEW = ["--max-cohesion-iterations", "2", "--max-refinement-iterations", "1"]
LEAF = SAMPLE_FOLDER / "flat_leaf.ply"
CUBE = SAMPLE_FOLDER / "cube.obj"


@pytest.fixture
def run(capsys):
    """Runs the command line in this process: (exit code, stdout, stderr)."""

    def call(*arguments):
        try:
            code = cli.main([str(argument) for argument in arguments])
        except SystemExit as stop:
            code = stop.code
        return code, *capsys.readouterr()

    return call


@pytest.fixture
def star(tmp_path):
    """A triangle with one on each side: of two sub-meshes one has three triangles."""
    path = tmp_path / "star.off"
    places = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n-1 1 0\n1 -1 0\n"
    path.write_text(f"OFF\n6 4 0\n{places}3 0 1 2\n3 1 3 2\n3 0 2 4\n3 0 5 1\n")
    return path


def test_a_result_that_is_not_balanced_is_one_warning(run, star, tmp_path):
    code, _, errors = run("segment", star, "-k", 2, "-q")
    assert (code, errors) == (
        0,
        f"spheroseg segment: warning: the result for {star} has 2 triangles between the largest "
        "and the smallest sub-mesh (no cut into so many connected ones is balanced, as parts of "
        "the mesh hang on the rest by single edges)\n",
    )
    assert run("segment", star, "-k", 4, "-q") == (0, "", "")


def test_a_batch_tells_of_results_that_are_not_balanced_and_of_those_that_can_not_be(
    run, star, tmp_path
):
    beside = tmp_path / "beside.off"  # two triangles, and one: by its components 2 to 1
    places = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n5 5 5\n6 5 5\n5 6 5\n"
    beside.write_text(f"OFF\n7 3 0\n{places}3 0 1 2\n3 1 3 2\n3 4 5 6\n")
    further = tmp_path / "further.off"  # the star, and one triangle: 4 to 1
    text = star.read_text().replace("6 4 0", "9 5 0")
    further.write_text(text.replace("3 0 1 2", "5 5 5\n6 5 5\n5 6 5\n3 0 1 2") + "3 6 7 8\n")
    short = "not balanced within a triangle, in pieces or with bowties"
    pairs = ("-k", 60, "--method", "all_pairs", *FEW)
    for name, meshes, options, told in (
        ("tree", [star], ("-k", 2), f" (1 {short}; 1 of these can not be balanced)"),
        ("even", [star, beside], ("-k", 2), f" (1 {short}; 1 of these can not be balanced)"),
        ("sizes", [star, further], ("-k", 2), f" (2 {short}; 2 of these can not be balanced)"),
        ("pieces", [LEAF], pairs, f" (1 {short})"),
        ("none", [star], ("-k", 4), ""),
    ):
        code, said, _ = run("batch", *meshes, *options, "-o", tmp_path / name)
        done = f"{len(meshes)} of {len(meshes)} meshes done{told}"
        assert (code, said) == (0, f"{done}; {tmp_path / name / 'manifest.csv'}\n")


def test_split_and_export_warn_of_what_the_segmentation_that_they_make_has(run, star, tmp_path):
    for command, output in (("split", tmp_path / "parts"), ("export", tmp_path / "out.npz")):
        code, _, errors = run(command, star, "-k", 2, "-o", output)
        assert (code, errors.count("\n")) == (0, 1)
        warning = f"spheroseg {command}: warning: the result for {star} has 2 triangles between"
        assert errors.startswith(warning)
    assert run("export", star, "-k", 4, "-o", tmp_path / "out.npz")[2] == ""


def test_the_program_writes_what_it_was_asked_for_and_prints_the_measures(tmp_path):
    paths = [tmp_path / name for name in ("out.ply", "labels.txt", "out.json")]
    done = run_program(
        "segment", LEAF, "-k", 30, *FEW, "-o", paths[0], "--labels", paths[1], "--json", paths[2]
    )
    assert done.returncode == 0
    assert done.stderr == ""
    assert "boundary_edge_count" in done.stdout
    assert all(path.stat().st_size > 0 for path in paths)


def test_help_and_manual_tell_of_the_same_exit_codes():
    told = " ".join(cli.build_parser().epilog.rstrip(".").split()).removeprefix("Exit codes: ")
    manual = (REPOSITORY / "docs" / "python.md").read_text().replace("`", "")
    assert [code.split()[0] for code in told.split("; ")] == ["0", "1", "2", "130", "141"]
    assert [code for code in told.split("; ") if code not in " ".join(manual.split())] == []


def test_names_need_no_locale(tmp_path):
    folder = tmp_path / "größe"
    folder.mkdir()
    mesh, result = shutil.copy(CUBE, folder / "é.obj"), folder / "ü.ply"
    done = run_program("segment", mesh, "-k", 2, "-o", result, LC_ALL="C")
    assert (done.returncode, done.stderr) == (0, "")
    done = run_program("batch", folder, "-o", folder / "ö", "-k", 2, LC_ALL="C")
    assert (done.returncode, done.stderr) == (0, "")
    assert {path.name for path in folder.rglob("*.ply")} == {"ü.ply", "é.ply"}


PYMESHLAB_FIRST = """
import locale, pathlib, sys
import pymeshlab
from spheroseg import mesh_files

print(locale.setlocale(locale.LC_CTYPE))
mesh_set = mesh_files.read_mesh(sys.argv[1])
for error, call in (
    (OSError, lambda: mesh_files.save_ply(mesh_set, *sys.argv[2:0:-1])),
    (mesh_files.InputError, lambda: mesh_files.read_mesh(sys.argv[3])),
):
    try:
        call()
    except error as caught:
        print(caught)
"""


def test_names_that_pymeshlab_can_not_find_are_refused_with_what_to_do(tmp_path):
    folder = tmp_path / "größe"
    folder.mkdir()
    mesh = shutil.copy(CUBE, folder)
    done = run_python("-c", PYMESHLAB_FIRST, CUBE, folder / "out.ply", mesh, LC_ALL="C")
    locale, *errors = done.stdout.splitlines()
    assert (locale, len(errors), done.stderr) == ("C", 2, "")
    assert all("set the environment variable LC_ALL=C.UTF-8" in error for error in errors)


def test_names_that_the_output_can_not_show_are_no_failure(tmp_path):
    folder = tmp_path / "größe☃"
    done = run_program("split", CUBE, "-k", 2, "-o", folder, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert r"gr\xf6\xdfe\u2603" in done.stdout
    assert folder.is_dir()


def test_mesh_labels_and_json_agree_and_keep_the_files_order(run, tmp_path):
    out, labels_path, json_path = (tmp_path / name for name in ("o.ply", "l.npy", "m.json"))
    code, shown, errors = run(
        "segment", LEAF, "-k", "37", *FEW, "-o", out, "--labels", labels_path, "--json", json_path
    )
    assert (code, errors) == (0, "")
    labels = np.load(labels_path)
    assert labels.dtype == np.int32
    vertices, faces = load_arrays(LEAF)
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(out))
    mesh = mesh_set.current_mesh()
    assert np.array_equal(mesh.face_matrix(), faces)
    assert np.array_equal(mesh.vertex_matrix(), vertices)
    assert np.array_equal(mesh.face_scalar_array(), labels)
    colours = mesh.face_color_matrix()
    assert len(np.unique(colours, axis=0)) > 3
    report = json.loads(json_path.read_text())
    expected = recount.measures(faces, labels)
    for key in expected.keys() - {"submesh_triangles"}:
        assert np.isclose(report[key], expected[key]), key
    assert report["mesh"] == str(LEAF)
    iterations = report["cohesion_iterations"] + report["refinement_iterations"]
    assert len(report["energy_by_iteration"]) == iterations
    assert str(report["boundary_edge_count"]) in shown


def test_the_table_shows_every_measure_that_is_one_value(run, tmp_path):
    code, shown, errors = run("segment", CUBE, "-k", "5", "--json", tmp_path / "m.json")
    assert (code, errors) == (0, "")
    rows = dict(re.findall(r"^│ (\w+) +│ +(\S+) │$", shown, re.MULTILINE))
    measures = json.loads((tmp_path / "m.json").read_text())
    single = {key for key, value in measures.items() if not isinstance(value, list | str)}
    assert rows.keys() == single
    known = {
        "submesh_count": "5",
        "min_submesh_triangles": "2",
        "may_be_balanced": "yes",
        "time_limit_hit": "no",
        "coefficient_of_variation": "0.204124",  # of 2, 2, 2, 3 and 3
        "weight_imbalance": "1.25",
    }
    assert known.items() <= rows.items()


def test_measure_counts_the_same_from_the_mesh_and_from_either_file_of_labels(run, tmp_path):
    out, text = tmp_path / "o.ply", tmp_path / "l.txt"
    assert run("segment", LEAF, "-k", "9", *FEW, "-o", out, "--labels", text, "-q")[0] == 0
    labels = np.loadtxt(text, dtype=int)
    np.save(tmp_path / "l.npy", labels)
    reports = []
    for arguments in ([out], [LEAF, "--labels", text], [LEAF, "--labels", tmp_path / "l.npy"]):
        path = tmp_path / "m.json"
        assert run("measure", *arguments, "--json", path, "-q") == (0, "", "")
        reports.append(json.loads(path.read_text()))
        del reports[-1]["mesh"]
    assert reports[0] == reports[1] == reports[2]
    expected = recount.measures(load_arrays(LEAF)[1], labels)
    assert reports[0]["boundary_edge_count"] == expected["boundary_edge_count"]
    assert reports[0]["submesh_triangles"] == expected["submesh_triangles"].tolist()
    assert (reports[0]["submesh_count"], reports[0]["triangle_count"]) == (9, len(labels))


def test_parametrize_writes_a_sphere_with_the_same_triangles(run, tmp_path):
    sphere, json_path = tmp_path / "s.ply", tmp_path / "s.json"
    code, _, errors = run("parametrize", LEAF, "-o", sphere, "--json", json_path)
    assert (code, errors) == (0, "")
    positions, faces = load_arrays(sphere)
    assert np.array_equal(faces, load_arrays(LEAF)[1])
    assert np.abs(np.linalg.norm(positions, axis=1) - 1).max() < 1e-12
    assert recount.flipped_triangle_count(positions, faces) == 0
    assert json.loads(json_path.read_text())["flipped_triangle_count"] == 0


@pytest.mark.parametrize("path", PYMESHLAB_MESHES, ids=lambda path: path.name)
def test_segments_the_meshes_that_ship_with_pymeshlab(run, tmp_path, path):
    # One iteration each: all_pairs costs O(F^2) per iteration.
    json_path, labels_path = tmp_path / "m.json", tmp_path / "l.npy"
    few = ["--max-cohesion-iterations", "1", "--max-refinement-iterations", "1"]
    code, _, errors = run(
        "segment", path, "-k", "200", *few, "--json", json_path, "--labels", labels_path
    )
    assert (code, errors) == (0, "")
    report = json.loads(json_path.read_text())
    assert report["max_triangle_count_difference"] <= 1
    assert report["submesh_count"] == 200
    counts = np.bincount(np.load(labels_path))
    assert counts.sum() == checked_counts(path).triangles == report["triangle_count"]
    assert (counts.min(), counts.max()) == (
        report["min_submesh_triangles"],
        report["max_submesh_triangles"],
    )


def test_the_options_of_a_segmentation_reach_it(run, tmp_path):
    vertices, faces = load_arrays(LEAF)
    path = tmp_path / "l.npy"
    others = []
    for options, same in (
        ([], {}),
        (["--seed", "3"], {"seed": 3}),
        (["--effort", "draft"], {"effort": "draft"}),
        (["--balance", "weight"], {"balance": "weight"}),
        (FEW, {"max_cohesion_iterations": 2, "max_refinement_iterations": 1}),
    ):
        code = run("segment", LEAF, "-k", 20, "--labels", path, "--threads", 1, *options)[0]
        assert code == 0
        labels = np.load(path)
        assert np.array_equal(labels, spheroseg.segment(vertices, faces, 20, **same).labels)
        assert not any(np.array_equal(labels, other) for other in others)
        others.append(labels)


@pytest.fixture
def cube_with_lost_vertices(tmp_path):
    """A cube behind two vertices without faces that PyMeshLab leaves out."""
    lines = CUBE.read_text().splitlines(keepends=True)
    lost = ["v nan nan nan\n", "v 0 0 -inf\n"]
    vertices = [line for line in lines if line.startswith("v ")]
    faces = [
        "f " + " ".join(str(int(word) + 2) for word in line.split()[1:]) + "\n"
        for line in lines
        if line.startswith("f ")
    ]
    path = tmp_path / "lost.obj"
    path.write_text("".join(lost + vertices + faces))
    return path


def test_segment_and_parametrize_say_that_vertices_were_lost(
    run, tmp_path, cube_with_lost_vertices
):
    expected, labels = tmp_path / "expected.npy", tmp_path / "labels.npy"
    assert run("segment", CUBE, "-k", 3, "--labels", expected)[0] == 0
    code, _, errors = run("segment", cube_with_lost_vertices, "-k", 3, "--labels", labels)
    assert (code, errors) == (0, "")
    assert np.array_equal(np.load(labels), np.load(expected))
    for command in ("segment", "parametrize"):
        output = tmp_path / f"{command}.ply"
        code, _, errors = run(command, cube_with_lost_vertices, "-o", output)
        assert code == 0
        assert errors.count("\n") == 1
        assert f"{output} is without 2 of the vertices of {cube_with_lost_vertices}" in errors
        assert len(load_arrays(output)[0]) == 8
    assert run("split", tmp_path / "segment.ply", "-o", tmp_path / "parts")[::2] == (0, "")


def test_indices_of_vertices_are_refused_where_they_would_not_be_the_files(
    run, tmp_path, cube_with_lost_vertices
):
    for command, output in (("export", "o.npz"), ("split", "parts")):
        call = (command, cube_with_lost_vertices, "-k", 3, "-o", tmp_path / output)
        code, _, errors = run(*call)
        assert code == 2
        assert errors.count("\n") == 1
        assert "leaves out 2 of its vertices" in errors
        assert not (tmp_path / output).exists()
    batch = ("batch", cube_with_lost_vertices, "-k", 3, "-o", tmp_path / "out", "--formats")
    code, _, errors = run(*batch, "ply,npz")
    assert code == 1
    assert "leaves out 2 of its vertices" in errors
    assert run(*batch, "ply,npy", "--resume")[0] == 0


def test_a_glb_has_no_indices_of_the_file_and_is_written(run, tmp_path, cube_with_lost_vertices):
    pytest.importorskip("pygltflib")
    output = tmp_path / "o.glb"
    assert run("export", cube_with_lost_vertices, "-k", 3, "-o", output)[::2] == (0, "")
    assert output.exists()


def test_vertices_at_one_place_are_not_merged():
    mesh = mesh_files.read_mesh(PYMESHLAB_MESHES[0])
    vertices = mesh.current_mesh().vertex_matrix()
    assert len(vertices) == 2904
    assert len(np.unique(vertices, axis=0)) == 2903


@pytest.mark.parametrize("suffix", ["off", "obj", "ply", "stl"])
def test_every_usual_format_is_read_with_its_triangles_in_order(run, tmp_path, suffix):
    path, labels = tmp_path / f"leaf.{suffix}", tmp_path / "l.npy"
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(LEAF))
    mesh_set.save_current_mesh(str(path))
    assert run("segment", path, "-k", "5", *FEW, "--labels", labels, "-q") == (0, "", "")
    read_vertices, read_faces = load_arrays(path)
    vertices, faces = load_arrays(LEAF)
    assert np.allclose(read_vertices[read_faces], vertices[faces], atol=1e-5)
    assert np.bincount(np.load(labels)).tolist() == [256] * 5


def test_triangles_per_submesh_gives_the_ceiling(run, tmp_path):
    path = tmp_path / "m.json"
    code, *_ = run("segment", LEAF, "--triangles-per-submesh", "300", *FEW, "--json", path)
    assert code == 0
    assert json.loads(path.read_text())["submesh_count"] == 5


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_every_command_has_its_own_help(run, command):
    code, shown, errors = run(command, "--help")
    assert (code, errors) == (0, "")
    assert shown.startswith(f"usage: spheroseg {command}")


def test_the_help_names_every_command(run):
    code, shown, _ = run("--help")
    assert code == 0
    assert all(command in shown for command in cli.COMMANDS)


def test_the_version_is_the_packages(run):
    assert run("--version")[:2] == (0, f"spheroseg {spheroseg.__version__}\n")


def test_the_file_of_labels_has_the_name_that_was_given(run, tmp_path):
    assert run("segment", CUBE, "-k", "2", "--labels", tmp_path / "OUT.NPY", "-q") == (0, "", "")
    assert [path.name for path in tmp_path.iterdir()] == ["OUT.NPY"]
    assert np.bincount(np.load(tmp_path / "OUT.NPY")).tolist() == [6, 6]


def test_outputs_may_have_the_longest_names(run, tmp_path):
    mesh, labels, report = (250 * "n" + suffix for suffix in (".ply", ".npy", ".json"))
    paths = [tmp_path / mesh, "--labels", tmp_path / labels, "--json", tmp_path / report]
    assert run("segment", CUBE, "-k", "2", "-q", "-o", *paths) == (0, "", "")
    assert {path.name for path in tmp_path.iterdir()} == {mesh, labels, report}


@pytest.mark.parametrize(
    ("command", "option", "name"),
    [
        ("segment", "-o", "mesh.ply"),
        ("segment", "-o", "other.ply"),
        ("segment", "--labels", "labels.npy"),
        ("segment", "--labels", "labels.txt"),
        ("segment", "--json", "report.json"),
        ("parametrize", "-o", "mesh.ply"),
    ],
)
def test_a_full_disk_is_an_error_and_spoils_no_file(run, small_disk, command, option, name):
    mesh, output = small_disk / "mesh.ply", small_disk / name
    mesh.write_bytes(LEAF.read_bytes())
    if output != mesh:
        output.write_text("old")
    before = output.read_bytes()
    with contextlib.suppress(OSError), (small_disk / "filler").open("wb", buffering=0) as filler:
        while True:
            filler.write(bytes(4096))
    code, _, errors = run(command, mesh, option, output, "-q")
    assert code == 2
    assert errors.count("\n") == 1
    assert str(output) in errors
    assert "disk" in errors
    assert output.read_bytes() == before
    assert sorted(path.name for path in small_disk.iterdir()) == sorted(
        {"filler", "mesh.ply", name}
    )


def test_a_copy_that_finds_no_room_is_no_damaged_mesh(run, small_disk, tmp_path, monkeypatch):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.create_sphere(subdiv=4)
    mesh_set.save_current_mesh(str(tmp_path / "ball.dae"))
    mesh_set.save_current_mesh(str(tmp_path / "ball.ply"))
    monkeypatch.setattr(tempfile, "tempdir", str(small_disk))
    assert run("segment", tmp_path / "ball.dae", "-k", "2", "-q") == (0, "", "")
    room = (tmp_path / "ball.ply").stat().st_size
    for less in (room // 2, 1):  # MeshLab's writer tells of the first, but not of the second
        (small_disk / "filler").write_bytes(bytes(256 * 1024 - room + less))
        code, _, errors = run("segment", tmp_path / "ball.dae", "-k", "2")
        assert (code, errors.count("\n")) == (2, 1)
        assert errors.startswith(f"spheroseg segment: {tmp_path / 'ball.dae'}: no copy of it")
        assert f" can be written to {small_disk}; is the disk full? " in errors
        assert [path.name for path in small_disk.iterdir()] == ["filler"]


def test_split_on_a_full_disk_leaves_nothing(run, small_disk):
    code, _, errors = run("split", LEAF, "-k", "200", "-o", small_disk / "new" / "parts")
    assert (code, errors.count("\n")) == (2, 1)
    assert errors.endswith(".ply'; make room and run again\n")
    assert list(small_disk.iterdir()) == []


def test_a_mesh_that_is_not_whole_on_the_disk_is_an_error(run, tmp_path, monkeypatch):
    save = pymeshlab.MeshSet.save_current_mesh

    def save_half(mesh_set, path, **options):
        save(mesh_set, path, **options)
        os.truncate(path, os.path.getsize(path) - 1)  # noqa: PTH202

    monkeypatch.setattr(pymeshlab.MeshSet, "save_current_mesh", save_half)
    (tmp_path / "out.ply").write_text("old")
    code, _, errors = run("segment", CUBE, "-k", "2", "-o", tmp_path / "out.ply", "-q")
    assert (code, errors.count("\n")) == (2, 1)
    assert f"{tmp_path / 'out.ply'}: could not be written whole; is the disk full? (" in errors
    assert (tmp_path / "out.ply").read_text() == "old"


@pytest.mark.parametrize("mode", [0o600, 0o664, 0o444])
def test_a_result_has_the_permissions_of_the_file_that_it_replaces(mode, run, tmp_path):
    outputs = [tmp_path / name for name in ("out.ply", "out.npy", "out.json")]
    for path in outputs:
        path.touch(mode)
        path.chmod(mode)
    options = ["-o", outputs[0], "--labels", outputs[1], "--json", outputs[2], "-q"]
    assert run("segment", CUBE, "-k", "2", *options)[0] == 0
    assert [path.stat().st_size > 0 for path in outputs] == [True] * 3
    assert [path.stat().st_mode & 0o777 for path in outputs] == [mode] * 3


def test_a_mesh_may_be_replaced_and_its_texture_stays(run, tmp_path):
    for name in ("bunny10k_textured.obj", "bunny10k_textured.mtl", "TextureDouble_A.png"):
        shutil.copy(PYMESHLAB_MESHES[0].parent / name, tmp_path)
    texture = (tmp_path / "TextureDouble_A.png").read_bytes()
    few = ("-k", "5", "--effort", "draft", "-q")
    assert (
        run("segment", tmp_path / "bunny10k_textured.obj", *few, "-o", tmp_path / "o.ply")[0] == 0
    )
    assert run("segment", tmp_path / "o.ply", *few, "-o", tmp_path / "o.ply")[0] == 0
    assert b"list uchar float texcoord" in (tmp_path / "o.ply").read_bytes()
    assert (tmp_path / "TextureDouble_A.png").read_bytes() == texture
    (tmp_path / "new").mkdir()
    assert run("segment", tmp_path / "o.ply", *few, "-o", tmp_path / "new" / "o.ply")[0] == 0
    names = {path.name for path in (tmp_path / "new").iterdir()}
    assert names == {"o.ply", "TextureDouble_A.png"}


PNG = (PYMESHLAB_MESHES[0].parent / "TextureDouble_A.png").read_bytes()
JPEG = b"\xff\xd8\xff\xe0 an image that PyMeshLab can not decode"


def write_textured_cube(folder, *textures):
    """cube.obj, each of whose first faces has a material of its own."""
    folder.mkdir()
    materials = "".join(f"newmtl m{i}\nmap_Kd {name}\n" for i, name in enumerate(textures))
    (folder / "cube.mtl").write_text(materials)
    text = CUBE.read_text()
    faces = re.findall(r"^f .*\n", text, re.M)
    lines = ["mtllib cube.mtl\n", text.split("f ")[0], "vt 0 0\n", "vt 1 0\n", "vt 0 1\n"]
    for number, face in enumerate(faces):
        if number < len(textures):
            lines.append(f"usemtl m{number}\n")
        corners = [corner.split("/")[0] for corner in face.split()[1:]]
        lines.append("f " + " ".join(f"{v}/{i}" for i, v in enumerate(corners, 1)) + "\n")
    (folder / "cube.obj").write_text("".join(lines))
    return folder / "cube.obj"


WHY_NOT = "are not there, can not be read or are no images"


def named_textures(path):
    return re.findall(r"comment TextureFile (.*)\n", path.read_bytes().decode(errors="replace"))


def test_images_are_copied_as_they_are_whatever_pymeshlab_can_decode(run, tmp_path):
    images = {
        "a.jpg": JPEG,
        "b.png": PNG,
        "sp ace.png": PNG + b" ",
        "../up.png": PNG,
        "../up.jpg": JPEG + b"2",
        "x/a.jpg": JPEG + b"3",
    }
    mesh = write_textured_cube(tmp_path / "in", *images)
    (tmp_path / "in" / "x").mkdir()
    for name, image in images.items():
        (tmp_path / "in" / name).write_bytes(image)
    results = [tmp_path / "out" / "1" / "o.ply", tmp_path / "out" / "2" / "o.ply"]
    names = ["a.jpg", "b.png", "sp ace.png", "up.png", "up.jpg", "a_2.jpg"]
    for source, result in zip([mesh, results[0]], results, strict=True):
        result.parent.mkdir(parents=True)
        for _ in range(2):
            assert run("segment", source, "-k", 2, "-o", result, "-q") == (0, "", "")
        assert named_textures(result) == names
        written = {path.name: path.read_bytes() for path in result.parent.iterdir()}
        assert written.keys() == {"o.ply", *names}
        assert [written[name] for name in names] == list(images.values())
    assert {path.name for path in tmp_path.rglob("*") if path.is_dir()} == {*"12x", "in", "out"}


@pytest.mark.parametrize("names", [["a.png"], ["a.png", "b.png"]])
def test_texture_coordinates_of_vertices_are_kept_with_any_number_of_images(run, tmp_path, names):
    images = "".join(f"comment TextureFile {name}\n" for name in names)
    properties = "".join(f"property float {name}\n" for name in ("x", "y", "z", "s", "t"))
    vertices = [[0, 0, 0, 0, 0.5], [1, 0, 0, 0.25, 1], [0, 1, 0, 1, 0], [0, 0, 1, 0.5, 0]]
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    (tmp_path / "mesh.ply").write_text(
        f"ply\nformat ascii 1.0\n{images}element vertex 4\n{properties}"
        "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
        + "".join(" ".join(map(str, vertex)) + "\n" for vertex in vertices)
        + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
    )
    for name in names:
        (tmp_path / name).write_bytes(PNG)
    mesh = tmp_path / "mesh.ply"
    assert run("segment", mesh, "-k", 2, "-o", tmp_path / "o.ply", "-q") == (0, "", "")
    assert named_textures(tmp_path / "o.ply") == names
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(tmp_path / "o.ply"))
    mesh = mesh_set.current_mesh()
    assert np.array_equal(mesh.vertex_tex_coord_matrix(), np.array(vertices)[:, 3:])
    if len(names) > 1:
        corners = np.array(vertices)[np.ravel(faces), 3:]
        assert np.array_equal(mesh.wedge_tex_coord_matrix(), corners)


def test_no_image_that_is_there_is_replaced(run, tmp_path):
    mesh = write_textured_cube(tmp_path / "in", "a.jpg")
    (tmp_path / "in" / "a.jpg").write_bytes(JPEG)
    (tmp_path / "a.jpg").write_bytes(PNG)
    assert run("segment", mesh, "-k", 2, "-o", tmp_path / "o.ply", "-q") == (0, "", "")
    assert (tmp_path / "a.jpg").read_bytes() == PNG
    assert named_textures(tmp_path / "o.ply") == ["a_2.jpg"]
    assert (tmp_path / "a_2.jpg").read_bytes() == JPEG


def test_control_characters_in_names_do_not_reach_the_terminal(run):
    code, _, error = run("measure", "\x1b[31mred\x9b.ply")
    assert code == 2
    assert "\\x1b[31mred\\x9b.ply" in error
    assert error.strip().isprintable()


def test_images_that_can_not_be_had_are_named_in_one_line(run, tmp_path):
    mesh = write_textured_cube(tmp_path / "in", "no.png", "b.png", "../no.jpg")
    (tmp_path / "in" / "b.png").write_bytes(PNG)
    first, second = tmp_path / "1" / "o.ply", tmp_path / "2" / "o.ply"
    for source, result, left_out in (
        (mesh, first, "no.png, ../no.jpg"),
        (first, second, "no.png, no.jpg"),
    ):
        result.parent.mkdir()
        code, _, errors = run("segment", source, "-k", 2, "-o", result, "-q")
        assert (code, errors.count("\n")) == (0, 1)
        assert errors.endswith(f"{source} that {WHY_NOT}: {left_out}\n")
        assert named_textures(result) == ["no.png", "b.png", "no.jpg"]
        assert {path.name for path in result.parent.iterdir()} == {"o.ply", "b.png"}


def test_an_image_in_the_working_folder_is_none_of_the_mesh(run, tmp_path, monkeypatch):
    mesh = write_textured_cube(tmp_path / "in", "no.png")
    (tmp_path / "no.png").write_bytes(PNG)
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)  # where MeshLab looks for an image first
    code, _, errors = run("segment", mesh, "-k", 2, "-o", "out/o.ply", "-q")
    assert (code, errors.count("\n")) == (0, 1)
    assert errors.endswith(f"{mesh} that {WHY_NOT}: no.png\n")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["o.ply"]


def test_what_is_no_image_stays_where_it_is(run, tmp_path):
    """The mesh may come from somebody who wants to see a file of this machine."""
    (tmp_path / "key").write_text("secret")
    (tmp_path / "key.txt").write_text("secret")
    names = ["../key", str(tmp_path / "key"), "../key.txt", "b.png"]
    mesh = write_textured_cube(tmp_path / "in", *names)
    (tmp_path / "in" / "b.png").write_bytes(PNG)
    first, second = tmp_path / "1" / "o.ply", tmp_path / "2" / "o.ply"
    first.parent.mkdir()
    code, _, errors = run("segment", mesh, "-k", 2, "-o", first, "-q")
    assert (code, errors.count("\n")) == (0, 1)
    assert errors.endswith(f"{mesh} that {WHY_NOT}: {', '.join(names[:3])}\n")
    assert {path.name for path in first.parent.iterdir()} == {"o.ply", "b.png"}
    header = b"comment TextureFile key\n"
    first.write_bytes(first.read_bytes().replace(header, b"comment TextureFile ../key\n", 1))
    second.parent.mkdir()
    code, _, errors = run("segment", first, "-k", 2, "-o", second, "-q")
    assert (code, errors.count("\n")) == (0, 1)
    assert {path.name for path in second.parent.iterdir()} == {"o.ply", "b.png"}


def test_no_placeholder_is_written_for_an_image_of_another_format(run, tmp_path):
    mesh = write_textured_cube(tmp_path / "in", "b.png")
    (tmp_path / "in" / "b.png").write_bytes(PNG)
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(mesh))
    mesh_set.save_current_mesh(str(tmp_path / "in" / "cube.dae"))
    call = ("segment", tmp_path / "in" / "cube.dae", "-k", 2, "-q", "-o")
    for folder in ("1", "2"):
        (tmp_path / folder).mkdir()
    assert run(*call, tmp_path / "1" / "o.ply") == (0, "", "")
    assert {path.name for path in (tmp_path / "1").iterdir()} == {"o.ply", "b.png"}
    (tmp_path / "in" / "b.png").write_bytes(JPEG)
    code, _, errors = run(*call, tmp_path / "2" / "o.ply")
    assert (code, errors.count("\n")) == (0, 1)
    assert {path.name for path in (tmp_path / "2").iterdir()} == {"o.ply"}


def test_the_image_of_a_dae_is_that_beside_it(run, tmp_path, monkeypatch):
    mesh = write_textured_cube(tmp_path / "in", "b.png")
    (tmp_path / "in" / "b.png").write_bytes(PNG)
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(mesh))
    mesh_set.save_current_mesh(str(tmp_path / "in" / "cube.dae"))
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)  # where MeshLab looks for an image first
    write_png(Path("b.png"), np.zeros((2, 2, 3), dtype=np.uint8))
    assert run("segment", "in/cube.dae", "-k", 2, "-q", "-o", "out/o.ply") == (0, "", "")
    Path("b.png").unlink()
    mesh_set.load_new_mesh("out/o.ply")
    assert mesh_set.current_mesh().textures()["b.png"].width() == 512


def write_textured_gltf(path, colour, image_name):
    """A triangle with an image of one grey, in a file of that name or, without one, inside."""
    path.parent.mkdir()
    image = path.parent / (image_name or "inside.png")
    write_png(image, np.full((2, 2, 3), colour, dtype=np.uint8))

    def inside(data, kind="application/octet-stream"):
        return f"data:{kind};base64,{base64.b64encode(data).decode()}"

    data = np.eye(3, dtype="<f4").tobytes()
    accessor = {"bufferView": 0, "componentType": 5126, "count": 3}
    attributes = {"POSITION": 0, "TEXCOORD_0": 1}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": attributes, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": image_name or inside(image.read_bytes(), "image/png")}],
        "accessors": [accessor | {"type": "VEC3"}, accessor | {"type": "VEC2"}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data), "uri": inside(data)}],
    }
    path.write_text(json.dumps(document))
    return path


@pytest.mark.parametrize(
    ("image_name", "written"),
    [(None, ["texture_0.png", "texture_0_2.png"]), ("a.jpg", ["a.png", "a_2.png"])],
)
def test_images_of_gltf_files_become_png_each_its_own(
    run, tmp_path, monkeypatch, image_name, written
):
    monkeypatch.chdir(tmp_path)  # where MeshLab looks for an image first
    for colour, name in zip((100, 200), written, strict=True):
        mesh = write_textured_gltf(tmp_path / f"in{colour}" / "mesh.gltf", colour, image_name)
        assert run("segment", mesh, "-k", 1, "-q", "-o", "o.ply") == (0, "", "")
        assert named_textures(tmp_path / "o.ply") == [name]
        read = pymeshlab.MeshSet()
        read.load_new_mesh("o.ply")
        assert read.current_mesh().wedge_tex_coord_matrix()[:, 0].tolist() == [1, 0, 1]
        read.current_mesh().textures()[name].save("pixels.ppm")
        assert Path("pixels.ppm").read_bytes()[-12:] == bytes([colour] * 12)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
@pytest.mark.parametrize(
    ("properties", "is_kept"),
    [
        (["float confidence"], False),
        (["float32 confidence"], False),
        (["double quality", "float confidence"], False),
        (["float confidence", "float quality"], True),
        (["double confidence", "double quality"], True),
        (["float quality"], True),
    ],
)
def test_vertex_quality_is_right_or_left_out(run, tmp_path, form, properties, is_kept):
    vertices, faces = load_arrays(CUBE)
    names = ["float x", "float y", "float z", *properties]
    header = ["ply", f"format {form} 1.0", f"element vertex {len(vertices)}"]
    header += [f"property {name}" for name in names]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    columns = [*vertices.T, *(np.arange(len(vertices)) + len(name) for name in properties)]
    types = [(name, "<f8" if name.startswith("double") else "<f4") for name in names]
    rows = np.array(list(zip(*columns, strict=True)), types)
    corners = np.array([(3, face) for face in faces], [("count", "u1"), ("corners", "<i4", 3)])
    body = rows.tobytes() + corners.tobytes()
    if form == "ascii":
        lines = [*rows.tolist(), *((3, *face) for face in faces.tolist())]
        body = "".join(" ".join(map(str, line)) + "\n" for line in lines).encode()
    (tmp_path / "scan.ply").write_bytes("\n".join([*header, ""]).encode() + body)
    out = tmp_path / "o.ply"
    assert run("segment", tmp_path / "scan.ply", "-k", 2, "-o", out, "-q") == (0, "", "")
    mesh_set = mesh_files.read_mesh(out)
    mesh = mesh_set.current_mesh()
    assert mesh.has_vertex_scalar() == is_kept
    if is_kept:
        assert np.array_equal(mesh.vertex_scalar_array(), rows[properties[-1]])


def cube_text(old="", new=""):
    return CUBE.read_text().replace(old, new, 1)


BAD_FILES = {
    "nan.obj": cube_text("v 1 0 0", "v 1 nan 0"),
    "twice.obj": cube_text() + "f 1 1 2\n",
    "index.obj": cube_text() + "f 1 2 99\n",
    "hole.obj": cube_text().rsplit("f ", 1)[0],
    "points.obj": cube_text().split("f ")[0],
    "garbage.ply": "hello",
    "short.txt": "0\n1\n",
    "twelve.txt": "1\n" * 12,
    "words.txt": "a\n" * 12,
    "halves.txt": "0.5\n" * 12,
    "negative.txt": "-1\n" * 12,
    "broken.npy": "hello",
}

# Name: (arguments, what the line on stderr must hold). Runs where BAD_FILES are.
BAD_CALLS = {
    "no command": ([], "a command is missing"),
    "unknown command": (["cut"], "invalid choice: 'cut'"),
    "no mesh": (["segment"], "required: MESH"),
    "k no number": (["segment", CUBE, "-k", "many"], "invalid int value: 'many'"),
    "k zero": (["segment", CUBE, "-k", "0"], "submesh_count"),
    "k negative": (["segment", CUBE, "-k", "-3"], "-3"),
    "k above F": (["segment", CUBE, "-k", "13"], "13"),
    "two counts": (["segment", CUBE, "-k", "3", "--triangles-per-submesh", "2"], "not allowed"),
    "no triangles per sub-mesh": (
        ["segment", CUBE, "--triangles-per-submesh", "0"],
        "triangles_per_submesh must be 1 or more, got 0",
    ),
    "no triangles per block": (
        ["export", CUBE, "-o", "x.npz", "--triangles-per-submesh", "0"],
        "triangles_per_submesh must be 1 or more, got 0",
    ),
    "unknown option": (["segment", CUBE, "--fast"], "--fast"),
    "method": (["segment", CUBE, "--method", "best"], "invalid choice: 'best'"),
    "time limit": (["segment", CUBE, "--time-limit", "nan"], "must be finite, got nan"),
    "threads": (["segment", CUBE, "--threads", "-2"], "thread_count must be 0 or more, found -2"),
    "empty mesh": (["segment", ""], "mesh is empty"),
    "empty output": (["segment", CUBE, "--labels", ""], "labels is empty"),
    "empty weights": (["segment", CUBE, "--weights", ""], "weights is empty"),
    "empty start": (["segment", CUBE, "--initial-labels", ""], "initial-labels is empty"),
    "empty labels": (["measure", CUBE, "--labels", ""], "labels is empty"),
    "empty input": (["batch", CUBE, "", "-o", "out"], "inputs is empty"),
    "attribute of weights": (["segment", CUBE, "--weight-attribute", "w"], "--weight-attribute"),
    "weight unused": (["segment", CUBE, "--weights", "twelve.txt"], "balance='weight'"),
    "no file": (["segment", "none.ply"], "none.ply: no such file"),
    "no file at all": (["batch", "none.ply", "gone.ply", "-o", "out"], "none.ply: no such file"),
    "folder": (["segment", "."], ".: is a folder"),
    "garbage": (["segment", "garbage.ply"], "no PLY file"),
    "NaN": (["segment", "nan.obj"], "not finite (NaN)"),
    "corner twice": (
        ["segment", "twice.obj"],
        "1 of the 13 triangles of its faces can not be used",
    ),
    "missing vertex": (
        ["segment", "index.obj"],
        "line 21: a face names the vertex 99, expected an index from 1 to 8",
    ),
    "no faces": (["segment", "points.obj"], "has no faces"),
    "hole": (["segment", "hole.obj", "--method", "all_pairs"], "3 open border edges"),
    "hole, sphere": (["parametrize", "hole.obj", "-o", "s.ply"], "3 open border edges"),
    "output name": (["segment", CUBE, "-o", "o.txt"], "must end in .ply"),
    "output pipe": (["segment", CUBE, "-o", "pipe.ply"], "pipe.ply: is no ordinary file"),
    "output is a folder": (["segment", CUBE, "-o", "folder.ply"], "folder.ply: is a folder"),
    "output folder": (["segment", CUBE, "-o", "no/o.ply"], "there is no folder"),
    "label name": (["segment", CUBE, "--labels", "l.csv"], ".npy or .txt"),
    "no output": (["parametrize", CUBE], "required: -o"),
    "no folder for results": (["batch", CUBE], "required: -o"),
    "no folder for a report": (["evaluate", CUBE], "required: -o"),
    "no labels": (["measure", CUBE], "has no labels"),
    "label file": (["measure", CUBE, "--labels", "none.npy"], "no such file"),
    "label count": (["measure", CUBE, "--labels", "short.txt"], "12, got 2"),
    "label words": (["measure", CUBE, "--labels", "words.txt"], "is no file of labels"),
    "label halves": (["measure", CUBE, "--labels", "halves.txt"], "(0,) is 0.5"),
    "label negative": (["measure", CUBE, "--labels", "negative.txt"], "face 0 has -1"),
    "label npy": (
        ["measure", CUBE, "--labels", "broken.npy"],
        "is no file of labels: it does not begin as .npy files do; the name of a text must end in",
    ),
}


@pytest.mark.parametrize("case", BAD_CALLS)
def test_a_bad_call_gives_one_clear_line_and_exit_code_2(run, tmp_path, monkeypatch, case):
    monkeypatch.chdir(tmp_path)
    for name, text in BAD_FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "folder.ply").mkdir()
    os.mkfifo(tmp_path / "pipe.ply")  # no device, which a broken check would replace
    arguments, message = BAD_CALLS[case]
    code, shown, errors = run(*arguments)
    assert code == 2
    assert shown == ""
    assert errors.count("\n") == 1
    assert message in errors
    assert errors.startswith("spheroseg")


@pytest.mark.parametrize("command", ["segment", "evaluate"])
def test_an_option_that_a_command_does_not_know_is_refused_by_its_name(run, command):
    assert run(command, CUBE, "-o", "out.ply", "--resum", "now") == (
        2,
        "",
        f"spheroseg {command}: unrecognized arguments: --resum now (see spheroseg {command} "
        "--help)\n",
    )


# Nobody, not even root, may make files in /sys.
@pytest.mark.parametrize(
    ("arguments", "place"),
    [
        (["segment", CUBE, "-k", "2", "-o", "ok.ply", "--labels", "/sys/l.npy"], "/sys/l.npy"),
        (["measure", CUBE, "--json", "/sys/m.json"], "/sys/m.json"),
        (["parametrize", CUBE, "-o", "link/s.ply"], "link/s.ply"),
        (["export", CUBE, "-k", "2", "-o", "/sys/o.npz"], "/sys/o.npz"),
        (["split", CUBE, "-k", "2", "-o", "/sys/new/parts"], "/sys/new/parts"),
        (["split", CUBE, "-k", "2", "-o", "circle"], "circle"),
        (["batch", CUBE, "-o", "/sys/new"], "/sys/new"),
        (["batch", CUBE, "-o", "circle/new"], "circle/new"),
        (["evaluate", CUBE, "-o", "/sys/new"], "/sys/new"),
        (["segment", CUBE, "-o", "circle.ply"], "circle.ply"),
        (["segment", CUBE, "-o", 252 * "n" + ".ply"], 252 * "n" + ".ply"),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else value[-12:],
)
def test_a_place_where_nothing_can_be_written_is_refused_before_any_work(
    run, tmp_path, monkeypatch, arguments, place
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(mesh_files, "read_mesh", None)
    (tmp_path / "link").symlink_to("/sys")
    for name in ("circle", "circle.ply"):
        (tmp_path / name).symlink_to(name)
    before = sorted(tmp_path.iterdir())
    code, shown, errors = run(*arguments)
    assert (code, shown, errors.count("\n")) == (2, "", 1)
    assert errors.startswith(f"spheroseg {arguments[0]}: {place}: ")
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    "arguments",
    [
        ["segment", "{}.obj", "-k", "2"],
        ["segment", CUBE, "-k", "2", "-o", "{}.ply"],
        ["segment", CUBE, "-k", "2", "--json", "{}/o.json"],
        ["parametrize", CUBE, "-o", "{}.ply"],
        ["batch", "{}.obj", "-o", "out"],
        ["batch", CUBE, "-o", "{}"],
        ["evaluate", CUBE, "-o", "{}"],
        ["split", CUBE, "-k", "2", "-o", "{}"],
        ["export", CUBE, "-k", "2", "-o", "{}.npz"],
    ],
    ids=lambda arguments: f"{arguments[0]} {arguments[-2]}",
)
def test_a_name_that_is_not_utf_8_is_refused_before_any_work(run, tmp_path, monkeypatch, arguments):
    monkeypatch.chdir(tmp_path)
    name = os.fsdecode(b"m\xff")
    for path in (tmp_path / f"{name}.obj", tmp_path / "folder" / f"{name}.obj"):
        path.parent.mkdir(exist_ok=True)
        shutil.copy(CUBE, path)
    before = sorted(tmp_path.rglob("*"))
    code, _, errors = run(*(str(argument).format(name) for argument in arguments))
    assert code == 2
    assert errors.count("\n") == 1
    assert "m\\xff" in errors
    assert "the name is not UTF-8" in errors
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize("arguments", [["segment", CUBE, "-k", 13], ["segment", "none.ply"], []])
def test_the_program_itself_ends_with_exit_code_2_and_no_traceback(arguments):
    done = run_program(*arguments)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("closed", ["2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
def test_closed_streams_do_no_harm(tmp_path, closed):
    out = tmp_path / "o.ply"
    done = run_shell(f'"$@" {closed}', "segment", CUBE, "-k", 2, "-o", out)
    assert done.returncode == 0
    measured = run_shell(f'"$@" {closed}', "measure", out, "--json", tmp_path / "m.json")
    assert measured.returncode == 0
    assert json.loads((tmp_path / "m.json").read_text())["submesh_triangles"] == [6, 6]


@pytest.mark.parametrize("arguments", [["segment", CUBE, "-k", 2], ["--version"], ["--help"]])
def test_output_that_can_not_be_written_is_one_line(arguments):
    done = run_shell('"$@" > /dev/full', *arguments)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "the standard output: No space left on device" in done.stderr


@pytest.mark.parametrize(
    "arguments", [["batch", "--help"], ["split", CUBE, "-k", 2, "-o", "parts"]]
)
def test_output_that_can_not_be_written_is_one_line_where_nothing_is_buffered(arguments, tmp_path):
    line = f'cd "{tmp_path}"; PYTHONUNBUFFERED=1 "$@" > /dev/full'
    done = run_shell(line, *arguments)
    assert done.returncode == 2
    assert done.stderr == "spheroseg: the standard output: No space left on device\n"


@pytest.mark.parametrize("stream", ["2>/dev/full", "2> >(true)"])
def test_errors_that_can_not_be_said_have_their_exit_code(stream):
    done = run_shell(f'"$@" {stream}', "segment", "no such file.obj", "-k", 2)
    assert done.returncode == 2


def test_a_command_whose_output_nobody_reads_ends_in_silence(tmp_path):
    line = '"$@" | true; exit ${PIPESTATUS[0]}'
    for arguments in (
        ["segment", CUBE, "-k", 2],
        ["batch", CUBE, "-k", 2, "-o", tmp_path / "out"],
        ["--version"],
    ):
        done = run_shell(line, *arguments)
        assert (done.returncode, done.stderr) == (141, "")
    assert (tmp_path / "out" / "manifest.csv").exists()


def test_a_refused_mesh_leaves_no_output(run, tmp_path):
    hole = tmp_path / "hole.obj"
    hole.write_text(BAD_FILES["hole.obj"])
    outputs = [tmp_path / name for name in ("o.ply", "l.npy", "m.json")]
    names = ("-o", outputs[0], "--labels", outputs[1], "--json", outputs[2])
    code, *_ = run("segment", hole, "--method", "all_pairs", *names)
    assert code == 2
    assert not any(path.exists() for path in outputs)


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["segment", "-q", "--labels", "l.npy"], "l.npy"),
        (["export", "-o", "a.glb"], "a.glb"),
        (["split", "-o", "s"], "s/submesh_0000.ply"),
    ],
)
def test_a_file_that_may_not_be_so_large_is_named(arguments, name, tmp_path):
    done = run_shell(f'cd "{tmp_path}"; ulimit -f 1; "$@"', *arguments, LEAF, "-k", 2)
    expected = f"spheroseg {arguments[0]}: {name}: File too large\n"
    assert (done.returncode, done.stderr) == (2, expected)
    assert list(tmp_path.iterdir()) == []


def test_a_working_folder_that_is_gone_is_said(tmp_path):
    line = f'cd "{tmp_path}"; rmdir "{tmp_path}"; "$@"'
    done = run_shell(line, "segment", CUBE, "-k", 2, "-q", "-o", "x.ply")
    expected = "spheroseg segment: the working folder: No such file or directory\n"
    assert (done.returncode, done.stderr) == (2, expected)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "there is not enough memory; close other programs, or simplify the mesh"),
        (OSError(errno.EIO, "Input/output error"), "Input/output error"),
        (OSError(errno.ENOENT, "No such file", "x.ply"), "x.ply: No such file"),
    ],
)
def test_what_the_system_refuses_is_one_line_and_exit_code_2(run, monkeypatch, error, said):
    def failing(_):
        raise error

    monkeypatch.setattr(measure, "run", failing)
    assert run("measure", CUBE) == (2, "", f"spheroseg measure: {said}\n")


def test_values_are_never_cut(run, monkeypatch, tmp_path):
    labels = tmp_path / "labels.txt"
    labels.write_text(11 * "0\n" + "1\n")
    wide = run("measure", CUBE, "--labels", labels)
    monkeypatch.setenv("COLUMNS", "20")
    assert run("measure", CUBE, "--labels", labels) == wide
    assert wide[0] == 0


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_labels_of_an_editor_that_marks_utf_8_are_read(run, tmp_path, ending):
    labels = tmp_path / "labels.txt"
    labels.write_text(ending.join(6 * ["0"] + 6 * ["1"]), encoding="utf-8-sig", newline="")
    assert run("measure", CUBE, "--labels", labels)[0] == 0


def shown_on_a_terminal(*arguments, **variables) -> tuple[list[str], bytes]:
    """Each state of the bar that a command draws on stderr, without colours, and its output."""
    controller, terminal = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "spheroseg", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=terminal,
        env=environment(TERM="xterm", NO_COLOR="1", COLUMNS="120", **variables),
    )
    os.close(terminal)
    shown = b"".join(iter(lambda: read_terminal(controller), b""))
    os.close(controller)
    output, _ = process.communicate()
    assert process.returncode == 0
    return shown.decode().split("\r"), output


def test_progress_on_a_terminal_rises_and_leaves_the_output_alone():
    effort = ("--effort", "high")  # for a second or so
    shown, output = shown_on_a_terminal("segment", LEAF, "-k", "200", *effort, "-q")
    assert output == b""
    reports = [state for state in shown if "Segmenting: " in state]
    lengths = [state.count("━") for state in reports]
    assert lengths == sorted(lengths)
    assert lengths[0] < lengths[-1] == 40  # as long as a bar is
    assert "Segmenting: Done" in reports[-1]


@pytest.mark.parametrize("command", ["segment", "batch"])
def test_progress_on_a_terminal_that_knows_ascii_only(command, tmp_path):
    output = tmp_path / ("out" if command == "batch" else "out.ply")
    plain = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    shown, _ = shown_on_a_terminal(command, LEAF, "-k", "20", "-o", output, **plain)
    assert output.exists()
    assert "Segmenting" in " ".join(shown)
    assert " ".join(shown).isascii()


def test_progress_of_many_meshes_counts_those_that_are_done(tmp_path):
    shown, _ = shown_on_a_terminal("batch", CUBE, LEAF, "-k", "2", "-o", tmp_path / "out")
    counts = [int(count) for count in re.findall(r"(\d)/2 ", " ".join(shown))]
    assert counts == sorted(counts)
    assert (counts[0], counts[-1]) == (0, 2)
