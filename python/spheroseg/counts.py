# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a mesh file declares, to compare it with what PyMeshLab makes of it."""

from itertools import combinations
from typing import NamedTuple

import numpy as np

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
