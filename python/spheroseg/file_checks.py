# SPDX-License-Identifier: GPL-3.0-or-later
"""What PyMeshLab must not be given to read.

It makes room for what a header declares before it reads on, so that a header of a few bytes could
ask for all memory or keep it busy for hours; and some damage ends the process.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from spheroseg.counts import Counts
from spheroseg.errors import InputError, shown
from spheroseg.obj_checks import obj_counts
from spheroseg.ply_faces import (
    FILLING,
    PLY_TYPES,
    Element,
    header_words,
    ply_counts,
    ply_elements,
    ply_format,
)
from spheroseg.text_numbers import OF_ATOF, PADDING, no_number, number_kinds, word_at, word_begins

#: Of the formats that `checked_counts` knows.
CHECKED_SUFFIXES = (".ply", ".off", ".obj", ".qobj", ".stl")
_HEAD_BYTES = 65536
_BLOCK_BYTES = 2**22
_PLY_LINE_BYTES = 510  # PyMeshLab takes the rest for a line of its own
_PLY_LIST_ELEMENTS = (b"vertex", b"face", b"tristrips")
_PLURALS = {"vertex": "vertices", "face": "faces"}
_OFF_CORNERS = 4
# Blanks for Python, but not for PyMeshLab: words would not be the same.
_ODD_BLANK = re.compile(rb"[\v\f]|\r(?!\n)")
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
    check = {".ply": _check_ply, ".off": _check_off, ".stl": _check_stl}.get(suffix)
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
        name = _shown([element.name])
        if [one.name for one in elements].count(element.name) > 1:
            raise InputError(f"{path}: the header declares {name} twice; the file is damaged")
        lists = [one for one in element.properties if one.length_code]
        if element.name == b"range_grid" or (lists and element.name not in _PLY_LIST_ELEMENTS):
            raise InputError(
                f"{path}: the element '{name}' has a list, which PyMeshLab can read for vertex and "
                "face only; write the file again without it"
            )
        least = _ply_bytes(element, form == "ascii")
        _require(path, size - len(header) - needed, element.count, _PLURALS.get(name, name), least)
        needed += element.count * least
    return ply_counts(path, header, end.end())


def _check_ply_lines(path: Path, header: bytes) -> None:
    for number, line in enumerate(header.split(b"\n")[1:], start=2):
        words = header_words(line)
        if words and not (_is_ply_line(words) and len(line) < _PLY_LINE_BYTES):
            raise InputError(
                f"{path}: line {number} of the header is '{_shown([line])}', expected a format, "
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


def _check_off(path: Path, _: bytes, size: int) -> Counts:
    """Follows PyMeshLab, which takes the numbers of vertices one after the other, but faces line by
    line, and follows an index beyond the vertices."""
    with path.open("rb") as file:
        lines = _off_lines(path, file)
        try:
            keyword, *counts = next(lines)[1]
            counts = counts or next(lines)[1]
            if b"OFF" not in keyword or len(counts) < 3:
                return Counts()  # PyMeshLab says what is wrong
            vertex_count = _off_count(path, size, counts[0], "vertices", 6)
            face_count = _off_count(path, size, counts[1], "faces", 4)
            _check_off_vertices(path, lines, vertex_count, keyword.rpartition(b"OFF")[0])
            corners, first_odd_face = _off_corner_counts(path, lines, face_count, vertex_count)
        except StopIteration:
            raise InputError(
                f"{path}: ends before all vertices and faces that the header declares; the file "
                "is cut short or damaged"
            ) from None
        for line in file:
            if line.strip(FILLING) and not line.startswith(b"#"):
                raise InputError(
                    f"{path}: goes on with '{_shown([line.strip()])}' behind the {face_count:,} "
                    "faces that the header declares; its counts are wrong, or the file is damaged"
                )
    return Counts(_triangle_count(corners), vertex_count, first_odd_face)


_Line = tuple[int, list[bytes]]


def _off_lines(path: Path, file: BinaryIO) -> Iterator[_Line]:
    """The number of each line that PyMeshLab does not pass over, and its words."""
    for number, line in enumerate(file, start=1):
        if line[:1] in (b"#", b"\n", b"\r"):
            continue
        if _ODD_BLANK.search(line):
            raise InputError(
                f"{path}: line {number} has control characters between its words; the file is "
                "damaged"
            )
        words = line.split()
        if not words:
            raise InputError(
                f"{path}: line {number} has nothing but blanks, which PyMeshLab can not read in "
                "off files; remove it"
            )
        yield number, words


def _off_count(path: Path, size: int, word: bytes, name: str, least_bytes: int) -> int:
    if not word.isdigit():
        raise InputError(
            f"{path}: the header declares {_shown([word])} {name}, expected a count; the file is "
            "damaged"
        )
    _require(path, size, int(word), name, least_bytes)
    return int(word)


def _check_off_vertices(path: Path, lines: Iterator[_Line], count: int, kind: bytes) -> None:
    """`kind`: what stands before OFF: C for colours, N for normals, ST for texture coordinates."""
    number_count = 3 + 3 * (b"N" in kind) + 2 * (b"ST" in kind)
    left = 0
    text, line_numbers = bytearray(), []
    for _ in range(count):
        missing = number_count
        while left < missing:
            missing -= left
            number, words = next(lines)
            left = len(words)
            line_numbers.append(number)
            text += b" ".join(words) + b"\n"
        # Colours are as many numbers as the line still has.
        left = 0 if b"C" in kind else left - missing
    comment = text.find(b"#")
    if comment >= 0:
        line = line_numbers[text.count(b"\n", 0, comment)]
        raise InputError(
            f"{path}: line {line}: a vertex has a comment behind it, which PyMeshLab takes for "
            "numbers; remove it"
        )
    _check_off_numbers(path, text, line_numbers)


def _check_off_numbers(path: Path, text: bytes, line_numbers: list[int]) -> None:
    """`line_numbers`: of each line of the text in the file."""
    data = np.frombuffer(text + PADDING, dtype=np.uint8)
    begins = np.flatnonzero(word_begins(data))
    _, odd = number_kinds(data, begins, OF_ATOF)
    if odd is not None:
        place = begins[odd]
        raise no_number(path, line_numbers[text.count(b"\n", 0, place)], word_at(data, place))


def _off_corner_counts(
    path: Path, lines: Iterator[_Line], face_count: int, vertex_count: int
) -> tuple[list[int], str | None]:
    """Of each face, and the first one that names a vertex twice, or fewer than three."""
    counts, first_odd_face = [], None
    for _ in range(face_count):
        number, corners = _off_corners(path, lines, vertex_count)
        counts.append(len(corners))
        if first_odd_face is None and len(set(corners)) < max(3, len(corners)):
            first_odd_face = f"line {number}"
    return counts, first_odd_face


def _off_corners(path: Path, lines: Iterator[_Line], vertex_count: int) -> tuple[int, list[int]]:
    """The line where a face begins, and the vertices that it names."""
    number, (count, *words) = next(lines)
    words = words or next(lines)[1]
    corner_count = int(count) if count.isdigit() else 0
    if not 2 <= corner_count <= _OFF_CORNERS:
        raise InputError(
            f"{path}: line {number}: a face has {_shown([count])} corners, and PyMeshLab reads off "
            f"files with 2 to {_OFF_CORNERS}; write it as ply or obj"
        )
    if len(words) < corner_count:
        raise InputError(
            f"{path}: line {number}: a face of {corner_count} corners names {len(words)}; the file "
            "is damaged"
        )
    corners = []
    for word in words[:corner_count]:
        if not word.isdigit() or int(word) >= vertex_count:
            raise InputError(
                f"{path}: line {number}: a face names the vertex '{_shown([word])}', expected an "
                f"index in [0, {vertex_count}); the file is damaged"
            )
        corners.append(int(word))
    return number, corners


def _check_stl(path: Path, head: bytes, size: int) -> Counts:
    sample = head[80 : 80 + _STL_SAMPLE_BYTES]
    if head.lstrip()[:5].lower() == b"solid" and b"\0" not in head:
        return Counts(_stl_text_facets(path))
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
