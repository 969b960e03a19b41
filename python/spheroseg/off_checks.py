# SPDX-License-Identifier: GPL-3.0-or-later
"""OFF files: PyMeshLab takes the numbers of vertices one after the other, but faces line by line,
and follows an index wherever it points.

As in `obj_checks`, numpy takes all lines apart at once.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from spheroseg.counts import Counts, first_odd_face, require_room
from spheroseg.errors import InputError
from spheroseg.text_numbers import (
    BLANK,
    FILLING,
    OF_ATOF,
    PADDING,
    legible,
    no_number,
    number_kinds,
    whole_numbers,
    word_at,
    word_begins,
)

_MOST_CORNERS = 4
_NEWLINE, _RETURN, _HASH, _ZERO = b"\n\r#0"
_PASSED_OVER = re.compile(rb"^[#\r].*", re.MULTILINE)
# Not blanks to both, Python or `word_begins` and PyMeshLab: words would not be the same.
_CONTROLS = bytes({*range(BLANK)} - {*b"\t\n"})
_ODD_BLANK = re.compile(rb"[\0-\x08\v\f\x0e-\x1f]|\r(?!\n)")


def off_counts(path: Path) -> Counts:
    """Triangles that the faces make, and vertices.

    None are known where the header is none: PyMeshLab says what is wrong. Raises InputError for
    what PyMeshLab would read otherwise than written, for a face that names a vertex that is not
    there, and for more or less than the header declares.
    """
    with path.open("rb") as file:
        lines = _header_lines(path, file)
        try:
            number, (keyword, *counts) = next(lines)
            if not counts:
                number, counts = next(lines)
        except StopIteration:
            raise _cut_short(path) from None
        if b"OFF" not in keyword or len(counts) < 3:
            return Counts()
        vertex_count = _count(path, counts[0], "vertices", 6)
        face_count = _count(path, counts[1], "faces", 4)
        body = _Body(path, file.read(), number)
    body.check_vertices(vertex_count, keyword.rpartition(b"OFF")[0])
    triangle_count, first_odd = body.check_faces(face_count, vertex_count)
    body.check_end(face_count)
    return Counts(triangle_count, vertex_count, first_odd)


def _header_lines(path: Path, file: BinaryIO) -> Iterator[tuple[int, list[bytes]]]:
    """The number of each line that PyMeshLab does not pass over, and its words."""
    for number, line in enumerate(file, start=1):
        if line[:1] in (b"#", b"\n", b"\r"):
            continue
        if _ODD_BLANK.search(line):
            raise _odd_blank(path, number)
        words = line.split()
        if not words:
            raise _only_blanks(path, number)
        yield number, words


def _count(path: Path, word: bytes, name: str, least_bytes: int) -> int:
    if not word.isdigit():
        raise InputError(
            f"{path}: the header declares {legible(word)} {name}, expected a count; the file is "
            "damaged"
        )
    require_room(path, path.stat().st_size, int(word), name, least_bytes)
    return int(word)


class _Body:
    """The lines behind the header that PyMeshLab does not pass over, taken one after the other."""

    def __init__(self, path: Path, data: bytes, lines_before: int):
        self.path = path
        self.lines_before = lines_before
        text = np.frombuffer(data + PADDING, dtype=np.uint8)
        starts = np.append(0, np.flatnonzero(text == _NEWLINE) + 1)
        starts = starts[starts < len(data)]
        first = text[starts]
        if ((first == _HASH) | (first == _RETURN)).any():
            data = _PASSED_OVER.sub(lambda line: b" " * len(line[0]), data)
            text = np.frombuffer(data + PADDING, dtype=np.uint8)
        self.data = data
        self.text = text
        starts = starts[(first != _HASH) & (first != _RETURN) & (first != _NEWLINE)]
        self.words = np.flatnonzero(word_begins(text))
        #: Of each line, and behind the last one.
        self.begins = np.append(starts, len(data))
        self.first_words = np.append(np.searchsorted(self.words, starts), len(self.words))
        self.word_counts = np.diff(self.first_words)
        self.taken = 0

    def check_vertices(self, count: int, kind: bytes) -> None:
        """`kind`: what stands before OFF: C for colours, N for normals, ST for texture
        coordinates."""
        number_count = 3 + 3 * (b"N" in kind) + 2 * (b"ST" in kind)
        word_counts = self.word_counts[self.taken :]
        if count == 0:
            line_count = 0
        elif b"C" in kind:  # as many numbers as a vertex's last line still has
            line_count = _lines_of_vertices(word_counts.tolist(), count, number_count)
        else:
            line_count = 1 + np.searchsorted(np.cumsum(word_counts), count * number_count)
        begin, end = self._take(line_count)
        comment = self.data.find(b"#", begin, end)
        if comment >= 0:
            raise InputError(
                f"{self._at(comment)}: a vertex has a comment behind it, which PyMeshLab takes for "
                "numbers; remove it"
            )
        text = np.append(self.text[begin:end], np.zeros(len(PADDING), dtype=np.uint8))
        words = self.words[np.searchsorted(self.words, begin) : np.searchsorted(self.words, end)]
        _, odd = number_kinds(text, words - begin, OF_ATOF)
        if odd is not None:
            line = self._line_number(words[odd])
            raise no_number(self.path, line, word_at(self.text, words[odd]))

    def check_faces(self, face_count: int, vertex_count: int) -> tuple[int, str | None]:
        """How many triangles the faces make, and the first that names a vertex twice, or fewer
        than three."""
        lines = self._lines_of_faces(face_count)
        begin, end = self._take(lines[-1] - lines[0])
        words = self.first_words[lines]
        faces, named = words[:-1], np.diff(words) - 1
        counts = whole_numbers(self.text, self.words[faces])
        is_index = self._have_only_figures(begin, end)
        if (bad := ~is_index[faces] | (counts < 2) | (counts > _MOST_CORNERS)).any():
            word = self.words[faces[bad.argmax()]]
            raise InputError(
                f"{self._at(word)}: a face has {word_at(self.text, word)} corners, and PyMeshLab "
                f"reads off files with 2 to {_MOST_CORNERS}; write it as ply or obj"
            )
        if (bad := named < counts).any():
            face = bad.argmax()
            raise InputError(
                f"{self._at(self.words[faces[face]])}: a face of {counts[face]} corners names "
                f"{named[face]}; the file is damaged"
            )
        if (bad := named == counts + 1).any():
            raise InputError(
                f"{self._at(self.words[faces[bad.argmax()]])}: a face has one number behind its "
                "corners, an index of a colour, which PyMeshLab can not read; remove it, or give "
                "the colour itself, as three numbers"
            )
        # Of each corner its place behind the number of corners, and so its word.
        places = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        corners = np.repeat(faces, counts) + 1 + places
        vertices = whole_numbers(self.text, self.words[corners])
        if (bad := ~is_index[corners] | (vertices >= vertex_count)).any():
            word = self.words[corners[bad.argmax()]]
            raise InputError(
                f"{self._at(word)}: a face names the vertex '{word_at(self.text, word)}', expected "
                f"an index in [0, {vertex_count}); the file is damaged"
            )
        odd = first_odd_face(counts, vertices)
        first_odd = None if odd is None else f"line {self._line_number(self.words[faces[odd]])}"
        # A face of two corners counts as one triangle, which PyMeshLab does not make.
        return int(np.maximum(counts - 2, 1).sum()), first_odd

    def check_end(self, face_count: int) -> None:
        more = self.data[self.begins[self.taken] :].strip(FILLING)
        if more:
            line = legible(more.splitlines()[0])
            raise InputError(
                f"{self.path}: goes on with '{line}' behind the {face_count:,} faces that "
                "the header declares; its counts are wrong, or the file is damaged"
            )

    def _lines_of_faces(self, count: int) -> list[int]:
        """Where each face begins, and where the last one ends; beyond the last line where the body
        has too few."""
        is_alone = (self.word_counts[self.taken :] == 1).tolist() + [False] * count
        lines = [self.taken]
        for _ in range(count):
            # The corners stand in the next line where their number stands alone.
            lines.append(lines[-1] + 1 + is_alone[lines[-1] - self.taken])
        return lines

    def _take(self, count: int) -> tuple[int, int]:
        """The bytes where the next lines begin and end. Raises InputError where there are too few,
        or some that PyMeshLab can not read."""
        first, end = self.taken, self.taken + count
        line_count = len(self.word_counts)
        begin_byte, end_byte = self.begins[[first, min(end, line_count)]].tolist()
        data = self.data[begin_byte:end_byte]
        if len(data.translate(None, _CONTROLS)) < len(data):  # faster than what follows
            odd = _ODD_BLANK.search(data)
            if odd:
                raise _odd_blank(self.path, self._line_number(begin_byte + odd.start()))
        blank = np.flatnonzero(self.word_counts[first:end] == 0)
        if len(blank):
            raise _only_blanks(self.path, self._line_number(self.begins[first + blank[0]]))
        if end > line_count:
            raise _cut_short(self.path)
        self.taken = end
        return begin_byte, end_byte

    def _have_only_figures(self, begin: int, end: int) -> np.ndarray:
        """Of each word whether it has nothing else between these bytes."""
        text = self.text[begin:end]
        others = begin + np.flatnonzero((text > BLANK) & (text - np.uint8(_ZERO) >= 10))
        have = np.ones(len(self.words), dtype=bool)
        have[np.searchsorted(self.words, others, side="right") - 1] = False
        return have

    def _line_number(self, byte: int) -> int:
        return self.lines_before + 1 + self.data.count(b"\n", 0, byte)

    def _at(self, byte: int) -> str:
        return f"{self.path}: line {self._line_number(byte)}"


def _lines_of_vertices(word_counts: list[int], count: int, number_count: int) -> int:
    """How many lines they take where a vertex begins in a line of its own; more than there are
    where these are too few."""
    line = 0
    for _ in range(count):
        missing = number_count
        while missing > 0:
            missing -= word_counts[line] if line < len(word_counts) else missing
            line += 1
    return line


def _odd_blank(path: Path, line: int) -> InputError:
    return InputError(
        f"{path}: line {line} has control characters between its words; the file is damaged"
    )


def _only_blanks(path: Path, line: int) -> InputError:
    return InputError(
        f"{path}: line {line} has nothing but blanks, which PyMeshLab can not read in off files; "
        "remove it"
    )


def _cut_short(path: Path) -> InputError:
    return InputError(
        f"{path}: ends before all vertices and faces that the header declares; the file is cut "
        "short or damaged"
    )
