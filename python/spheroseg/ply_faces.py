# SPDX-License-Identifier: GPL-3.0-or-later
"""The body of a PLY file: its faces, of which PyMeshLab follows most indices wherever they point.

Its reader is not told how long a list may be either, and takes the words of a text apart in its
own way; what it reads otherwise than written is refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from spheroseg.counts import Counts, name_one_twice
from spheroseg.errors import InputError
from spheroseg.text_numbers import (
    FILLING,
    PADDING,
    legible,
    no_number,
    number_kinds,
    whole_numbers,
    word_at,
    word_begins,
)

#: numpy's code of each type.
PLY_TYPES = {
    **dict.fromkeys((b"char", b"int8"), "i1"),
    **dict.fromkeys((b"uchar", b"uint8"), "u1"),
    **dict.fromkeys((b"short", b"int16"), "i2"),
    **dict.fromkeys((b"ushort", b"uint16"), "u2"),
    **dict.fromkeys((b"int", b"int32"), "i4"),
    **dict.fromkeys((b"uint", b"uint32"), "u4"),
    **dict.fromkeys((b"float", b"float32"), "f4"),
    **dict.fromkeys((b"double", b"float64"), "f8"),
}
# The types, of lengths and of indices, with which PyMeshLab reads corners; in binary files it takes
# one byte for the lengths of the last ones.
_OF_INTS = {("u1", "i4"), ("i1", "i4"), ("i4", "i4")}
_OF_OTHERS = {("u1", "u4"), ("i1", "u4"), ("u1", "i2"), ("i1", "i2")}
_OF_TEXTS = {("i4", "u4"), ("u2", "u4"), ("i4", "i2")}
_CORNER_LISTS = {
    b"face": {b"vertex_index": _OF_INTS, b"vertex_indices": _OF_INTS | _OF_OTHERS | _OF_TEXTS},
    b"tristrips": {b"vertex_indices": {("i4", "i4")}},
}
_HEADER_BYTES = 65536
_FEWEST_CORNERS, _MOST_CORNERS = 3, 255
# The room that it has for lists that it keeps, and for those that it passes over in binary files.
_KEPT_LISTS = (b"texcoord", b"color")
_KEPT_ENTRIES = 32
_SKIPPED_BYTES = 512
_ROWS_AT_A_TIME = 2**16
#: Stands for a number with a fraction.
_NOT_WHOLE = np.iinfo(np.int64).min
_NEWLINE = ord("\n")


@dataclass(frozen=True)
class Property:
    name: bytes
    #: numpy's code of the type, and of the number that a list begins with.
    code: str
    length_code: str | None


@dataclass(frozen=True)
class Element:
    name: bytes
    count: int
    properties: list[Property]


@dataclass(frozen=True)
class _Column:
    """A property in all entries of an element."""

    element: Element
    property: Property
    data: np.ndarray
    type: np.dtype
    #: Of each entry how many values it has, and where the first one is.
    lengths: np.ndarray
    places: np.ndarray

    def rows(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Entries with as many values, some at a time, and these values: (entries, length)."""
        for length in np.unique(self.lengths[self.lengths > 0]):
            windows = sliding_window_view(self.data, length * self.type.itemsize)
            entries = np.flatnonzero(self.lengths == length)
            for first in range(0, len(entries), _ROWS_AT_A_TIME):
                some = entries[first : first + _ROWS_AT_A_TIME]
                yield some, windows[self.places[some]].view(self.type)

    def entry(self, number: int) -> str:
        return f"{legible(self.element.name)} {number}"


def header_words(line: bytes) -> list[bytes]:
    """The words of a line, taken apart as PyMeshLab does it."""
    return re.findall(rb"[^ \t\r\n]+", line)


def read_ply_header(path: Path) -> bytes:
    """What stands before the line 'end_header' of a sound file."""
    with path.open("rb") as file:
        head = file.read(_HEADER_BYTES)
    return re.split(rb"^[ \t\r]*end_header", head, maxsplit=1, flags=re.M)[0]


def ply_elements(header: bytes) -> list[Element]:
    """The elements that a sound header declares."""
    elements = []
    for words in map(header_words, header.split(b"\n")):
        if words[:1] == [b"element"]:
            elements.append(Element(words[1], int(words[2]), []))
        elif words[:1] == [b"property"] and elements:
            *types, name = words[2 if words[1] == b"list" else 1 :]
            *length_code, code = (PLY_TYPES[word] for word in types)
            one = Property(name, code, length_code[0] if length_code else None)
            elements[-1].properties.append(one)
    return elements


def ply_format(header: bytes) -> str | None:
    """ascii, binary_little_endian or binary_big_endian."""
    found = re.search(
        rb"^[ \t]*format[ \t]+(ascii|binary_(little|big)_endian)[ \t\r]", header, re.M
    )
    return found and found[1].decode()


def ply_counts(path: Path, header: bytes, start: int) -> Counts:
    """Triangles that the faces make, and vertices, in a file with a sound header and its body from
    the byte `start` on.

    No triangles are known where there are no faces. Raises InputError for a list that PyMeshLab
    can not read, for a face that names a vertex that is not there, and for more than the header
    declares.
    """
    body = _Body(path, header, start)
    triangle_count, vertex_count, place = None, 0, 0
    first_odd_face = None
    for element in ply_elements(header):
        corners = body.corner_list(element)
        columns, place = body.columns(element, place)
        for column in columns:
            if body.is_text and column.property.code[0] != "f":
                _check_whole(path, column)
            if column.property is not corners:
                body.check_room(column)
            elif element.name == b"tristrips":
                _check_strips(path, column, vertex_count)
            else:
                first_odd_face = _check_faces(path, column, vertex_count)
                triangle_count = int(column.lengths.sum()) - 2 * element.count
        if element.name == b"vertex":
            vertex_count = element.count
    body.check_end(place)
    return Counts(triangle_count, vertex_count, first_odd_face)


class _Body:
    """What follows the header; of a text its words, as 64-bit numbers."""

    def __init__(self, path: Path, header: bytes, start: int):
        self.path = path
        form = ply_format(header)
        self.is_text = form == "ascii"
        self.order = "big" if form == "binary_big_endian" else "little"
        self.data = _text_as_binary(path, start) if self.is_text else _mapped(path, start)

    def corner_list(self, element: Element) -> Property | None:
        """The list with an element's corners, where it has any."""
        readable = _CORNER_LISTS.get(element.name)
        if readable is None or element.count == 0:
            return None
        found = [one for one in element.properties if one.name in readable]
        if len(found) == 1:
            types = (found[0].length_code, found[0].code)
            if types in readable[found[0].name] and (self.is_text or types not in _OF_TEXTS):
                return found[0]
        raise InputError(
            f"{self.path}: PyMeshLab can not read the corners of the element "
            f"'{legible(element.name)}' as they are declared; write the file again, with 'property "
            "list uchar int vertex_indices'"
        )

    def columns(self, element: Element, start: int) -> tuple[list[_Column], int]:
        """The lists of an element, in a text its whole numbers too, and where it ends."""
        chosen = [
            one
            for one in element.properties
            if one.length_code or (self.is_text and one.code[0] != "f")
        ]
        if element.count == 0:
            return [], start
        shape = (element.count, len(chosen))
        lengths, places, end = self._walk(element, chosen, start, 1)
        stride = end - start
        end = start + element.count * stride
        if end <= len(self.data) and all(
            (self._lengths(one, element.count, stride, place) == length).all()
            for one, length, place in zip(chosen, lengths, places, strict=True)
            if one.length_code
        ):
            lengths = np.broadcast_to(np.array(lengths, dtype=np.int64), shape)
            places = np.array(places) + stride * np.arange(element.count)[:, np.newaxis]
        else:
            lengths, places, end = self._walk(element, chosen, start, element.count)
            lengths, places = np.reshape(lengths, shape), np.reshape(places, shape)
        columns = [
            _Column(element, one, self.data, self._type(one.code), lengths[:, i], places[:, i])
            for i, one in enumerate(chosen)
        ]
        return columns, end

    def check_room(self, column: _Column) -> None:
        """Raises InputError for a list for which PyMeshLab has no room."""
        one = column.property
        if (one.name in _KEPT_LISTS) and (one.length_code, one.code) == ("u1", "f4"):
            most = _KEPT_ENTRIES
        elif one.length_code is None or self.is_text:
            return
        elif one.length_code in ("u1", "i1"):
            most = _SKIPPED_BYTES // column.type.itemsize
        else:
            most = -1
        bad = np.flatnonzero(column.lengths > most)
        if len(bad):
            raise InputError(
                f"{self.path}: {column.entry(bad[0])} has a list '{legible(one.name)}' of "
                f"{column.lengths[bad[0]]} entries, which PyMeshLab can not read; write the file "
                "again without it"
            )

    def check_end(self, end: int) -> None:
        """Raises InputError where something follows that no element has."""
        rest = self.data[end:]
        if len(rest) == 0 or not (self.is_text or rest.tobytes().strip(FILLING)):
            return
        count = f"{len(rest) // 8:,} numbers" if self.is_text else f"{len(rest):,} bytes"
        raise InputError(
            f"{self.path}: has {count} more than the elements take that the header declares; its "
            "counts are wrong, or the file is damaged"
        )

    def _type(self, code: str) -> np.dtype:
        return np.dtype("<i8" if self.is_text else code).newbyteorder(self.order)

    def _lengths(self, one: Property, count: int, stride: int, place: int) -> np.ndarray:
        kind = self._type(one.length_code)
        return np.ndarray(count, kind, self.data, place - kind.itemsize, (stride,))

    def _walk(
        self, element: Element, chosen: list[Property], start: int, count: int
    ) -> tuple[list[int], list[int], int]:
        """Goes from entry to entry: the lengths of what is chosen, its places, and the end."""
        steps = [
            (one.length_code and self._type(one.length_code), self._type(one.code).itemsize)
            + (one in chosen,)
            for one in element.properties
        ]
        view = memoryview(self.data)
        lengths, places, place = [], [], start
        for number in range(count):
            for length_type, size, is_chosen in steps:
                length = 1
                if length_type:
                    after = place + length_type.itemsize
                    length = int.from_bytes(
                        view[place:after], self.order, signed=length_type.kind == "i"
                    )
                    place = after
                if is_chosen:
                    places.append(place)
                    lengths.append(length)
                place += length * size
                if length < 0 or place > len(view):
                    raise InputError(
                        f"{self.path}: {legible(element.name)} {number} does not end within the "
                        "file, which is cut short or damaged"
                    )
        return lengths, places, place


def _check_whole(path: Path, column: _Column) -> None:
    for entries, values in column.rows():
        bad = (values == _NOT_WHOLE).any(axis=1)
        if bad.any():
            raise InputError(
                f"{path}: {column.entry(entries[bad][0])} has a fraction or an exponent in "
                f"'{legible(column.property.name)}', expected whole numbers; the file is damaged"
            )


def _check_faces(path: Path, column: _Column, vertex_count: int) -> str | None:
    """Returns the first face that names a vertex twice."""
    counts = column.lengths
    bad = np.flatnonzero((counts < _FEWEST_CORNERS) | (counts > _MOST_CORNERS))
    if len(bad):
        raise InputError(
            f"{path}: face {bad[0]} has {counts[bad[0]]} corners, expected {_FEWEST_CORNERS} to "
            f"{_MOST_CORNERS}; cut it into triangles, unless the file is damaged"
        )
    odd = [
        entries[is_odd][0]
        for entries, corners in _rows_in_range(path, column, 0, vertex_count)
        if (is_odd := name_one_twice(corners)).any()
    ]
    return column.entry(min(odd)) if odd else None


def _check_strips(path: Path, column: _Column, vertex_count: int) -> None:
    for entries, corners in _rows_in_range(path, column, -1, vertex_count):
        # As if an end stood before the first corner.
        ends = np.pad(corners == -1, ((0, 0), (1, 0)), constant_values=True)
        bad = (ends[:, :-1] & ends[:, 1:]).any(axis=1) | (ends[:, :-2] & ends[:, 2:]).any(axis=1)
        if bad.any():
            raise InputError(
                f"{path}: {column.entry(entries[bad][0])} has a strip of fewer than two corners, "
                "which PyMeshLab can not read; write the file again with faces"
            )


def _rows_in_range(
    path: Path, column: _Column, least: int, vertex_count: int
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The column's rows, each looked at before: raises InputError for an index out of range."""
    for entries, corners in column.rows():
        if corners.min() < least or corners.max() >= vertex_count:
            bad = (corners < least) | (corners >= vertex_count)
            row, corner = np.argwhere(bad)[0]
            raise InputError(
                f"{path}: {column.entry(entries[row])} names the vertex {corners[row, corner]}, "
                f"expected an index in [0, {vertex_count}); the file is damaged"
            )
        yield entries, corners


def _mapped(path: Path, start: int) -> np.ndarray:
    if path.stat().st_size <= start:
        return np.zeros(0, dtype=np.uint8)
    return np.memmap(path, np.uint8, "r", start)


def _text_as_binary(path: Path, start: int) -> np.ndarray:
    """The words of a text as 64-bit numbers."""
    with path.open("rb") as file:
        head = file.read(start)
        text = np.frombuffer(file.read().rstrip(FILLING) + PADDING, dtype=np.uint8)
    begins = np.flatnonzero(word_begins(text))
    is_whole, odd = number_kinds(text, begins)
    if odd is not None:
        place = begins[odd]
        line = 1 + head.count(b"\n") + np.count_nonzero(text[:place] == _NEWLINE)
        raise no_number(path, line, word_at(text, place))
    numbers = whole_numbers(text, begins)
    numbers[~is_whole] = _NOT_WHOLE
    return numbers.view(np.uint8)
