# SPDX-License-Identifier: GPL-3.0-or-later
"""How many corners the faces of a PLY file have, which its header does not say."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spheroseg.text_numbers import PADDING, whole_numbers, word_begins

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
_CORNER_LISTS = (b"vertex_indices", b"vertex_index")


@dataclass(frozen=True)
class _Property:
    name: bytes
    type: np.dtype
    #: Type of the number that a list begins with.
    length_type: np.dtype | None


@dataclass(frozen=True)
class _Element:
    name: bytes
    count: int
    properties: list[_Property]

    def lists(self) -> list[_Property]:
        return [one for one in self.properties if one.length_type is not None]


def corner_counts(path: Path, header: bytes, start: int) -> np.ndarray | None:
    """Of each face, in a file whose header is sound and whose body begins at the byte `start`.

    None where the faces have no corners, or end behind the end of the file.
    """
    is_text = re.search(rb"^format\s+ascii", header, re.M) is not None
    order = ">" if re.search(rb"^format\s+binary_big", header, re.M) else "<"
    elements = _elements(header, "<i8" if is_text else None, order)
    if is_text:
        before = list(itertools.takewhile(lambda element: not element.lists(), elements))
        elements = elements[len(before) :]
        words = sum(element.count * len(element.properties) for element in before)
        data = _text_as_binary(path, start, words)
    else:
        data = _mapped(path, start)
    place = 0
    for element in elements:
        try:
            lengths, place = _list_lengths(data, place, element)
        except IndexError:
            return None
        if element.name == b"face":
            corners = [i for i, one in enumerate(element.lists()) if one.name in _CORNER_LISTS]
            return lengths[:, corners[0]] if corners else None
    return None


def _elements(header: bytes, common_type: str | None, order: str) -> list[_Element]:
    def as_type(word: bytes) -> np.dtype:
        return np.dtype(common_type or order + PLY_TYPES[word])

    elements = []
    for text in re.split(rb"^element", header, flags=re.M)[1:]:
        first, *lines = text.splitlines()
        properties = []
        for words in map(bytes.split, lines):
            if words[:2] == [b"property", b"list"]:
                properties.append(_Property(words[4], as_type(words[3]), as_type(words[2])))
            elif words[:1] == [b"property"]:
                properties.append(_Property(words[2], as_type(words[1]), None))
        elements.append(_Element(first.split()[0], int(first.split()[1]), properties))
    return elements


def _mapped(path: Path, start: int) -> np.ndarray:
    if path.stat().st_size == start:
        return np.zeros(0, dtype=np.uint8)
    return np.memmap(path, np.uint8, "r", start)


def _text_as_binary(path: Path, start: int, first_word: int) -> np.ndarray:
    """The words of a text, from one on, as 64-bit numbers."""
    with path.open("rb") as file:
        file.seek(start)
        text = np.frombuffer(file.read() + PADDING, dtype=np.uint8)
    return whole_numbers(text, np.flatnonzero(word_begins(text))[first_word:]).view(np.uint8)


def _list_lengths(data: np.ndarray, start: int, element: _Element) -> tuple[np.ndarray, int]:
    """(count, number of lists) lengths of the lists of an element, and where it ends.

    Raises IndexError when that is behind the end of the data.
    """
    lists = element.lists()
    if element.count == 0:
        return np.zeros((0, len(lists)), dtype=np.int64), start
    lengths, places, end = _walk(data, start, element, 1)
    stride = end - start
    end = start + element.count * stride
    if end <= len(data) and all(
        (np.ndarray(element.count, one.length_type, data, place, (stride,)) == length).all()
        for one, place, length in zip(lists, places, lengths, strict=True)
    ):
        return np.tile(lengths, (element.count, 1)), end
    lengths, _, end = _walk(data, start, element, element.count)
    return np.reshape(lengths, (element.count, len(lists))), end


def _walk(
    data: np.ndarray, start: int, element: _Element, count: int
) -> tuple[list[int], list[int], int]:
    """Goes from list to list: their lengths, where they begin, and where the last entry ends."""
    steps = [(one.length_type, one.type.itemsize) for one in element.properties]
    order = "big" if any(one.type.byteorder == ">" for one in element.properties) else "little"
    view = memoryview(data)
    lengths, places, place = [], [], start
    for _ in range(count):
        for length_type, size in steps:
            if length_type is None:
                place += size
                continue
            after = place + length_type.itemsize
            length = int.from_bytes(view[place:after], order, signed=length_type.kind == "i")
            places.append(place)
            lengths.append(length)
            place = after + length * size
            if length < 0:
                raise IndexError
        if place > len(view):
            raise IndexError
    return lengths, places, place
