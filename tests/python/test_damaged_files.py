# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are cut short, empty, damaged or lie in their header: one clear line, exit code 2."""

import base64
import json
import os
import random
import re
import resource
import signal
import struct
import traceback
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from mesh_paths import SAMPLE_FOLDER

from spheroseg import cli, digests, file_checks, mesh_files, obj_checks
from spheroseg.batch import inputs, jobs
from spheroseg.counts import Counts
from spheroseg.errors import InputError

CUBE = SAMPLE_FOLDER / "cube.obj"
HUGE_COUNTS = (100_000_000, 2**31 - 1, 2**31, 4_000_000_000, 10**20)
GIB = 2**30


def faces_read(path):
    mesh_set = mesh_files.read_mesh(path)  # lives as long as its mesh is looked at
    return mesh_set.current_mesh().face_matrix()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes of a cube in every format."""
    folder = tmp_path_factory.mktemp("whole")
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(CUBE))
    content = {}
    for name in ("ply", "obj", "off", "stl"):
        mesh_set.save_current_mesh(str(folder / f"cube.{name}"))
        content[name] = (folder / f"cube.{name}").read_bytes()
    for name in ("ply", "stl"):
        mesh_set.save_current_mesh(str(folder / f"text.{name}"), binary=False)
        content[f"text.{name}"] = (folder / f"text.{name}").read_bytes()
    return content


@pytest.fixture
def little_memory():
    """What asks for much memory fails at once instead of taking the machine's."""
    limits = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + 2 * GIB, limits[1]))
    yield
    resource.setrlimit(resource.RLIMIT_AS, limits)


@pytest.fixture
def outcome(tmp_path, capsys, little_memory):
    """Segments a file with this content: (exit code, stderr)."""

    def call(name, content):
        path = tmp_path / f"mesh.{name.rsplit('.', 1)[-1]}"
        path.write_bytes(content)
        code = cli.main(["segment", str(path), "-k", "3", "-q", "--threads", "1"])
        shown = capsys.readouterr()
        assert shown.out == ""
        return code, shown.err

    return call


def assert_refused(outcome):
    code, line = outcome
    assert code == 2
    assert line.startswith("spheroseg segment: ")
    assert line.count("\n") == 1
    assert len(line) < 500


FORMATS = ["ply", "text.ply", "obj", "off", "stl", "text.stl"]


@pytest.mark.parametrize("name", FORMATS)
def test_a_file_that_is_cut_short_is_refused(outcome, whole, name):
    content = whole[name]
    for share in (0.0, 0.02, 0.2, 0.4, 0.6, 0.8, 0.9):
        assert_refused(outcome(name, content[: int(share * len(content))]))


@pytest.mark.parametrize("name", FORMATS)
def test_a_whole_file_is_read(outcome, whole, name):
    assert outcome(name, whole[name]) == (0, "")


@pytest.mark.parametrize("name", ["ply", "obj", "off", "stl"])
def test_random_bytes_are_refused(outcome, name):
    generator = random.Random(1)
    for size in (1, 16, 100, 3000):
        assert_refused(outcome(name, generator.randbytes(size)))


def exit_code_of_fork(work):
    """0 if `work` ends in a process of its own, 1 if it raises, minus the signal that ended it."""
    child = os.fork()
    if child == 0:
        signal.alarm(20)
        code = 1
        try:
            work()
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def with_wrong_bytes(content, generator):
    content = bytearray(content)
    for _ in range(3):
        content[generator.randrange(len(content))] = generator.randrange(256)
    return bytes(content)


WRONG_WORDS = [
    *(b"0", b"3", b"-1", b"99", b"00000000000000000000002", b"4294967298", b"1e5", b"nan", b"1,5"),
    *(b"", b"\t", b"\r", b"\v", b"\0", b"#", b"\\\n", b"\\\n ", b"/", b"//", b"2/1", b"-1//2"),
    *(b"v", b"vt", b"vtt", b"vn", b"vt 1", b"f", b"f 1 2", b"q", b"l 1 99", b"usemtl", b"mtllib"),
    *(b"COFF", b"element", b"property int flags", b"list uchar int", b"comment TextureFile a.png"),
    *(b"facet", b"vertex", b"endfacet", b"endsolid"),
]


def with_wrong_words(content, generator):
    lines = content.split(b"\n")
    for _ in range(generator.randint(1, 3)):
        place = generator.randrange(len(lines))
        words = lines[place].split(b" ")
        at = generator.randrange(len(words))
        change = generator.randrange(4)
        if change < 2:
            words[at : at + change] = [generator.choice(WRONG_WORDS)]
            lines[place] = b" ".join(words)
        elif change == 2:
            lines.insert(place, generator.choice([lines[place], *WRONG_WORDS]))
        elif len(lines) > 1:
            del lines[place]
    return b"\n".join(lines)


@pytest.mark.parametrize("damage", [with_wrong_bytes, with_wrong_words])
@pytest.mark.parametrize("name", [*FORMATS, "text.polygons.ply", "little.polygons.ply"])
def test_a_damaged_file_is_read_or_refused(outcome, whole, name, damage):
    # In processes of their own: PyMeshLab might end one.
    generator = random.Random(2)
    for case in range(30):
        content = damage(whole.get(name) or polygon_bytes(name, *grid(9)), generator)

        def read(content=content):
            code, said = outcome(name, content)
            if code == 0:  # what is left of the cube may have parts that no equal counts fit
                assert all(": warning: the result for " in line for line in said.splitlines())
            else:
                assert_refused((code, said))

        assert exit_code_of_fork(read) == 0, case


def test_an_off_face_that_names_a_missing_vertex_is_refused(outcome, whole):
    faces = whole["off"].rstrip().rsplit(b"\n", 1)
    for wrong in (b"3 0 1 8", b"3 0 1 4957", b"3 0 1 -1", b"3 0 1 \xff"):
        assert_refused(outcome("off", faces[0] + b"\n" + wrong + b"\n"))


OFF_VERTICES = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
OFF_FACES = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
OFF_TETRAHEDRON = "OFF\n4 4 6\n" + OFF_VERTICES + OFF_FACES
COLORED = OFF_VERTICES.replace("\n", " 255 0 0\n")
NORMAL = OFF_VERTICES.replace("\n", " 0 0 1\n")
TEXTURED = OFF_VERTICES.replace("\n", " 0 1\n")


@pytest.mark.parametrize(
    "content",
    [
        "\ufeff" + OFF_TETRAHEDRON,
        "# written by BINARY tools\n" + OFF_TETRAHEDRON,
        "#" + 70_000 * "x" + "\n" + OFF_TETRAHEDRON,
        OFF_TETRAHEDRON.replace("OFF\n", "OFF \n\r\n"),
        OFF_TETRAHEDRON.replace("OFF\n", "OFF\t"),
        OFF_TETRAHEDRON.replace("0 0 0\n1 0 0\n", "0\n0 0 1\n# half of it\n0 0\n"),
        OFF_TETRAHEDRON.replace("3 0 2 1", "3\n0 2 1"),
        OFF_TETRAHEDRON.replace("\n0 1 0\n0", "\n-.0 +1. 0e-5\n.0E+2"),
        OFF_TETRAHEDRON.replace("3 0 2 1", "3 0 2 1 255 0 0").replace("4 4 6", "4 4 6 # counts"),
        OFF_TETRAHEDRON.replace(OFF_VERTICES, COLORED).replace("OFF", "COFF"),
        OFF_TETRAHEDRON.replace(OFF_VERTICES, NORMAL).replace("OFF", "NOFF"),
        OFF_TETRAHEDRON.replace(OFF_VERTICES, TEXTURED).replace("OFF", "STOFF"),
    ],
)
def test_off_files_are_followed_as_pymeshlab_follows_them(outcome, content):
    assert outcome("off", content.encode()) == (0, "")
    # Followed from there, the last index is beyond all memory.
    at = content.rindex("3 1 2 3") + len("3 1 2 ")
    result = outcome("off", (content[:at] + "900000000\n").encode())
    assert_refused(result)
    assert (
        f"line {1 + content.count(chr(10), 0, at)}: a face names the vertex '900000000'"
        in result[1]
    )


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("1 0 0\n", "1 0 0 # a corner\n", "line 4: a vertex has a comment"),
        ("3 0 3 2\n", "  \n3 0 3 2\n", "line 9 has nothing but blanks"),
        ("3 1 2 3\n", "", "ends before all"),
        ("3 0 3 2\n", "3 0 3\n", "line 9: a face of 3 corners names 2"),
        ("3 0 3 2\n", "+3 0 3 2\n", "line 9: a face has +3 corners"),
        ("3 0 3 2\n", "3 0 3 2 0\n", "line 9: a face has one number behind its corners"),
        ("3 1 2 3\n", "3\n1 2 3 -1\n", "line 10: a face has one number behind its corners"),
        ("3 1 2 3\n", "3 1 2 3\n\n# end\n3 0 1\n2\n", "goes on with '3 0 1' behind the 4 faces"),
        ("3 1 2 3\n", "3 1 2 3\n\v\n", "behind the 4 faces that the header declares"),
        ("4 4 6", "4 four 6", "declares four faces"),
        ("0 1 0\n", "# a comment\n0 1,5 0\n", "line 6: '1,5' is no number"),
        ("0 1 0\n", "0 1 0 red\n", "line 5: 'red' is no number"),
        ("0 1 0\n", "0 - 0\n", "line 5: '-' is no number"),
        ("0 1 0\n", "0 1_0 0\n", "line 5: '1_0' is no number"),
        ("3 1 2 3\n", "3\v0 1 2 900000000\n", "line 10 has control characters"),
        ("3 1 2 3\n", "3\r0 1 2 900000000\n", "line 10 has control characters"),
    ],
)
def test_off_files_that_pymeshlab_reads_wrongly_are_refused(outcome, old, new, complaint):
    result = outcome("off", OFF_TETRAHEDRON.replace(old, new).encode())
    assert_refused(result)
    assert complaint in result[1]


TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\n"
TEXTURES = "vt 0 0\n" * 4


@pytest.mark.parametrize("comment", [" # bottom", "# bottom", "\t#", " #1 2 3"])
def test_a_comment_behind_an_obj_face_is_refused(outcome, comment):
    result = outcome("obj", TETRAHEDRON.replace("f 1 4 2", "f 1 4 2" + comment).encode())
    assert_refused(result)
    assert "line 6: a face has a comment" in result[1]


@pytest.mark.parametrize("content", [b"", b"# nothing\n", b"f 1 2 3\n"])
def test_an_obj_without_vertices_is_called_that(outcome, content):
    result = outcome("obj", content)
    assert_refused(result)
    assert "mesh.obj: has no vertices; it is empty, damaged, or no OBJ file" in result[1]


def test_comments_elsewhere_in_an_obj_are_none_of_its_faces(outcome):
    content = "# f 9 9 9\n" + TETRAHEDRON.replace("v 1 0 0", "v 1 0 0 # f 9") + "f 2 4 3\n#end"
    assert outcome("obj", content.encode()) == (0, "")


@pytest.mark.parametrize("control", ["\0", "\1", "\2", "\10", "\v", "\f", "\16", "\37"])
@pytest.mark.parametrize(
    "line", ["f {}2 4 3", "f 2 4{}3", "{}f 2 4 3", "f 2 \\\n4 {}3", "v{}1 0 0"]
)
def test_control_characters_in_an_obj_are_refused(outcome, line, control):
    # PyMeshLab takes them for a part of the word.
    result = outcome("obj", (TETRAHEDRON + line.format(control) + "\n").encode())
    assert_refused(result)
    assert "line 8: a vertex or face has control characters" in result[1]


def test_control_characters_elsewhere_in_an_obj_do_no_harm(outcome):
    content = "# \1\f\n\0\n" + TETRAHEDRON + "g f\2\n" + "f 2 4 3\r\n\0\0\n"
    assert outcome("obj", content.encode()) == (0, "")


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("v 0 1 0", "v 0 1,5 0", "line 3: '1,5' is no number"),
        ("v 0 1 0", "  vt 0,5 0,5\nv 0 1 0", "line 3: '0,5' is no number"),
        ("v 0 1 0", "vn 0 1,0 0\nv 0 1 0", "line 3: '1,0' is no number"),
        ("v 0 1 0", "v 0 abc 0 # y?", "line 3: 'abc' is no number"),
        ("v 0 1 0", "v 0 1 # 0", "line 3: '#' is no number"),
        ("v 0 1 0", "v 0 1 0#", "line 3: '0#' is no number"),
        ("v 0 1 0", "v 0 1 -1.#IND", "line 3: '-1.#IND' is no number"),
        ("v 0 1 0", "v 0 1 0 1 0 red", "line 3: 'red' is no number"),
        ("v 0 1 0", "v 0 \\\n1 \\\n0x", "line 3: '0x' is no number"),
        ("v 0 1 0", "v 0 - 0", "line 3: '-' is no number"),
        ("v 0 1 0", "v 0 -.e5 0", "line 3: '-.e5' is no number"),
        ("v 0 1 0", "v 0 1e 0", "line 3: '1e' is no number"),
        ("f 1 4 2", "f 1 4 2abc", "line 6: a face names '2abc'"),
        ("f 1 4 2", "f 1 4.0 2", "line 6: a face names '4.0'"),
        ("f 1 4 2", "f 1 4 1-2", "line 6: a face names '1-2'"),
        ("f 1 4 2", "f 1 4/1,5 2", "line 6: a face names '4/1,5'"),
        ("f 1 4 2", "f f1 4 2", "line 6: a face names 'f1'"),
    ],
)
def test_words_in_an_obj_that_are_no_numbers_are_refused(outcome, old, new, complaint):
    result = outcome("obj", TETRAHEDRON.replace(old, new).encode())
    assert_refused(result)
    assert complaint in result[1]


@pytest.mark.parametrize(
    "vertex",
    [
        "v -0.E+2 +1 .0",
        "v\t0  1e-0 0. 1",
        "v 0 1 0 255 0.5 1e-5",
        "v 0 1 0 # 1,5",
        "v 0 1 0 1 0 0 #red # or pink",
        "v 0 \\\n1 0 # abc",
        "vt .5 1 # 0,5\nv 0 1 0",
        "vn nan -nan(ind) inf\nv 0 1 0",
    ],
)
def test_numbers_of_an_obj_may_be_written_in_any_way(tmp_path, vertex):
    path = tmp_path / "mesh.obj"
    path.write_text(TETRAHEDRON.replace("v 0 1 0", vertex))
    mesh_set = mesh_files.read_mesh(path)
    assert mesh_set.current_mesh().vertex_matrix()[2].tolist() == [0, 1, 0]


NORMALS = "vn 0 0 1\n" * 4


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("f 2 4 50000\n", "line 8: a face names the vertex 50000, expected an index from 1 to 4"),
        ("f 2 4 5\n", "the vertex 5"),
        ("f 2 4 0\n", "the vertex 0"),
        ("f 2 4 -5\n", "the vertex -5"),
        ("f 2 4 99999999999999999999\n", "the vertex 99999"),
        ("f 2 4 \\\n  -2147483648\n", "the vertex -2147483648"),
        (f"f 2 4 {'0' * 17}31900000000\n", "the vertex 31900000000"),
        (f"f 2 4 -{'0' * 17}31900000000\n", "the vertex -31900000000"),
        ("q 0 1 2 4\n", "the vertex 5"),
        (TEXTURES + "f 2/1 4/2 3/5\n", "the texture coordinate 5"),
        (TEXTURES + "f 2/1 4/2 3/0\n", "the texture coordinate 0"),
        (NORMALS + "f 2//1 4//2 3//5\n", "the normal 5"),
        (NORMALS + "f 2//1 4//2 3//\n", "the normal 0"),
        (TEXTURES + NORMALS + "f 2/1/1 4/2/-5 3/3/3\n", "the normal -5"),
        ("  v 0 0 0\n", "line 8: a vertex has blanks before"),
        ("vt0 0\n", "line 8: begins with 'vt0', which PyMeshLab counts as 'vt'"),
        (TEXTURES + "\n\tvtt 0 0\nf 2/1 4/2 3/5\n", "line 13: begins with 'vtt'"),
        (NORMALS + "vn1 0 0\n", "line 12: begins with 'vn1'"),
        ("f 2 \\\r\n4 3\r\n", "line 8: goes on in the next one"),
        ("f 2 4 1\\\n3\n", "line 8: a face names the vertex 13"),
        ("f 2 4 1\\\n 3\nf 2 3 5", "line 10: a face names the vertex 5"),
        ("v\\\n 0 0 0\n", "line 8: begins with 'v' and goes on"),
        ("\tvt\\\n0 0\n", "line 8: begins with 'v' and goes on"),
        ("# C:\\\nvt 0 0\n", "line 9: begins with 'v' and goes on"),
        ("f 2 4 \\\n3\ng \\\n vn 0 0 1\n", "line 11: begins with 'v' and goes on"),
    ],
)
def test_an_obj_index_of_something_that_is_not_there_is_refused(outcome, lines, words):
    result = outcome("obj", (TETRAHEDRON + lines).encode())
    assert_refused(result)
    assert words in result[1]


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("Ns", "line 3: 'Ns' has no value"),
        ("  d \t\r", "line 3: 'd' has no value"),
        ("illum", "line 3: 'illum' has no value"),
        ("Tr", "line 3: 'Tr' has no value"),
        ("Kd\nmap_Kd\nillum 2\nNs 0 \n# d\ndiffuse", None),
    ],
)
@pytest.mark.parametrize(("named", "name"), [("mtllib a b.mtl\n", "a b.mtl"), ("", "mesh.mtl")])
def test_materials_that_pymeshlab_would_read_beyond_a_line_are_refused(
    tmp_path, line, complaint, named, name
):
    path = tmp_path / "mesh.obj"
    path.write_text(named + TETRAHEDRON)
    (tmp_path / name).write_text(f"newmtl x\nKd 1 0 0\n{line}\nnewmtl y\n", newline="")
    if complaint is None:
        assert obj_checks.obj_counts(path) == Counts(3, 4)
    else:
        with pytest.raises(InputError, match=f"{name}: {complaint}"):
            obj_checks.obj_counts(path)


@pytest.mark.parametrize(
    "face",
    [
        "f -3 -1 -2",
        "f +2 +4 +3",
        "f 0000000000000000000002 -000000000000000000000000001 +03",
        "  f\t2  4\t3  ",
        "f 2 \\\n4 \\\n3",
        "f 2 0\\\n\\\n4 \\\n 3\nv 1 \\\n2 3",
        "f 2/9 4/9 3/9",
        "f 2//9 4//9 3//9",
        "f 2// 4// 3//",
        "q 1 1 3 2",
    ],
)
def test_other_forms_of_obj_indices_are_read(tmp_path, face):
    content = TETRAHEDRON.replace("\n", "\r\n") + "\n" + face
    if face.startswith("q"):
        content = TETRAHEDRON.rpartition("f")[0] + "q 0 2 1 3\n"
    path = tmp_path / "mesh.obj"
    path.write_bytes(content.encode())
    assert len(faces_read(path)) == 4


def test_obj_indices_are_checked_across_blocks_of_the_file(tmp_path, monkeypatch):
    monkeypatch.setattr(obj_checks, "_BLOCK_BYTES", 7)
    path = tmp_path / "mesh.obj"
    path.write_text(TETRAHEDRON + "f -3 \\\n -1 \\\n -2")
    assert obj_checks.obj_counts(path) == Counts(4, 4)
    path.write_text(TETRAHEDRON + "f 2 \\\n4 \\\n 3\nf 1 2 7\nv 0 0 0\n")
    with pytest.raises(InputError, match=r"line 11: a face names the vertex 7.* from 1 to 5"):
        obj_checks.obj_counts(path)


def grid(side, damage=""):
    """Vertices and faces of a plane of quads, one cut into triangles."""
    vertices = [[x, y, 0.0] for x in range(side) for y in range(side)]
    faces = [[a, a + side, a + side + 1, a + 1] for a in range(side * (side - 1)) if (a + 1) % side]
    a, b, c, d = faces.pop(3)
    faces[3:3] = [[a, b, c], [a, c, d]]
    if damage == "NaN":
        vertices[0][1] = float("nan")
    elif damage == "infinite":
        vertices[0][1] = float("inf")
    elif damage == "corner twice":
        faces[1][3] = faces[1][2]
    elif damage == "thin triangle":
        faces += [[0, 0, 1]]
    return vertices, faces


def polygon_bytes(name, vertices, faces):
    """A file of polygons; `.big.ply` and `.little.ply` are binary."""
    points = "".join(f"{x} {y} {z}\n" for x, y, z in vertices)
    if name.endswith(".obj"):
        lines = [f"v {point}\n" for point in points.splitlines()]
        lines += ["f " + " ".join(str(i + 1) for i in face) + "\n" for face in faces]
        return "".join(lines).encode()
    corners = "".join(f"{len(face)} " + " ".join(map(str, face)) + "\n" for face in faces)
    if name.endswith(".off"):
        return f"OFF\n{len(vertices)} {len(faces)} 0\n{points}{corners}".encode()
    kind = name.split(".")[0]
    form = "ascii" if kind == "text" else f"binary_{kind}_endian"
    header = f"ply\nformat {form} 1.0\nelement vertex {len(vertices)}\n"
    header += "".join(f"property float {axis}\n" for axis in "xyz")
    header += f"element face {len(faces)}\nproperty uchar red\n"
    header += "property list uchar int vertex_indices\nend_header\n"
    if form == "ascii":
        return (header + points + "".join(f"7 {line}\n" for line in corners.splitlines())).encode()
    order = ">" if kind == "big" else "<"
    rows = [struct.pack(f"{order}BB{len(face)}i", 7, len(face), *face) for face in faces]
    return header.encode() + np.array(vertices, f"{order}f4").tobytes() + b"".join(rows)


POLYGON_FILES = ["mesh.obj", "mesh.off", "text.ply", "little.ply", "big.ply"]


@pytest.mark.parametrize("name", POLYGON_FILES)
def test_files_of_polygons_are_read_and_counted_in_triangles(tmp_path, name):
    path = tmp_path / name
    for side in (3, 9):
        path.write_bytes(polygon_bytes(name, *grid(side)))
        assert file_checks.checked_counts(path).triangles == 2 * (side - 1) ** 2
        assert len(faces_read(path)) == 2 * (side - 1) ** 2


@pytest.mark.parametrize("damage", ["NaN", "infinite", "corner twice", "thin triangle"])
@pytest.mark.parametrize("name", POLYGON_FILES)
def test_polygons_that_lose_triangles_are_refused(outcome, name, damage):
    result = outcome(name, polygon_bytes(name, *grid(6, damage)))
    assert_refused(result)
    assert " of the 5" in result[1]
    face = {"corner twice": 1, "thin triangle": 26}.get(damage)
    if face is None:
        assert "can not be used: they name vertices whose coordinates are not finite" in result[1]
    else:
        lines_before = {".obj": 6 * 6, ".off": 2 + 6 * 6}.get(name[-4:])
        place = f"face {face}" if lines_before is None else f"line {lines_before + face + 1}"
        assert f"can not be used: {place} is the first that names a vertex twice" in result[1]


@pytest.mark.parametrize(("element", "lost"), [("vertex", 2), ("face", 1)])
def test_a_ply_whose_flags_mark_something_as_deleted_is_refused(outcome, element, lost):
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    content = polygon_bytes("text.ply", vertices, [[0, 2, 1], [0, 1, 3], [0, 3, 2]]).decode()
    header, body = content.split("end_header\n")
    points, faces = body.splitlines()[:4], body.splitlines()[4:]
    flagged = points if element == "vertex" else faces
    flagged[:] = [f"{line} 0" for line in flagged[:-1]] + [f"{flagged[-1]} 1"]
    end = "element face" if element == "vertex" else "end_header"
    header = f"{header}end_header\n".replace(end, f"property int flags\n{end}")
    result = outcome("ply", (header + "\n".join(points + faces) + "\n").encode())
    assert_refused(result)
    assert f"{lost} of the 3 triangles" in result[1]
    assert "'flags' of a ply file mark them or their vertices as deleted" in result[1]


def test_the_first_of_many_faces_that_lose_triangles_is_named(tmp_path):
    vertices, faces = grid(9, "corner twice")
    quad = [1, 2, 3, 2]
    for name in POLYGON_FILES:
        path = tmp_path / name
        path.write_bytes(polygon_bytes(name, vertices, [quad, *faces]))
        expected = {".obj": "line 82", ".off": "line 84"}.get(name[-4:], "face 0")
        assert file_checks.checked_counts(path).first_odd_face == expected
        path.write_bytes(polygon_bytes(name, *grid(9)))
        assert file_checks.checked_counts(path).first_odd_face is None


def test_faces_of_obj_files_that_count_back_name_vertices_as_others_do(tmp_path):
    path = tmp_path / "mesh.obj"
    for face, expected in (
        ("f 4 1 -1", "line 8"),
        ("f -4/1 1/2 2/3", "line 8"),
        ("f 1 2", "line 8"),
        ("f -1 -2 -3\nf 2/1 2/2 3/3", "line 9"),
        ("f 1/2 2/2 -1/2", None),
    ):
        path.write_text(f"{TETRAHEDRON}{face}\nv 7 7 7\n")
        assert obj_checks.obj_counts(path).first_odd_face == expected
    # Beyond one block, with what counts back from its own place.
    far = "# filling\n" * (obj_checks._BLOCK_BYTES // 10)
    path.write_text(f"{TETRAHEDRON}{far}v 7 7 7\nf -1 1 2\nf -1 1 5\n{far}f 1 1 2\n")
    line = 7 + far.count("\n") + 3
    assert obj_checks.obj_counts(path).first_odd_face == f"line {line}"


@pytest.mark.parametrize("name", POLYGON_FILES)
def test_vertices_that_pymeshlab_leaves_out_are_counted(tmp_path, name):
    vertices, faces = grid(4)
    path = tmp_path / name
    path.write_bytes(polygon_bytes(name, vertices + [[5, 5, 5]], faces))
    mesh_set, lost = mesh_files.read_counting_lost(path)
    assert (mesh_set.current_mesh().vertex_number(), lost) == (17, 0)
    first, last = [[np.nan] * 3, [0, np.inf, 0]], [[5, 5, 5], [0, 0, np.nan]]
    shifted = [[corner + 2 for corner in face] for face in faces]
    path.write_bytes(polygon_bytes(name, first + vertices + last, shifted))
    mesh_set, lost = mesh_files.read_counting_lost(path)
    assert (mesh_set.current_mesh().vertex_number(), lost) == (17, 3)
    with pytest.raises(InputError, match=r"leaves out 3 of its vertices"):
        mesh_files.read_every_vertex(path)


@pytest.mark.parametrize("order", ["big", "little"])
def test_lengths_of_ply_lists_are_read_in_the_files_order(tmp_path, order):
    # Of 32 bits, with a long face, so that neither is like any other reading of it.
    corners = 2 * np.pi * np.arange(140) / 140
    vertices = np.stack((np.cos(corners), np.sin(corners), 0 * corners), axis=1)
    content = polygon_bytes(f"{order}.ply", vertices, [list(range(140))])
    sign = ">" if order == "big" else "<"
    path = tmp_path / "mesh.ply"
    path.write_bytes(content)
    assert file_checks.checked_counts(path).triangles == 138
    length = struct.pack(f"{sign}I", 140)
    content = content.replace(b"list uchar", b"list int")
    content = content.replace(b"\x07\x8c", b"\x07" + length)
    path.write_bytes(content)
    assert file_checks.checked_counts(path).triangles == 138


PLY_HEADER = """ply
format {form} 1.0
element vertex 4
property float x
property float y
property float z
element face {count}
property list {types} vertex_indices
end_header
"""
CODES = {"char": "b", "uchar": "B", "short": "h", "ushort": "H", "int": "i", "uint": "I"}


def ply_bytes(form, faces, types="uchar int"):
    """Four corners of a tetrahedron with these faces, in a PLY."""
    header = PLY_HEADER.format(form=form, count=len(faces), types=types)
    points = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]
    if form == "ascii":
        lines = [" ".join(map(str, [len(face), *face])) for face in faces]
        return (header + " ".join(map(str, points)) + "\n" + "\n".join(lines) + "\n").encode()
    order = ">" if form == "binary_big_endian" else "<"
    length, index = (CODES[name] for name in types.split())
    rows = [struct.pack(f"{order}{length}{len(f)}{index}", len(f), *f) for f in faces]
    return header.encode() + struct.pack(f"{order}12f", *points) + b"".join(rows)


PLY_FORMS = ["ascii", "binary_little_endian", "binary_big_endian"]
PLY_FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2]]


@pytest.mark.parametrize(
    "types", ["uchar int", "char uint", "int int", "uchar uint", "uchar short"]
)
@pytest.mark.parametrize("form", PLY_FORMS)
def test_a_ply_index_of_a_vertex_that_is_not_there_is_refused(outcome, form, types):
    # PyMeshLab looks at the first three only, and at most of the others.
    assert outcome("ply", ply_bytes(form, [*PLY_FACES, [1, 2, 3]], types)) == (0, "")
    wrong = [1, 2, 3, 4] if "u" in types.split()[1] else [1, 2, 3, -1]
    for face in (wrong, wrong[1:]):
        result = outcome("ply", ply_bytes(form, [*PLY_FACES, face], types))
        assert_refused(result)
        assert f"face 3 names the vertex {wrong[-1]}, expected an index in [0, 4)" in result[1]


@pytest.mark.parametrize("form", PLY_FORMS)
def test_a_ply_face_of_too_few_or_too_many_corners_is_refused(outcome, form):
    # PyMeshLab takes the third corner from the face before, and has room for 512.
    for corners in ([1, 2], 200 * [1, 2, 3]):
        result = outcome("ply", ply_bytes(form, [*PLY_FACES, corners], "int int"))
        assert_refused(result)
        assert f"face 3 has {len(corners)} corners, expected 3 to 255" in result[1]


def test_a_ply_length_that_shifts_what_follows_is_refused(outcome):
    # The faces behind it are then read from the middle of others.
    content = bytearray(ply_bytes("binary_little_endian", 300 * PLY_FACES))
    content[-13 * 400] = 5
    assert_refused(outcome("ply", bytes(content)))


@pytest.mark.parametrize(
    ("form", "types"),
    [("binary_little_endian", "int uint"), ("binary_big_endian", "int short")]
    + [(form, types) for form in PLY_FORMS for types in ("ushort int", "uchar ushort")],
)
def test_types_of_ply_corners_that_pymeshlab_can_not_read_are_refused(outcome, form, types):
    result = outcome("ply", ply_bytes(form, PLY_FACES, types))
    assert_refused(result)
    assert "property list uchar int vertex_indices" in result[1]


@pytest.mark.parametrize("types", ["int uint", "ushort uint", "int short"])
def test_types_of_ply_corners_that_pymeshlab_reads_in_texts_only_are_read(tmp_path, types):
    path = tmp_path / "mesh.ply"
    path.write_bytes(ply_bytes("ascii", PLY_FACES, types))
    assert faces_read(path).tolist() == PLY_FACES


@pytest.mark.parametrize(
    ("declared", "values"),
    [
        ("list uchar float texcoord", [0.5, 0.25, 1, 0, 0, 1e-3]),
        ("list int double other", [0.5] * 200),
        ("list int int other", [7] * 700),  # of binary files none would have room for it
    ],
)
def test_other_lists_of_text_ply_faces_are_passed_over(tmp_path, declared, values):
    content = ply_bytes("ascii", PLY_FACES).decode()
    content = content.replace("end_header", f"property {declared}\nend_header")
    listed = " ".join(map(str, [len(values), *values]))
    content = re.sub(r"^3 .*", lambda face: f"{face[0]} {listed}", content, flags=re.M)
    path = tmp_path / "mesh.ply"
    path.write_text(content)
    assert faces_read(path).tolist() == PLY_FACES


@pytest.mark.parametrize(
    ("declared", "length", "complaint"),
    [
        ("list uchar float texcoord", 6, None),
        ("list uchar float texcoord", 33, "a list 'texcoord' of 33 entries"),
        ("list uchar float color", 200, "a list 'color' of 200 entries"),
        ("list uchar float other", 128, None),
        ("list uchar float other", 129, "a list 'other' of 129 entries"),
        ("list int float other", 6, "a list 'other' of 6 entries"),
    ],
)
def test_other_lists_of_binary_ply_faces_must_fit_into_pymeshlabs_room(
    outcome, declared, length, complaint
):
    content = ply_bytes("binary_little_endian", PLY_FACES)
    content = content.replace(b"end_header", f"property {declared}\nend_header".encode())
    values = struct.pack("<B" if "uchar" in declared else "<i", length) + bytes(4 * length)
    at = len(content) - 3 * 13
    faces = [content[at + 13 * i : at + 13 * (i + 1)] + values for i in range(3)]
    result = outcome("ply", content[:at] + b"".join(faces))
    if complaint is None:
        assert result == (0, "")
    else:
        assert_refused(result)
        assert complaint in result[1]


STRIPS = b"element tristrips 1\nproperty list int int vertex_indices"


@pytest.mark.parametrize(
    ("strip", "complaint"),
    [
        ([0, 1, 2, 3, 0], None),
        ([0, 1, 2, 3, -1, 1, 0, 3, -1], None),
        ([0, 1, 2, 4], "names the vertex 4"),
        ([0, 1, 2, -2], "names the vertex -2"),
        ([0, 1, 2, -1, 0, -1, 1, 2, 3], "fewer than two corners"),
        ([0, -1, 2, 1], "fewer than two corners"),
    ],
)
@pytest.mark.parametrize("form", PLY_FORMS)
def test_triangle_strips_that_pymeshlab_would_follow_too_far_are_refused(
    outcome, form, strip, complaint
):
    content = ply_bytes(form, [strip], "int int")
    content = re.sub(rb"element face 1\n.*indices", STRIPS, content)
    result = outcome("ply", content)
    if complaint is None:
        assert result == (0, "")
    else:
        assert_refused(result)
        assert complaint in result[1]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("0 1 0", "0 1.0.5 0", "line 10: '1.0.5' is no number"),
        ("0 1 0", "0 1-2 0", "line 10: '1-2' is no number"),
        ("0 1 0", "0 1e0.5 0", "line 10: '1e0.5' is no number"),
        ("0 1 0", "0 infinity2 0", "line 10: 'infinity2' is no number"),
        ("0 1 0", "0 nan(ind) 0", "line 10: 'nan(ind)' is no number"),
        ("0 1 0", "0 - 0", "line 10: '-' is no number"),
        ("0 1 0", "0 1e+ 0", "line 10: '1e+' is no number"),
        ("3 0 1 3", "3 0 one 3", "line 12: 'one' is no number"),
        ("3 0 1 3", "3 0 1.0 3", "face 1 has a fraction"),
        ("3 0 1 3", "0000000000000000000002 0 1", "face 1 has 2 corners"),
        ("3 0 1 3", "4294967299 0 1 3", "face 1 does not end"),
        ("3 0 1 3", "-3 0 1 3", "face 1 does not end"),
        ("list uchar int", "list uchar int vertex_index\nproperty list uchar int", "can not read"),
        ("element face", "element vertex 1\nelement face", "declares vertex twice"),
        ("element face", "comment\relement face", "numbers more than"),
        ("element face", "element\vface", "line 7 of the header"),
        ("element face", "comment " + 600 * "c" + "\nelement face", "line 7 of the header"),
        ("element face 3", "  element face 300000000", "declares 300,000,000 faces"),
        ("end_header", "comment end_header", "no line 'end_header'"),
        ("ply\n", "element\n", "does not begin with 'ply'"),
        ("format ascii", "format asci", "names no format"),
        ("end_header", "element edge 4000000000\nend_header", "declares 4,000,000,000 edge"),
    ],
)
def test_a_ply_that_pymeshlab_reads_otherwise_than_written_is_refused(outcome, old, new, complaint):
    content = ply_bytes("ascii", PLY_FACES).decode()
    assert outcome("ply", content.encode()) == (0, "")
    result = outcome("ply", content.replace(old, new, 1).encode())
    assert_refused(result)
    assert complaint in result[1]


@pytest.mark.parametrize("end", ["", "\n\n", "\n \n\t\n\r\n"])
def test_blank_lines_between_and_behind_the_faces_of_a_text_ply_are_none(tmp_path, end):
    content = ply_bytes("ascii", PLY_FACES).decode().replace("\n3 0 1 3", "\n\n \n3 0 1 3")
    path = tmp_path / "mesh.ply"
    path.write_text(content.rstrip() + end, newline="")
    mesh_set = mesh_files.read_mesh(path)
    assert mesh_set.current_mesh().face_matrix().tolist() == PLY_FACES


@pytest.mark.parametrize("comment", ["comment 1 2 3\n", "# made by hand\n", "\nobj_info x"])
def test_a_comment_behind_the_faces_of_a_text_ply_is_refused(outcome, comment):
    # PyMeshLab does not look at it; but a PLY has comments in its header only.
    result = outcome("ply", ply_bytes("ascii", PLY_FACES) + comment.encode())
    assert_refused(result)
    assert f"'{comment.split()[0]}' is no number" in result[1]


def test_numbers_of_a_text_ply_may_be_written_in_any_way(tmp_path):
    written = b"\n+00000000000000000000003 0\v1\f 00000000000000000000002\r"
    content = ply_bytes("ascii", [[0, 1, 2]]).replace(b"\n3 0 1 2", written)
    content = content.replace(b" 1 0 0 0 1 0 0 0 1", b" 1e0 -0.E+2 .0 +0 1. 0 nan -INF Infinity")
    path = tmp_path / "mesh.ply"
    path.write_bytes(content)
    assert faces_read(path).tolist() == [[0, 1, 2]]


def test_big_endian_doubles_are_refused(outcome):
    # PyMeshLab does not turn their bytes round.
    content = polygon_bytes("big.ply", *grid(3)).replace(b"float z", b"double z")
    result = outcome("ply", content + bytes(4 * 9))
    assert_refused(result)
    assert "binary_little_endian" in result[1]


def test_an_off_face_of_five_corners_is_refused(outcome):
    # PyMeshLab takes the vertices 0 to 4 for it.
    vertices = [[0, 0, 1], [0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 0.5, 0]]
    result = outcome("off", polygon_bytes("mesh.off", vertices, [[0, 1, 2], [1, 2, 3, 4, 5]]))
    assert_refused(result)
    assert "5 corners" in result[1]


@pytest.mark.parametrize("number", ["nan", "inf"])
def test_stl_facets_that_can_not_be_used_are_refused(outcome, whole, number):
    text = whole["text.stl"].decode().split("\n")
    corner = next(i for i, line in enumerate(text) if "vertex" in line)
    text[corner] = f"vertex {number} 0 0"
    binary = bytearray(whole["stl"])
    binary[84 + 12 : 84 + 16] = struct.pack("<f", float(number))
    for name, content in (("stl", bytes(binary)), ("text.stl", "\n".join(text).encode())):
        result = outcome(name, content)
        assert_refused(result)
        assert "1 of the 12" in result[1]


def test_an_stl_with_bytes_behind_its_facets_is_read(outcome, whole):
    assert max(whole["stl"][80:]) >= 128  # so PyMeshLab does not take it for text
    assert outcome("stl", whole["stl"] + bytes(10)) == (0, "")


def test_a_text_stl_needs_its_last_line(outcome, whole):
    lines = whole["text.stl"].rstrip().split(b"\n")
    facets = [i for i, line in enumerate(lines) if b"endfacet" in line]
    result = outcome("text.stl", b"\n".join(lines[: facets[5] + 1]) + b"\n")
    assert_refused(result)
    assert "endsolid" in result[1]


def test_a_text_stl_of_several_solids_is_read_whole(tmp_path, whole):
    lines = whole["text.stl"].rstrip().split(b"\n")
    first = [i for i, line in enumerate(lines) if b"endfacet" in line][5] + 1
    solids = [[b"solid a", *lines[1:first], b"endsolid a"], [b"solid b", *lines[first:-1]]]
    path = tmp_path / "mesh.stl"
    path.write_bytes(b"\n".join([*solids[0], *solids[1], b"ENDSOLID b", b"", b""]))
    assert len(faces_read(path)) == 12


def gltf_bytes(mesh_count, primitive_count, view=0, **transformation):
    """A glTF file of single triangles; `view`: which part of the buffer has the vertices, there is
    only 0; `transformation`: of each node."""
    data = np.eye(3, dtype="<f4").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    mesh = {"primitives": [{"attributes": {"POSITION": 0}}] * primitive_count}
    position = {"bufferView": view, "componentType": 5126, "count": 3, "type": "VEC3"}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(mesh_count))}],
        "nodes": [{"mesh": i, **transformation} for i in range(mesh_count)],
        "meshes": [mesh] * mesh_count,
        "accessors": [{**position, "min": [0, 0, 0], "max": [1, 1, 1]}],
        "bufferViews": [{"buffer": 0, "byteLength": len(data)}],
        "buffers": [{"byteLength": len(data), "uri": uri}],
    }
    return json.dumps(document).encode()


def test_a_file_of_several_meshes_is_refused(outcome):
    result = outcome("gltf", gltf_bytes(3, 1))
    assert_refused(result)
    assert "holds 3 meshes, expected one" in result[1]


def test_one_gltf_mesh_of_several_parts_is_read_whole(tmp_path):
    path = tmp_path / "mesh.gltf"
    path.write_bytes(gltf_bytes(1, 4))
    assert len(faces_read(path)) == 4


def test_a_gltf_mesh_is_read_where_its_node_places_it(tmp_path):
    path = tmp_path / "mesh.gltf"
    path.write_bytes(gltf_bytes(1, 1, translation=[5, 0, 0], scale=[1, 2, 1]))
    read = mesh_files.read_mesh(path)
    assert read.current_mesh().vertex_matrix().tolist() == [[6, 0, 0], [5, 2, 0], [5, 0, 1]]


def test_a_file_that_crashes_meshlabs_reader_is_refused(tmp_path, capfd):
    path = tmp_path / "mesh.gltf"
    path.write_bytes(gltf_bytes(1, 1, view=2**28))
    assert cli.main(["segment", str(path)]) == 2
    line = capfd.readouterr().err
    assert line.startswith(f"spheroseg segment: {path}: MeshLab's reader crashed on it (")
    assert line.endswith("; the file is probably damaged, export it anew\n")
    assert line.count("\n") == 1


def test_a_copy_that_can_not_be_used_is_refused_by_the_name_of_the_file(tmp_path, monkeypatch):
    path = tmp_path / "mesh.gltf"
    path.write_bytes(gltf_bytes(1, 1))
    monkeypatch.setattr(
        mesh_files, "_copy_elsewhere", lambda _, copy: copy.write_bytes(b"ply\nno header\n")
    )
    with pytest.raises(InputError) as refused:
        mesh_files.read_mesh(path)
    message = str(refused.value)
    assert message.startswith(f"{path}: MeshLab's reader makes a mesh of it that can not be used (")
    assert message.count(".ply") == 0


def test_what_meshlab_says_is_cut_to_a_readable_length(outcome):
    content = gltf_bytes(1, 1).replace(b";base64,", b";base64," + 1000 * b"!")
    result = outcome("gltf", content)
    assert_refused(result)
    assert result[1].endswith("...\n")


def test_a_mesh_of_another_format_keeps_all_that_it_has(tmp_path):
    path = tmp_path / "mesh.3ds"
    made = pymeshlab.MeshSet()
    made.load_new_mesh(str(CUBE))
    made.compute_color_by_function_per_face(r="20*fi", g="9", b="7")
    made.compute_texcoord_parametrization_triangle_trivial_per_wedge(textdim=64)
    made.save_current_mesh(str(path))
    made.load_new_mesh(str(path))
    read = mesh_files.read_mesh(path)
    mesh, expected = read.current_mesh(), made.current_mesh()
    assert np.array_equal(mesh.face_matrix(), expected.face_matrix())
    assert np.array_equal(mesh.vertex_matrix(), expected.vertex_matrix())
    assert np.array_equal(mesh.face_color_matrix(), expected.face_color_matrix())
    assert np.array_equal(mesh.wedge_tex_coord_matrix(), expected.wedge_tex_coord_matrix())


def test_a_ply_list_that_pymeshlab_can_not_skip_is_refused(outcome, whole):
    result = outcome("ply", whole["ply"].replace(b"element face", b"element facet"))
    assert_refused(result)
    assert "'facet' has a list" in result[1]


@pytest.mark.parametrize(
    "line",
    [
        b"element fa\te 12",
        b"property floa x",
        b"property list uchar int",
        b"propert float x",
        b"\xff",
    ],
)
def test_a_damaged_line_of_a_ply_header_is_refused_and_quoted(outcome, whole, line):
    result = outcome("ply", whole["ply"].replace(b"end_header", line + b"\nend_header"))
    assert_refused(result)
    assert "line 10 of the header" in result[1]


@pytest.mark.parametrize("count", HUGE_COUNTS)
@pytest.mark.parametrize("element", ["vertex", "face"])
@pytest.mark.parametrize("name", ["ply", "text.ply"])
def test_a_ply_header_that_declares_too_much_costs_no_memory(outcome, whole, name, element, count):
    pattern = rb"element %s \d+" % element.encode()
    content = re.sub(pattern, b"element %s %d" % (element.encode(), count), whole[name])
    result = outcome(name, content)
    assert_refused(result)
    assert f"declares {count:,}" in result[1]


def test_the_faces_of_a_ply_need_room_behind_its_vertices(outcome):
    # 81 vertices of 12 bytes, and 1162 bytes for faces of 2 bytes or more.
    content = polygon_bytes("little.ply", *grid(9))
    result = outcome("ply", content.replace(b"element face 65", b"element face 800"))
    assert_refused(result)
    assert "declares 800 faces" in result[1]


@pytest.mark.parametrize("count", [*HUGE_COUNTS, -5])
@pytest.mark.parametrize("place", [0, 1])
def test_an_off_header_that_declares_too_much_costs_no_memory(outcome, whole, place, count):
    counts = re.search(rb"OFF\s+(\d+) (\d+)", whole["off"])
    start, end = counts.span(place + 1)
    content = whole["off"][:start] + str(count).encode() + whole["off"][end:]
    assert_refused(outcome("off", content))


@pytest.mark.parametrize("count", [13, 100_000_000, 2**31 - 1, 2**32 - 1])
@pytest.mark.parametrize("body", [None, bytes(600)], ids=["cube", "zeros"])
def test_an_stl_header_that_declares_too_much_is_refused_at_once(outcome, whole, body, count):
    content = whole["stl"][:80] + count.to_bytes(4, "little") + (body or whole["stl"][84:])
    assert_refused(outcome("stl", content))


@pytest.mark.parametrize(
    ("name", "rest"),
    [
        ("text.ply", "has 36 numbers more"),
        ("little.ply", "has 108 bytes more"),
        ("big.ply", "has 108 bytes more"),
        ("mesh.off", "behind the 11 faces"),
    ],
)
def test_a_header_that_declares_fewer_faces_than_there_are_is_refused(outcome, name, rest):
    vertices, faces = grid(5)
    content = polygon_bytes(name, vertices, faces)
    assert len(faces) == 17
    declared = (b"element face 17", b"element face 11")
    if name == "mesh.off":
        declared = (b"25 17 0", b"25 11 0")
    result = outcome(name, content.replace(*declared))
    assert_refused(result)
    assert rest in result[1]


@pytest.mark.parametrize("filling", [b"\n", b" \r\n\n", bytes(500), b"\x1a", b"\n\0\0"])
@pytest.mark.parametrize("name", ["text.ply", "little.ply", "big.ply", "mesh.off"])
def test_what_only_fills_the_end_of_a_file_is_none_of_it(outcome, name, filling):
    assert outcome(name, polygon_bytes(name, *grid(5)) + filling) == (0, "")


def test_a_ply_header_without_a_count_is_refused(outcome, whole):
    for wrong in (b"element face -5", b"element face", b"element face many"):
        assert_refused(outcome("ply", re.sub(rb"element face \d+", wrong, whole["ply"])))


def npy_bytes(shape, size, dtype="'<i4'"):
    header = f"{{'descr': {dtype}, 'fortran_order': False, 'shape': {shape}, }}".encode()
    header += b" " * (118 - len(header) - 1) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(size)


BAD_LABELS = {
    "empty.npy": b"",
    "empty.txt": b"",
    "short.npy": npy_bytes("(12,)", 12),
    "huge.npy": npy_bytes("(100000000000,)", 48),
    "overflow.npy": npy_bytes("(4611686018427387904, 4)", 48),
    "negative.npy": npy_bytes("(-12,)", 48),
    "none.npy": npy_bytes("(0,)", 0),
    "square.npy": npy_bytes("(3, 4)", 48),
    "objects.npy": npy_bytes("(12,)", 96, "'|O'"),
    "text.npy": npy_bytes("(12,)", 48, "'<U1'"),
    "code.npy": npy_bytes("(12,)", 48, "__import__('os')"),
    "unclosed.npy": npy_bytes("(12,", 48),
    "type.npy": npy_bytes("(12,)", 48, "'<i4 i'"),
    "archive.npy": b"PK\x05\x06" + bytes(18),
    "random.npy": random.Random(3).randbytes(500),
    "magic.npy": b"\x93NUMPY\x01\x00" + random.Random(4).randbytes(300),
    "random.txt": random.Random(5).randbytes(500),
    "columns.txt": b"0 1\n" * 12,
    "infinite.txt": b"inf\n" * 12,
    "large.txt": b"99999999999999999999\n" * 12,
}


@pytest.mark.parametrize("name", BAD_LABELS)
def test_damaged_labels_are_refused(tmp_path, capsys, little_memory, name):
    (tmp_path / name).write_bytes(BAD_LABELS[name])
    assert cli.main(["measure", str(CUBE), "--labels", str(tmp_path / name)]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.count("\n") == 1
    assert shown.err.startswith("spheroseg measure: ")


def test_an_npy_with_a_damaged_header_is_read_or_refused(tmp_path):
    generator = random.Random(6)
    path = tmp_path / "labels.npy"
    refusals = []
    for _ in range(1000):
        content = bytearray(npy_bytes("(12,)", 48))
        content[generator.randrange(8, 70)] = generator.randrange(256)
        path.write_bytes(content)
        try:
            mesh_files.read_labels(path)
        except InputError as error:
            refusals.append(str(error))
    assert all(refusal.startswith(f"{path}: is no file of labels: ") for refusal in refusals)
    assert len(refusals) > 500


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe\x00",
        b"mesh\n\0\n",
        b'mesh\n"' + b"a" * 200_000,
        b"k,mesh\n5\n",
        b"mesh\n \n",
    ],
    ids=["empty", "no utf-8", "NUL", "long field", "short row", "blank name"],
)
def test_a_damaged_list_of_meshes_is_refused(tmp_path, content):
    (tmp_path / "list.csv").write_bytes(content)
    with pytest.raises(InputError, match=re.escape(str(tmp_path / "list.csv"))):
        inputs.collect([str(tmp_path / "list.csv")])


RECORD = {"status": "done", "settings": {}, "input_sha256": "", "outputs": {}}


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b"null",
        b"\xff\xfe",
        json.dumps({**RECORD, "outputs": []}).encode(),
        json.dumps({**RECORD, "outputs": {"a": 1}}).encode(),
        json.dumps({**RECORD, "outputs": None}).encode(),
    ],
)
def test_a_damaged_record_of_a_batch_means_that_the_mesh_is_done_again(tmp_path, content):
    job = jobs.Job(str(CUBE), "cube", str(tmp_path), {}, (), {})
    content = content.replace(
        b'"settings": {}', b'"settings": ' + json.dumps(job.settings()).encode()
    )
    content = content.replace(
        b'"input_sha256": ""', f'"input_sha256": "{digests.sha256(CUBE)}"'.encode()
    )
    job.record_path().parent.mkdir()
    job.record_path().write_bytes(content)
    assert jobs.finished_record(job) is None


def test_labels_are_read_into_memory_of_their_own(tmp_path):
    path = tmp_path / "labels.npy"
    np.save(path, np.arange(5))
    labels = mesh_files.read_labels(path)
    path.unlink()
    assert labels.tolist() == [0, 1, 2, 3, 4]
    assert type(labels) is np.ndarray
