# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by the baselines: input check and optional libraries."""

from __future__ import annotations

from types import ModuleType

import numpy as np

from spheroseg import packages
from spheroseg.dual_graph import DualGraph, build_dual_graph
from spheroseg.errors import InputError


def require(package: str) -> ModuleType:
    """Imports an optional library; the error says how to get it."""
    return packages.require(package, "this baseline")


def checked_graph(faces: np.ndarray, k: int, seed: int, graph: DualGraph | None) -> DualGraph:
    """Checks the arguments of every baseline and returns the dual graph."""
    face_count = len(faces)
    if not 1 <= k <= face_count:
        raise InputError(f"k must be in [1, {face_count}] (the triangle count), but is {k}")
    if seed < 0:
        raise InputError(f"seed must be >= 0, but is {seed}")
    if graph is None:
        return build_dual_graph(faces)
    if graph.face_count != face_count:
        raise InputError(
            f"the dual graph has {graph.face_count} triangles, but the mesh has {face_count}"
        )
    return graph


def int32_labels(labels) -> np.ndarray:
    """A library's sequence of labels as an int32 array."""
    return np.asarray(labels, dtype=np.int32)
