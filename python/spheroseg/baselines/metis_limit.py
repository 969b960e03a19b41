# SPDX-License-Identifier: GPL-3.0-or-later
"""METIS with the limit per part set in triangles instead of per cent.

With few triangles per part the default slack of 3 % is less than one triangle: the limit rounds
down to F/k, and METIS's refinement can move nothing. One whole triangle of room changes that.
"""

from __future__ import annotations

import math

import numpy as np

from spheroseg.baselines._common import checked_graph
from spheroseg.baselines._metis import partition
from spheroseg.dual_graph import DualGraph


def segment(
    vertices: np.ndarray, faces: np.ndarray, k: int, seed: int, *, graph: DualGraph | None = None
) -> np.ndarray:
    """Labels by METIS k-way contiguous, at most ceil(F/k) + 1 triangles aimed at per part."""
    graph = checked_graph(faces, k, seed, graph)
    ufactor = ufactor_for_limit(len(faces), k)
    return partition(faces, k, seed, graph, recursive=False, contig=1, ufactor=ufactor)


def ufactor_for_limit(face_count: int, k: int) -> int:
    """The least ufactor u with F/k (1 + u/1000) >= ceil(F/k) + 1."""
    limit = -(-face_count // k) + 1
    return math.ceil(1000 * (limit * k - face_count) / face_count)
