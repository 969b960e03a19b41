# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes meshes and labels so that face i stays face i."""

import contextlib
import errno
import io
import os
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pymeshlab

from spheroseg import atomic, workers
from spheroseg._plugin import forget_failed_call
from spheroseg.counts import Counts
from spheroseg.errors import InputError, counted
from spheroseg.file_checks import (
    CHECKED_SUFFIXES,
    check_is_file,
    check_name,
    checked_counts,
)
from spheroseg.ply_faces import ply_elements, read_ply_header
from spheroseg.textures import copy_textures, give_coordinates_to_faces

_NOT_FOUND = ("File does not exist", "Can't open file")
_LONGEST_REASON = 300
_LONGEST_WORD = 80
_LABEL_ATTRIBUTE = "spheroseg_initial_label"
_UNKNOWN = Counts()


def sample_mesh(name: str) -> Path:
    """Path of a mesh that PyMeshLab brings along."""
    return Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / name


def read_mesh(path: str | os.PathLike) -> pymeshlab.MeshSet:
    """Reads a mesh file through PyMeshLab; triangles and vertices keep the file's order.

    No vertices are merged (except in STL, which has no shared vertices). Raises InputError when
    the file can not be read, has no triangles, or has faces that PyMeshLab leaves out without a
    word, because labels would no longer line up with the file. Vertices that no face names are
    left out where a coordinate is not finite.
    """
    return read_counting_lost(path)[0]


def read_every_vertex(path: str | os.PathLike) -> pymeshlab.MeshSet:
    """As `read_mesh`, for what tells of vertices by their index: raises InputError where
    `read_counting_lost` knows of vertices that are left out."""
    mesh_set, lost = read_counting_lost(path)
    if lost > 0:
        raise InputError(
            f"{path}: MeshLab's reader leaves out {lost} of its vertices, which no face names and "
            "whose coordinates are not finite (NaN), so that indices of vertices would not be the "
            "file's; save it again, in MeshLab or by 'spheroseg segment -o', and take the new file"
        )
    return mesh_set


def read_counting_lost(path: str | os.PathLike) -> tuple[pymeshlab.MeshSet, int]:
    """As `read_mesh`, and how many vertices of a ply, off or obj file are left out; 0 for other
    formats, of which it is not known."""
    path = Path(path)
    check_name(path)
    check_is_file(path)
    if path.suffix.lower() in CHECKED_SUFFIXES:
        return _load_counting_lost(path)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "mesh.ply"
        _copy_elsewhere(path, copy)
        try:
            return _load_counting_lost(copy)
        except InputError as error:
            reason = str(error).removeprefix(f"{copy}: ")
            raise InputError(
                f"{path}: MeshLab's reader makes a mesh of it that can not be used ({reason}); "
                "the file is probably damaged, export it anew"
            ) from None


def _load_counting_lost(path: Path) -> tuple[pymeshlab.MeshSet, int]:
    counts = checked_counts(path)
    mesh_set = load(path, counts)
    vertex_count = mesh_set.current_mesh().vertex_number()
    return mesh_set, max(0, (counts.vertices or 0) - vertex_count)


def load(path: Path, counts: Counts = _UNKNOWN) -> pymeshlab.MeshSet:
    """Reads a file that is there and harmless, and declares so much, as `read_mesh`."""
    mesh_set = pymeshlab.MeshSet()
    try:
        mesh_set.load_new_mesh(str(path))
    except pymeshlab.PyMeshLabException as error:
        forget_failed_call()
        raise InputError(f"{path}: PyMeshLab can not read it: {_reason(error, path)}") from None
    except MemoryError:
        raise InputError(
            f"{path}: there is not enough memory to read it; close other programs, or use a "
            "machine with more memory"
        ) from None
    if mesh_set.mesh_number() > 1:
        raise InputError(
            f"{path}: holds {mesh_set.mesh_number()} meshes, expected one; save each in a file of "
            "its own, or merge them (in MeshLab: Flatten Visible Layers)"
        )
    face_count = mesh_set.current_mesh().face_number()
    if counts.triangles is not None and counts.triangles > face_count:
        raise InputError(
            f"{path}: {counts.triangles - face_count} of the {counts.triangles} triangles of its "
            f"faces can not be used: {_why_left_out(counts)}; repair the file first, or save it "
            "again in MeshLab, which leaves them out"
        )
    if face_count == 0:
        raise InputError(f"{path}: has no faces; a triangle mesh is needed")
    return mesh_set


def _why_left_out(counts: Counts) -> str:
    if counts.first_odd_face is not None:
        return (
            f"{counts.first_odd_face} is the first that names a vertex twice, or fewer than three"
        )
    if counts.vertices is not None:
        return (
            "they name vertices whose coordinates are not finite (NaN), or 'flags' of a ply file "
            "mark them or their vertices as deleted"
        )
    return "they have two corners at one place, or coordinates that are not finite (NaN)"


def _copy_elsewhere(path: Path, copy: Path) -> None:
    """Lets another process write the mesh as PLY, as a damaged file may end the one that reads."""
    task = {"mesh": str(path.absolute()), "copy": str(copy)}
    try:
        [(_, result)] = workers.results("spheroseg.reading_worker", {}, [task])
    except workers.WorkerError as error:
        raise InputError(f"{path}: the process that should read it failed: {error}") from None
    if "refused" in result:
        raise InputError(f"{path}: {result['refused']}")
    if "error" in result:
        raise InputError(
            f"{path}: MeshLab's reader crashed on it ({result['error']}); the file is probably "
            "damaged, export it anew"
        )


def face_colours(mesh: pymeshlab.Mesh) -> np.ndarray | None:
    """(F, 3) uint8, or None for a mesh without face colours."""
    if not mesh.has_face_color():
        return None
    return np.round(255 * mesh.face_color_matrix()[:, :3]).astype(np.uint8)


def vertex_colours(mesh: pymeshlab.Mesh) -> np.ndarray | None:
    """(V, 4) uint8, the last column alpha, or None for a mesh without vertex colours."""
    if not mesh.has_vertex_color():
        return None
    return np.round(255 * mesh.vertex_color_matrix()).astype(np.uint8)


def save_ply(
    mesh_set: pymeshlab.MeshSet, path: str | os.PathLike, source: str | os.PathLike
) -> list[str]:
    """Writes the current mesh, which was read from `source`, as binary PLY with its colours,
    qualities and texture coordinates, without normals and custom attributes, and its textures
    beside it. Returns the names of the textures that could not be copied.

    Where it has texture coordinates of vertices and several images, faces have them afterwards.

    By MeshLab's writer, which keeps texture coordinates but says nothing about a full disk: so the
    file is read again before it takes its place.
    """
    mesh = mesh_set.current_mesh()
    source = Path(source)
    folder = Path(path).resolve().parent
    with atomic.atomic_path(path, ".ply") as temporary:
        temporary.touch()  # fails with the reason
        give_coordinates_to_faces(mesh_set)
        try:
            mesh_set.save_current_mesh(
                str(temporary),
                save_textures=False,
                save_vertex_color=mesh.has_vertex_color(),
                save_vertex_quality=mesh.has_vertex_scalar() and not _misreads_quality(source),
                save_face_color=mesh.has_face_color(),
                save_face_quality=mesh.has_face_scalar(),
            )
            left_out = copy_textures(mesh, source, temporary, folder)
            read_mesh(temporary)
        except (pymeshlab.PyMeshLabException, InputError) as error:
            forget_failed_call()
            message = f"could not be written whole; is the disk full? ({_reason(error, temporary)})"
            raise OSError(errno.EIO, message, str(path)) from error
    return left_out


def _misreads_quality(source: Path) -> bool:
    """Whether PyMeshLab makes the vertex quality of a ply from a `confidence` of 32 bits, which it
    takes for 64, as it does where there is no `quality` of 32 bits."""
    if source.suffix.lower() != ".ply":
        return False
    elements = ply_elements(read_ply_header(source))
    codes = {p.name: p.code for one in elements if one.name == b"vertex" for p in one.properties}
    return codes.get(b"confidence") == "f4" != codes.get(b"quality")


def read_labels(path: str | os.PathLike) -> np.ndarray:
    """Labels from a .npy file, or from a .txt file with one number per line."""
    return _read_numbers(path, "labels")


def read_weights(path: str | os.PathLike) -> np.ndarray:
    """Weights from the same kinds of files."""
    return _read_numbers(path, "weights")


def _read_numbers(path: str | os.PathLike, name: str) -> np.ndarray:
    path = Path(path)
    check_is_file(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # an empty file, a size that overflows
            if path.suffix.lower() == ".npy":
                return _read_npy(path)
            return _read_text(path)
    except (ValueError, Warning) as error:
        raise InputError(f"{path}: is no file of {name}: {_shortened(str(error))}") from None


def _read_text(path: Path) -> np.ndarray:
    try:
        return np.loadtxt(path, dtype=np.float64, ndmin=1, encoding="utf-8-sig")
    except (ValueError, UserWarning):
        # numpy counts rows, some of them from 0, without empty lines and comments.
        with contextlib.suppress(UnicodeDecodeError):  # of a compressed file
            _check_text(path)
        raise


def _check_text(path: Path) -> None:
    """Raises ValueError for a line with what is no number, or of another length than the others."""
    expected = None
    with path.open(encoding="utf-8-sig") as lines:
        for number, line in enumerate(lines, 1):
            words = line.split("#")[0].split()
            for word in words:
                try:
                    float(word.replace("_", "?"))  # of 1_000, which is none to numpy
                except ValueError:
                    shown = word[:_LONGEST_WORD]
                    raise ValueError(f"line {number}: expected a number, found '{shown}'") from None
            expected = expected or len(words)
            if words and len(words) != expected:
                raise ValueError(
                    f"line {number}: expected {counted(expected, 'number', 's')} as in the lines "
                    f"before, found {len(words)}"
                )
    if not expected:
        raise ValueError("it holds no numbers")


def _read_npy(path: Path) -> np.ndarray:
    with path.open("rb") as file:
        start = file.read(len(np.lib.format.MAGIC_PREFIX))
    if start.startswith(b"PK"):
        raise ValueError("it holds several arrays (.npz); one is expected")
    if start != np.lib.format.MAGIC_PREFIX:
        raise ValueError("it does not begin as .npy files do; the name of a text must end in .txt")
    try:
        # Mapped into memory, so that a header that declares more than there is costs no memory.
        return np.array(np.load(path, mmap_mode="r", allow_pickle=False))
    except OSError:
        raise
    except Exception as error:  # the header is Python, and may fail as Python does
        raise ValueError(f"numpy can not read it: {error}") from None


def save_labels(labels: np.ndarray, path: str | os.PathLike) -> None:
    """Labels as int32 .npy, or as .txt with one number per line."""
    labels = labels.astype(np.int32)
    path = Path(path)
    if path.suffix.lower() == ".npy":
        atomic.write_bytes(path, npy_bytes(labels))
    else:
        atomic.write_text(path, "".join(f"{label}\n" for label in labels))


def npy_bytes(array: np.ndarray) -> bytes:
    """The array as a .npy file."""
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def set_labels(mesh_set: pymeshlab.MeshSet, labels: np.ndarray) -> None:
    """Writes labels, one per face, to the face quality of the current mesh."""
    mesh = mesh_set.current_mesh()
    mesh.add_face_custom_scalar_attribute(labels.astype(np.float64), _LABEL_ATTRIBUTE)
    mesh_set.compute_scalar_by_function_per_face(q=_LABEL_ATTRIBUTE)


def _reason(error: Exception, path: Path) -> str:
    """The last sentence of PyMeshLab's message; the others repeat the file's name."""
    message = str(error).removeprefix(f"{path}: ")
    reason = message.rsplit("Error details:", 1)[-1].strip().splitlines()[-1]
    if reason.startswith(_NOT_FOUND) and not str(path).isascii():
        return (
            "it does not find a name that is not ASCII; import spheroseg before pymeshlab, or set "
            "the environment variable LC_ALL=C.UTF-8"
        )
    return _shortened(reason)


def _shortened(reason: str) -> str:
    """It may hold the whole file."""
    return reason if len(reason) <= _LONGEST_REASON else f"{reason[:_LONGEST_REASON]}..."
