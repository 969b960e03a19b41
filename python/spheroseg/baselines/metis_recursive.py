# SPDX-License-Identifier: GPL-3.0-or-later
"""METIS by recursive bisection."""

from __future__ import annotations

import numpy as np

from spheroseg.baselines._metis import partition
from spheroseg.dual_graph import DualGraph


def segment(
    vertices: np.ndarray, faces: np.ndarray, k: int, seed: int, *, graph: DualGraph | None = None
) -> np.ndarray:
    """Labels by METIS's recursive bisection, which has no contiguity option."""
    return partition(faces, k, seed, graph, recursive=True)
