# SPDX-License-Identifier: GPL-3.0-or-later
"""What PyMeshLab must not be given to read.

It makes room for what a header declares before it reads on, so that a header of a few bytes could
ask for all memory or keep it busy for hours; and some damage ends the process.
"""

import re
from pathlib import Path

import numpy as np

from spheroseg.counts import Counts, require_room
from spheroseg.errors import InputError, shown
from spheroseg.obj_checks import obj_counts
from spheroseg.off_checks import off_counts
from spheroseg.ply_faces import (
    PLY_TYPES,
    Element,
    header_words,
    ply_counts,
    ply_elements,
    ply_format,
)
from spheroseg.text_numbers import legible

#: Of the formats that `checked_counts` knows.
CHECKED_SUFFIXES = (".ply", ".off", ".obj", ".qobj", ".stl")
_HEAD_BYTES = 65536
_BLOCK_BYTES = 2**22
_PLY_LINE_BYTES = 510  # PyMeshLab takes the rest for a line of its own
_PLY_LIST_ELEMENTS = (b"vertex", b"face", b"tristrips")
_PLURALS = {"vertex": "vertices", "face": "faces"}
_CONTROL = re.compile(rb"[\0-\x1f]")
_STL_HEADER_BYTES = 84
_STL_FACE_BYTES = 50
_STL_SAMPLE_BYTES = 1000


def check_is_file(path: Path) -> None:
    """Raises InputError where there is no file."""
    if path.is_file():
        return
    if path.is_dir():
        raise InputError(f"{path}: is a folder")
    raise InputError(f"{path}: {'is no ordinary file' if path.exists() else 'no such file'}")


def check_name(path: Path) -> None:
    """Raises InputError for a name that is not UTF-8: PyMeshLab and tables take no other."""
    try:
        str(path).encode()
    except UnicodeEncodeError:
        raise InputError(
            f"{shown(path)}: the name is not UTF-8; rename the file or folder"
        ) from None


def checked_counts(path: Path) -> Counts:
    """Checks a ply, off, obj or stl file and returns the triangles and vertices that it declares.

    Vertices are unknown (None) for stl, where triangles share none; both are for other formats,
    which are not checked. Raises InputError for a file that PyMeshLab must not be given to read.
    """
    suffix = path.suffix.lower()
    if suffix in (".obj", ".qobj"):
        return obj_counts(path)
    if suffix == ".off":
        return off_counts(path)
    check = {".ply": _check_ply, ".stl": _check_stl}.get(suffix)
    if check is None:
        return Counts()
    size = path.stat().st_size
    with path.open("rb") as file:
        return check(path, file.read(_HEAD_BYTES), size)


def _check_ply(path: Path, head: bytes, size: int) -> Counts:
    end = re.search(rb"^[ \t\r]*end_header([ \t\r][^\n]*)?(\n|\Z)", head, re.M)
    if end is None:
        raise InputError(
            f"{path}: has no line 'end_header' in its first {len(head):,} bytes; it is damaged, or "
            "no PLY file"
        )
    if not head.startswith(b"ply"):
        raise InputError(f"{path}: does not begin with 'ply'; it is damaged, or no PLY file")
    header = head[: end.start()]
    _check_ply_lines(path, header)
    has_doubles = re.search(rb"^[ \t]*property.*\b(double|float64)\b", header, re.M)
    form = ply_format(header)
    if form is None:
        raise InputError(
            f"{path}: the header names no format, expected ascii, binary_little_endian or "
            "binary_big_endian; the file is damaged"
        )
    if form == "binary_big_endian" and has_doubles:
        raise InputError(
            f"{path}: has big-endian numbers of 64 bits, which PyMeshLab reads wrongly; write it "
            "again as binary_little_endian"
        )
    needed = 0
    elements = ply_elements(header)
    for element in elements:
        name = legible(element.name)
        if [one.name for one in elements].count(element.name) > 1:
            raise InputError(f"{path}: the header declares {name} twice; the file is damaged")
        lists = [one for one in element.properties if one.length_code]
        if element.name == b"range_grid" or (lists and element.name not in _PLY_LIST_ELEMENTS):
            raise InputError(
                f"{path}: the element '{name}' has a list, which PyMeshLab can read for vertex and "
                "face only; write the file again without it"
            )
        least = _ply_bytes(element, form == "ascii")
        require_room(
            path, size - len(header) - needed, element.count, _PLURALS.get(name, name), least
        )
        needed += element.count * least
    return ply_counts(path, header, end.end())


def _check_ply_lines(path: Path, header: bytes) -> None:
    for number, line in enumerate(header.split(b"\n")[1:], start=2):
        words = header_words(line)
        if words and not (_is_ply_line(words) and len(line) < _PLY_LINE_BYTES):
            raise InputError(
                f"{path}: line {number} of the header is '{legible(line)}', expected a format, "
                "comment, element or property; the file is damaged"
            )


def _is_ply_line(words: list[bytes]) -> bool:
    kind, count = words[0], len(words)
    if kind in (b"comment", b"obj_info"):
        return True
    if _CONTROL.search(b"".join(words)):
        return False
    if kind == b"property" and count > 1 and words[1] == b"list":
        return count == 5 and {words[2], words[3]} <= PLY_TYPES.keys()
    if kind == b"property":
        return count == 3 and words[1] in PLY_TYPES
    if kind == b"element":
        return count == 3 and words[2].isdigit()
    return kind == b"format" and count == 3


def _ply_bytes(element: Element, is_text: bool) -> int:
    """The least that one entry of an element takes: in text a digit and a space per property."""
    if is_text or not element.properties:
        return max(1, 2 * len(element.properties))
    return sum(np.dtype(one.length_code or one.code).itemsize for one in element.properties)


def _check_stl(path: Path, head: bytes, size: int) -> Counts:
    sample = head[80 : 80 + _STL_SAMPLE_BYTES]
    if head.lstrip()[:5].lower() == b"solid" and b"\0" not in head:
        return Counts(_stl_text_facets(path))
    if size < _STL_HEADER_BYTES:
        raise InputError(f"{path}: has {size} bytes, too few for an STL file; it is damaged")
    count = int.from_bytes(head[80:84], "little")
    require_room(path, size - _STL_HEADER_BYTES + 2, count, "faces", _STL_FACE_BYTES)
    # Where the size is not what the count says, PyMeshLab takes the file for text unless it meets
    # a byte that is not ASCII, and then may never come to an end.
    if size != _STL_HEADER_BYTES + count * _STL_FACE_BYTES and max(sample) < 128:
        raise InputError(
            f"{path}: the header declares {count:,} faces, which make "
            f"{_STL_HEADER_BYTES + count * _STL_FACE_BYTES:,} bytes, but the file has {size:,}; it "
            "is damaged"
        )
    return Counts(count)


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
            f"{path}: the last line is '{legible(last_line)}', expected 'endsolid'; the file is "
            "cut short or damaged"
        )
    return facets
