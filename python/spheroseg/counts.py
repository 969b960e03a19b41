# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a mesh file declares, to compare it with what PyMeshLab makes of it."""

from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from spheroseg.errors import InputError

# More corners are compared in order, as there are too many pairs.
_FEW_CORNERS = 4


class Counts(NamedTuple):
    """What a file declares; None where that is not known."""

    #: Triangles that all faces of the file make, polygons cut into triangles.
    triangles: int | None = None
    vertices: int | None = None
    #: The first face that names a vertex twice, or fewer than three: 'face 3', or 'line 12'.
    first_odd_face: str | None = None


def name_one_twice(corners: np.ndarray) -> np.ndarray:
    """(faces,) bool: whether a face names a vertex twice; corners: (faces, 2 or more)."""
    if corners.shape[1] > _FEW_CORNERS:
        return (np.diff(np.sort(corners)) == 0).any(axis=1)
    return np.logical_or.reduce([one == other for one, other in combinations(corners.T, 2)])


def first_odd_face(corner_counts: np.ndarray, vertices: np.ndarray) -> int | None:
    """The first face that names a vertex twice, or fewer than three; vertices: of each corner, of
    one face after the other."""
    is_odd = corner_counts < 3
    begins = np.cumsum(corner_counts) - corner_counts
    for count in np.unique(corner_counts[~is_odd]):
        faces = np.flatnonzero(corner_counts == count)
        is_odd[faces] = name_one_twice(vertices[begins[faces, np.newaxis] + np.arange(count)])
    return int(is_odd.argmax()) if is_odd.any() else None


def require_room(path: Path, available: int, count: int, name: str, least_bytes: int) -> None:
    """Raises InputError where so many bytes can not hold what a header declares."""
    # The last line of a text needs no end.
    if count * least_bytes > available + 1:
        raise InputError(
            f"{path}: the header declares {count:,} {name}, but there are only {available:,} bytes "
            "for them; the file is cut short or damaged"
        )
