# SPDX-License-Identifier: GPL-3.0-or-later
"""METIS with the least slack that it accepts."""

from __future__ import annotations

import numpy as np

from spheroseg.baselines._metis import partition
from spheroseg.dual_graph import DualGraph


def segment(
    vertices: np.ndarray, faces: np.ndarray, k: int, seed: int, *, graph: DualGraph | None = None
) -> np.ndarray:
    """Labels by METIS k-way contiguous with ufactor = 1, a slack of 0.1 %."""
    return partition(faces, k, seed, graph, recursive=False, contig=1, ufactor=1)
