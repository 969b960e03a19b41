# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers in OBJ files: PyMeshLab reads what is none as something else, and follows indices
wherever they point.

numpy takes many lines apart at a time: a loop of Python's takes longer than PyMeshLab's reading.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spheroseg.counts import Counts, first_odd_face
from spheroseg.errors import InputError
from spheroseg.text_numbers import (
    BLANK,
    OF_ATOF,
    PADDING,
    no_number,
    number_kinds,
    others_than,
    whole_numbers,
    word_at,
    word_begins,
)
from spheroseg.textures import content_of, material_libraries

_BLOCK_BYTES = 2**20
_END = b"\n#" + PADDING
# Blanks for `word_begins`, but not for PyMeshLab.
_CONTROLS = bytes({*range(BLANK)} - {*b"\t\n\r"})
_NEWLINE, _SLASH, _HASH, _FACE, _QUAD, _VERTEX, _PLUS, _MINUS = b"\n/#fqv+-"
# Behind the coordinates that PyMeshLab reads: two for vt, three for v and vn.
_COMMENT = re.compile(
    rb"^([ \t\r]*v(?:t|n?[ \t\r]+\S+)(?:[ \t\r]+\S+){2,}?[ \t\r])#.*", re.MULTILINE
)
# A line that goes on, with what it goes on with.
_CONTINUED = re.compile(rb"^(?:.*\\\r?\n)+.*", re.MULTILINE)
# PyMeshLab counts lines that begin with v and a blank, or with vt or vn, before it joins them.
_MISCOUNTED = re.compile(
    rb"^[ \t]*v[tn]?\\\r?\n|((?<=\\\n)|(?<=\\\r\n))[ \t]*v[tn \t]", re.MULTILINE
)
# Lines of a library of materials behind which PyMeshLab reads a value.
_VALUELESS = re.compile(rb"^[ \t\r]*(d|Tr|Ns|illum)[ \t\r]*$", re.MULTILINE)
_OF_INDICES = b" \t\n\r0123456789+-/\0"


@dataclass
class _Kind:
    """What a face can name, how often it was defined so far, and how it was named."""

    name: str
    second_letter: str
    count: int = 0
    #: The largest index, and the byte at which its line begins.
    largest: tuple[int, int] = (0, 0)
    #: The first index that is 0 or counts back beyond the first of the kind, and its line.
    bad: tuple[int, int] | None = None

    def defined_by(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        """The lines that begin with these two letters and define one."""
        end = second == ord(self.second_letter) if self.second_letter else second <= BLANK
        return (first == _VERTEX) & end

    def check(self, path: Path) -> None:
        index, place = self.bad or self.largest
        if self.bad or index > self.count:
            raise InputError(
                f"{path}: line {_line_number(path, place)}: a face names the {self.name} {index}, "
                f"expected an index from 1 to {self.count}; the file is damaged"
            )


def obj_counts(path: Path) -> Counts:
    """Triangles that the faces make, and vertices.

    Raises InputError for a word that should be a number and is none, and when a face names a
    vertex, texture coordinate or normal that is not there.
    """
    kinds = (_Kind("vertex", ""), _Kind("texture coordinate", "t"), _Kind("normal", "n"))
    triangle_count = place = 0
    odd_places = []
    libraries = [path.with_suffix(".mtl")]  # for a file that names none
    for block in _blocks(path):
        count, odd_place = _read(path, block, place, kinds)
        triangle_count += count
        place += len(block)
        if odd_place is not None:
            odd_places.append(odd_place)
        if b"mtllib" in block:
            libraries += material_libraries(block, path)
    for library in dict.fromkeys(libraries):
        _check_materials(library)
    vertex, texture, normal = kinds
    if vertex.count == 0:
        raise InputError(f"{path}: has no vertices; it is empty, damaged, or no OBJ file")
    vertex.check(path)
    if texture.count > 0:
        texture.check(path)
    if normal.count == vertex.count:  # PyMeshLab takes no others
        normal.check(path)
    first_odd = f"line {_line_number(path, odd_places[0])}" if odd_places else None
    return Counts(triangle_count, vertex.count, first_odd)


def _check_materials(library: Path) -> None:
    """Raises InputError for a library of materials that PyMeshLab would read beyond a line."""
    content = content_of(library) or b""
    if valueless := _VALUELESS.search(content):
        line = 1 + content.count(b"\n", 0, valueless.start())
        raise InputError(
            f"{library}: line {line}: '{valueless[1].decode()}' has no value, which PyMeshLab can "
            "not read; remove the line"
        )


def _blocks(path: Path) -> Iterator[bytes]:
    """Whole lines, each with those that continue it."""
    with path.open("rb") as file:
        while block := file.read(_BLOCK_BYTES) + file.readline():
            while block.endswith((b"\\\n", b"\\\r\n")) and (more := file.readline()):
                block += more
            yield block


def _line_number(path: Path, place: int) -> int:
    with path.open("rb") as file:
        return 1 + file.read(place).count(b"\n")


def _read(path: Path, block: bytes, place: int, kinds: tuple[_Kind, ...]) -> tuple[int, int | None]:
    """Adds what a block, at this place of the file, defines and names.

    Returns how many triangles its faces make, and the place of the first face that names a vertex
    twice, or fewer than three.
    """
    if b"\\" in block:
        if crlf := re.search(rb"\\\r?\n[^\n]*\r(\n|$)", block):
            raise InputError(
                f"{path}: line {_line_number(path, place + crlf.start())}: goes on in the next "
                "one, which PyMeshLab can read with Unix line ends only; convert them"
            )
        if miscounted := _MISCOUNTED.search(block):
            raise InputError(
                f"{path}: line {_line_number(path, place + miscounted.start())}: begins with 'v' "
                "and goes on right behind it, or is where the line before goes on, which PyMeshLab "
                "can not read; write each in one line"
            )
        block = _CONTINUED.sub(_joined, block)
    _check_controls(path, block, place)
    if b"#" in block:
        block = _COMMENT.sub(lambda line: line[1].ljust(len(line[0])), block)
    text = np.frombuffer(b"\n" + block.removesuffix(b"\n") + _END, dtype=np.uint8)
    keywords = _keywords(text)
    places = keywords + (place - 1)
    first, second = text[keywords], text[keywords + 1]
    defined = [kind.defined_by(first, second) for kind in kinds]
    odd = keywords[(defined[1] | defined[2]) & (text[keywords + 2] > BLANK)]
    if len(odd):
        word = word_at(text, odd[0])
        raise InputError(
            f"{path}: line {_line_number(path, place + odd[0] - 1)}: begins with '{word}', which "
            f"PyMeshLab counts as '{word[:2]}', but does not read; remove it, or put a blank "
            f"behind '{word[:2]}'"
        )
    indented = places[defined[0] & (text[keywords - 1] != _NEWLINE)]
    if len(indented):
        raise InputError(
            f"{path}: line {_line_number(path, indented[0])}: a vertex has blanks before its 'v', "
            "which PyMeshLab can not read; remove them"
        )
    lengths = np.diff(keywords, append=len(text))
    _check_coordinates(path, text[keywords[0] :], lengths, np.any(defined, axis=0), places)
    is_face = ((first == _FACE) | (first == _QUAD)) & (second <= BLANK)
    faces = _Faces(text[keywords[0] :][np.repeat(is_face, lengths)], lengths[is_face])
    commented = faces.with_comment()
    if commented is not None:
        raise InputError(
            f"{path}: line {_line_number(path, places[is_face][commented])}: a face has a comment "
            "behind it, which PyMeshLab takes for a corner; remove it"
        )
    odd = faces.odd_corner()
    if odd is not None:
        owner, word = odd
        raise InputError(
            f"{path}: line {_line_number(path, places[is_face][owner])}: a face names '{word}', "
            "expected whole numbers, with slashes between those of a corner; the file is damaged"
        )
    odd_place = None
    for kind, lines, (owners, indices) in zip(kinds, defined, faces.indices(), strict=True):
        counts = kind.count + np.cumsum(lines)
        kind.count = int(counts[-1])
        if len(indices) == 0:
            continue
        line_places = places[is_face][owners]
        bad = (indices == 0) | (-indices > counts[is_face][owners])
        if kind.bad is None and bad.any():
            kind.bad = int(indices[bad][0]), int(line_places[bad][0])
        last = indices.argmax()
        kind.largest = max(kind.largest, (int(indices[last]), int(line_places[last])))
        if kind.name == "vertex":
            from_front = np.where(indices < 0, counts[is_face][owners] + 1 + indices, indices)
            odd_face = first_odd_face(faces.corner_counts, from_front)
            if odd_face is not None:
                odd_place = int(places[is_face][odd_face])
    return faces.triangle_count(), odd_place


def _joined(lines: re.Match[bytes]) -> bytes:
    """One line as long as all of them, joined as PyMeshLab does it."""
    return re.sub(rb"\\\r?\n", b"", lines[0]).ljust(len(lines[0]))


def _check_controls(path: Path, block: bytes, place: int) -> None:
    if len(block.translate(None, _CONTROLS)) == len(block):
        return
    for line in re.finditer(rb"^[\0-\t\v-\x20]*[fqv].*", block, re.M):
        if line[0].translate(None, _CONTROLS) != line[0]:
            raise InputError(
                f"{path}: line {_line_number(path, place + line.start())}: a vertex or face has "
                "control characters between its words; the file is damaged"
            )


def _check_coordinates(
    path: Path, text: np.ndarray, lengths: np.ndarray, is_chosen: np.ndarray, places: np.ndarray
) -> None:
    """`is_chosen`: the lines of vertices, texture coordinates and normals."""
    text = np.concatenate((text[np.repeat(is_chosen, lengths)], np.zeros(len(PADDING), np.uint8)))
    ends = np.cumsum(lengths[is_chosen])
    starts = ends - lengths[is_chosen]
    for letter in (starts, starts + 1):  # of the keyword; behind a v there is a blank
        text[letter] = BLANK
    begins = np.flatnonzero(word_begins(text))
    _, odd = number_kinds(text, begins, OF_ATOF)
    if odd is not None:
        owner = np.searchsorted(ends, begins[odd], side="right")
        line = _line_number(path, places[is_chosen][owner])
        raise no_number(path, line, word_at(text, begins[odd]))


def _keywords(text: np.ndarray) -> np.ndarray:
    """Where the first words of the lines begin."""
    starts = np.flatnonzero(text == _NEWLINE) + 1
    starts = starts[starts < len(text)]
    if (text[starts] <= BLANK).any():
        ink = np.flatnonzero(text > BLANK)
        starts = np.unique(ink[np.searchsorted(ink, starts)])
    return starts


class _Faces:
    """Lines of faces, one after the other."""

    def __init__(self, text: np.ndarray, lengths: np.ndarray):
        self.text = np.concatenate((text, np.zeros(len(PADDING), dtype=np.uint8)))
        self.starts = starts = np.cumsum(lengths) - lengths
        self.is_quad = self.text[starts] == _QUAD
        begins = word_begins(self.text)
        begins[starts] = False
        self.text[starts] = BLANK  # instead of the keywords
        self.corners = np.flatnonzero(begins)
        self.corner_counts = np.add.reduceat(begins, starts, dtype=np.int64)
        self.owners = np.repeat(np.arange(len(starts)), self.corner_counts)

    def with_comment(self) -> int | None:
        """The first face with a comment behind its corners."""
        comments = np.flatnonzero(self.text == _HASH)
        if len(comments) == 0:
            return None
        return int(np.searchsorted(self.starts, comments[0], side="right")) - 1

    def odd_corner(self) -> tuple[int, str] | None:
        """The first corner that is no whole numbers with slashes between: its face, and itself."""
        signs = np.flatnonzero((self.text == _PLUS) | (self.text == _MINUS))
        before = self.text[signs - 1]
        odd = signs[(before > BLANK) & (before != _SLASH)]
        odd = np.append(odd, others_than(_OF_INDICES, self.text))
        if len(odd) == 0:
            return None
        corner = np.searchsorted(self.corners, odd.min(), side="right") - 1
        return int(self.owners[corner]), word_at(self.text, self.corners[corner])

    def triangle_count(self) -> int:
        return int(np.maximum(self.corner_counts - 2, 1).sum())

    def indices(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Of vertices, texture coordinates and normals: the line of each index, and the index."""
        # A line that begins with q counts from 0.
        yield self.owners, whole_numbers(self.text, self.corners) + self.is_quad[self.owners]
        slashes = np.flatnonzero(self.text == _SLASH)
        corner = np.searchsorted(self.corners, slashes) - 1
        is_second = np.diff(corner, prepend=-1) == 0
        after = self.text[slashes + 1]
        is_texture = ~is_second & (after > BLANK) & (after != _SLASH)
        for chosen in (is_texture, is_second):
            yield self.owners[corner[chosen]], whole_numbers(self.text, slashes[chosen] + 1)
