# SPDX-License-Identifier: GPL-3.0-or-later
"""KaMinPar with an exact limit per part (Gottesbüren, Heuer, Sanders, Schulz, Seemaier, "Deep
multilevel graph partitioning", 2021)."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from spheroseg.baselines._common import as_labels, checked_graph, require
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
    return partition(load_graph(graph, thread_count), len(faces), k, seed, thread_count)


def prepare(vertices: np.ndarray, faces: np.ndarray, graph: DualGraph) -> Callable:
    """See `baselines.prepare`."""
    own = load_graph(graph)

    def run(k: int, seed: int) -> np.ndarray:
        checked_graph(faces, k, seed, graph)
        return partition(own, len(faces), k, seed, thread_count=1)

    return run


def load_graph(graph: DualGraph, thread_count: int = 1):
    """KaMinPar's own graph, which its package reads from files only."""
    kaminpar = require("kaminpar")
    # While a solver lives, its number of threads holds for all that KaMinPar does. Without one,
    # reading starts a thread for each core; one that is late could take part in what follows.
    limit = kaminpar.KaMinPar(thread_count, kaminpar.strong_context())
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dual.graph"
        path.write_text(metis_text(graph))
        loaded = kaminpar.load_graph(str(path), kaminpar.GraphFileFormat.METIS)
    del limit
    return loaded


def partition(kaminpar_graph, face_count: int, k: int, seed: int, thread_count: int) -> np.ndarray:
    kaminpar = require("kaminpar")
    if k == 1:
        return np.zeros(face_count, dtype=np.int32)
    floor, larger = divmod(face_count, k)
    limits = [floor + 1] * larger + [floor] * (k - larger)
    kaminpar.reseed(seed)
    solver = kaminpar.KaMinPar(thread_count, kaminpar.strong_context())
    return as_labels(solver.compute_partition(kaminpar_graph, max_block_weights=limits))


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
