# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a mesh file declares, to compare it with what PyMeshLab makes of it."""

from typing import NamedTuple


class Counts(NamedTuple):
    """None: not known."""

    #: That the faces make, were none left out.
    triangles: int | None = None
    vertices: int | None = None
