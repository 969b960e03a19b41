# SPDX-License-Identifier: GPL-3.0-or-later
"""What PyMeshLab must not be given to read.

It makes room for what a header declares before it reads on, so that a header of a few bytes could
ask for all memory or keep it busy for hours; and some damage ends the process.
"""

import itertools
import os
import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from spheroseg.errors import InputError
from spheroseg.obj_checks import obj_triangle_count
from spheroseg.ply_faces import PLY_TYPES, corner_counts

_HEAD_BYTES = 65536
_BLOCK_BYTES = 2**22
_PLY_LIST_ELEMENTS = (b"vertex", b"face", b"tristrips")
_PLURALS = {"vertex": "vertices", "face": "faces"}
_OFF_CORNERS = 4
_STL_HEADER_BYTES = 84
_STL_FACE_BYTES = 50
_STL_SAMPLE_BYTES = 1000


def check_is_file(path: Path) -> None:
    """Raises InputError where there is no file."""
    if not path.is_file():
        raise InputError(f"{path}: no such file")


def check_name(path: Path) -> None:
    """Raises InputError for a name that is not UTF-8: PyMeshLab and tables take no other."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        shown = os.fsencode(path).decode(errors="backslashreplace")
        raise InputError(f"{shown}: the name is not UTF-8; rename the file or folder") from None


def checked_triangle_count(path: Path) -> int | None:
    """Number of triangles that the faces of a ply, off, obj or stl file make, were none left out.

    None where it is not known. Raises InputError for a file that is damaged in such a way.
    """
    suffix = path.suffix.lower()
    if suffix in (".obj", ".qobj"):
        return obj_triangle_count(path)
    check = {".ply": _check_ply, ".off": _check_off, ".stl": _check_stl}.get(suffix)
    if check is None:
        return None
    size = path.stat().st_size
    with path.open("rb") as file:
        return check(path, file.read(_HEAD_BYTES), size)


def _check_ply(path: Path, head: bytes, size: int) -> int | None:
    header, found, body = head.partition(b"end_header")
    if not found:
        return None  # PyMeshLab says what is wrong
    _check_ply_lines(path, header)
    has_doubles = re.search(rb"^property.*\b(double|float64)\b", header, re.M)
    if b"binary_big_endian" in header and has_doubles:
        raise InputError(
            f"{path}: has big-endian numbers of 64 bits, which PyMeshLab reads wrongly; write it "
            "again as binary_little_endian"
        )
    is_text = re.search(rb"^format\s+ascii", header, re.M) is not None
    needed = 0
    for element in re.split(rb"^element", header, flags=re.M)[1:]:
        words = element.split()
        if len(words) < 2 or not words[1].isdigit():
            raise InputError(
                f"{path}: the header declares {_shown(words[1:2])} of "
                f"{_shown(words[:1])}, expected a count; the file is damaged"
            )
        if words[0] not in _PLY_LIST_ELEMENTS and b"property list" in element:
            raise InputError(
                f"{path}: the element '{_shown(words[:1])}' has a list, which PyMeshLab can read "
                "for vertex and face only; write the file again without it"
            )
        count = int(words[1])
        least = _ply_bytes(element, is_text)
        name = _shown(words[:1])
        _require(path, size - len(header) - needed, count, _PLURALS.get(name, name), least)
        needed += count * least
    corners = corner_counts(path, header, len(head) - len(body) + body.find(b"\n") + 1)
    return None if corners is None else _triangle_count(corners)


def _check_ply_lines(path: Path, header: bytes) -> None:
    for number, line in enumerate(header.splitlines()[1:], start=2):
        words = line.split()
        if words and not _is_ply_line(words):
            raise InputError(
                f"{path}: line {number} of the header is '{_shown([line])}', expected a format, "
                "comment, element or property; the file is damaged"
            )


def _is_ply_line(words: list[bytes]) -> bool:
    kind, count = words[0], len(words)
    if kind == b"property" and count > 1 and words[1] == b"list":
        return count == 5 and {words[2], words[3]} <= PLY_TYPES.keys()
    if kind == b"property":
        return count == 3 and words[1] in PLY_TYPES
    return kind in (b"comment", b"obj_info") or (kind in (b"element", b"format") and count == 3)


def _ply_bytes(element: bytes, is_text: bool) -> int:
    """The least that one entry of an element takes: in text a digit and a space per property."""
    properties = re.findall(rb"^property\s+(\w+)", element, re.M)
    if is_text:
        return 2 * len(properties)
    counts = re.findall(rb"^property\s+list\s+(\w+)", element, re.M)
    types = [name for name in properties if name != b"list"] + counts
    return sum(np.dtype(PLY_TYPES[name]).itemsize for name in types)


def _check_off(path: Path, head: bytes, size: int) -> int | None:
    bare = re.sub(rb"#[^\n]*", b"", head)
    found = re.match(rb"\s*[A-Z]*OFF\s+([-+]?\d+)\s+([-+]?\d+)", bare)
    if not found:
        return None
    for text, name, least in ((found[1], "vertices", 6), (found[2], "faces", 4)):
        count = int(text)
        if count < 0:
            raise InputError(f"{path}: the header declares {count} {name}; the file is damaged")
        _require(path, size, count, name, least)
    if b"BINARY" in head:
        return None
    return _triangle_count(_off_corner_counts(path, int(found[1]), int(found[2])))


def _off_corner_counts(path: Path, vertex_count: int, face_count: int) -> list[int]:
    """PyMeshLab follows an index beyond the vertices, and mixes up faces of more corners."""
    corner_counts = []
    with path.open("rb") as file:
        lines = (words for line in file if (words := line.partition(b"#")[0].split()))
        header = next(lines)
        if len(header) < 3:
            next(lines)
        for words in itertools.islice(lines, vertex_count, vertex_count + face_count):
            corner_count = int(words[0]) if words[0].isdigit() else 0
            if corner_count > _OFF_CORNERS:
                raise InputError(
                    f"{path}: a face has {corner_count} corners, and PyMeshLab reads off files "
                    f"with {_OFF_CORNERS} at most; write it as ply or obj"
                )
            corner_counts.append(corner_count)
            for word in words[1 : 1 + corner_count]:
                if not word.isdigit() or int(word) >= vertex_count:
                    raise InputError(
                        f"{path}: a face names the vertex '{_shown([word])}', expected an index in "
                        f"[0, {vertex_count}); the file is damaged"
                    )
    return corner_counts


def _check_stl(path: Path, head: bytes, size: int) -> int:
    sample = head[80 : 80 + _STL_SAMPLE_BYTES]
    if head.lstrip()[:5].lower() == b"solid" and b"\0" not in head:
        return _stl_text_facets(path)
    if size < _STL_HEADER_BYTES:
        raise InputError(f"{path}: has {size} bytes, too few for an STL file; it is damaged")
    count = int.from_bytes(head[80:84], "little")
    _require(path, size - _STL_HEADER_BYTES + 2, count, "faces", _STL_FACE_BYTES)
    # Where the size is not what the count says, PyMeshLab takes the file for text unless it meets
    # a byte that is not ASCII, and then may never come to an end.
    if size != _STL_HEADER_BYTES + count * _STL_FACE_BYTES and max(sample) < 128:
        raise InputError(
            f"{path}: the header declares {count:,} faces, which make "
            f"{_STL_HEADER_BYTES + count * _STL_FACE_BYTES:,} bytes, but the file has {size:,}; it "
            "is damaged"
        )
    return count


def _stl_text_facets(path: Path) -> int:
    """Number of facets of all solids; only the last line tells that the file is whole."""
    facets = 0
    last_line = b""
    with path.open("rb") as file:
        while block := file.read(_BLOCK_BYTES) + file.readline():
            facets += block.lower().count(b"endfacet")
            last_line = (block.rstrip().rpartition(b"\n")[2] or last_line).lstrip()
    if not last_line.lower().startswith(b"endsolid"):
        raise InputError(
            f"{path}: the last line is '{_shown([last_line])}', expected 'endsolid'; the file is "
            "cut short or damaged"
        )
    return facets


def _triangle_count(corner_counts: npt.ArrayLike) -> int:
    """A face of fewer than three corners counts as one, which PyMeshLab does not make."""
    return int(np.maximum(np.asarray(corner_counts, dtype=np.int64) - 2, 1).sum())


def _require(path: Path, available: int, count: int, name: str, least_bytes: int) -> None:
    # The last line of a text needs no end.
    if count * least_bytes > available + 1:
        raise InputError(
            f"{path}: the header declares {count:,} {name}, but there are only {available:,} bytes "
            "for them; the file is cut short or damaged"
        )


def _shown(words: list[bytes]) -> str:
    return words[0].decode(errors="replace")[:40] if words else "nothing"
