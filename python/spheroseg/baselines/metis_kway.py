# SPDX-License-Identifier: GPL-3.0-or-later
"""METIS as the paper ran it: k-way, contiguous, all other options default."""

from __future__ import annotations

import numpy as np

from spheroseg.baselines._metis import partition
from spheroseg.dual_graph import DualGraph


def segment(
    vertices: np.ndarray, faces: np.ndarray, k: int, seed: int, *, graph: DualGraph | None = None
) -> np.ndarray:
    """Labels by METIS k-way; the default slack of 3 % limits a part to 1.03 F/k, rounded down."""
    return partition(faces, k, seed, graph, recursive=False, contig=1)
