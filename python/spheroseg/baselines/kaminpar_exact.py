# SPDX-License-Identifier: GPL-3.0-or-later
"""KaMinPar with an exact limit per part (Gottesbüren, Heuer, Sanders, Schulz, Seemaier, "Deep
multilevel graph partitioning", 2021)."""

from __future__ import annotations

import functools
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from spheroseg.baselines._common import checked_graph, int32_labels, require
from spheroseg.dual_graph import DualGraph


def segment(
    vertices: np.ndarray,
    faces: np.ndarray,
    k: int,
    seed: int,
    *,
    graph: DualGraph | None = None,
    thread_count: int = 1,
) -> np.ndarray:
    """Labels by KaMinPar `strong`: the first F mod k parts hold at most ceil(F/k) triangles, the
    others floor(F/k), so every part is exactly full. The same labels again only on one thread."""
    graph = checked_graph(faces, k, seed, graph)
    solver = _solver(thread_count)
    return partition(solver, load_graph(graph), len(faces), k, seed)


def prepare(vertices: np.ndarray, faces: np.ndarray, graph: DualGraph) -> Callable:
    """See `baselines.prepare`."""
    _solver(1)
    own = load_graph(graph)

    def run(k: int, seed: int) -> np.ndarray:
        checked_graph(faces, k, seed, graph)
        return partition(_solver(1), own, len(faces), k, seed)

    return run


@functools.lru_cache(maxsize=1)
def _solver(thread_count: int):
    """Kept, and made before a graph is read: while it lives, its number of threads holds for all
    that KaMinPar does. Without one, KaMinPar starts a thread for each core."""
    kaminpar = require("kaminpar")
    return kaminpar.KaMinPar(thread_count, kaminpar.strong_context())


def load_graph(graph: DualGraph):
    """KaMinPar's own graph, which its package reads from files only."""
    kaminpar = require("kaminpar")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dual.graph"
        path.write_text(metis_text(graph))
        return kaminpar.load_graph(str(path), kaminpar.GraphFileFormat.METIS)


def partition(solver, kaminpar_graph, face_count: int, k: int, seed: int) -> np.ndarray:
    if k == 1:
        return np.zeros(face_count, dtype=np.int32)
    floor, larger = divmod(face_count, k)
    limits = [floor + 1] * larger + [floor] * (k - larger)
    require("kaminpar").reseed(seed)
    return int32_labels(solver.compute_partition(kaminpar_graph, max_block_weights=limits))


def metis_text(graph: DualGraph) -> str:
    """The graph in METIS's text format: one line of 1-based neighbours per triangle."""
    numbers = (graph.adjacent + 1).tolist()
    bounds = graph.starts.tolist()
    lines = [f"{graph.face_count} {len(numbers) // 2}"]
    lines += [
        " ".join(map(str, numbers[first:last]))
        for first, last in zip(bounds[:-1], bounds[1:], strict=True)
    ]
    return "\n".join(lines) + "\n"
