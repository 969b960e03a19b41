# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a mesh file declares, to compare it with what PyMeshLab makes of it."""

from typing import NamedTuple


class Counts(NamedTuple):
    """What a file declares; None where that is not known."""

    #: Triangles that all faces of the file make, polygons cut into triangles.
    triangles: int | None = None
    vertices: int | None = None
