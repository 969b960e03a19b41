# SPDX-License-Identifier: GPL-3.0-or-later
"""Mt-KaHyPar's `quality` preset with 3 % slack (Gottesbüren, Heuer, Maas, Sanders, Schlag,
"Scalable high-quality hypergraph partitioning", 2024): the quality to beat."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np

from spheroseg.baselines._common import checked_graph, int32_labels, require
from spheroseg.dual_graph import DualGraph

SLACK = 0.03


def segment(
    vertices: np.ndarray,
    faces: np.ndarray,
    k: int,
    seed: int,
    *,
    graph: DualGraph | None = None,
    thread_count: int = 1,
) -> np.ndarray:
    """Labels by Mt-KaHyPar, neither balanced nor always connected. The library sets its threads
    once per process: another `thread_count` later is a RuntimeError. The preset carries state from
    call to call: the same labels again only on one thread and after the same calls, as in a fresh
    process."""
    graph = checked_graph(faces, k, seed, graph)
    if k == 1:
        return np.zeros(graph.face_count, dtype=np.int32)
    return partition(load_graph(graph, thread_count), k, seed)


def prepare(vertices: np.ndarray, faces: np.ndarray, graph: DualGraph) -> Callable:
    """See `baselines.prepare`."""
    own = load_graph(graph, thread_count=1)

    def run(k: int, seed: int) -> np.ndarray:
        checked_graph(faces, k, seed, graph)
        return partition(own, k, seed) if k > 1 else np.zeros(len(faces), dtype=np.int32)

    return run


def load_graph(graph: DualGraph, thread_count: int):
    """Mt-KaHyPar's own graph, which its package makes of Python tuples, and its preset."""
    mtkahypar = require("mtkahypar")
    initializer = _initializer(thread_count)
    context = initializer.context_from_preset(mtkahypar.PresetType.QUALITY)
    context.logging = False
    edges = [tuple(edge) for edge in graph.edges().tolist()]
    return initializer.create_graph(context, graph.face_count, len(edges), edges), context


def partition(loaded, k: int, seed: int) -> np.ndarray:
    """Labels for 2 parts or more of what `load_graph` returned."""
    mtkahypar = require("mtkahypar")
    mtkahypar_graph, context = loaded
    mtkahypar.set_seed(seed)
    context.set_partitioning_parameters(k, SLACK, mtkahypar.Objective.CUT)
    return int32_labels(mtkahypar_graph.partition(context).get_partition())


_initialized_threads: list[int] = []


@functools.lru_cache(maxsize=1)
def _initializer(thread_count: int):
    if _initialized_threads and _initialized_threads[0] != thread_count:
        raise RuntimeError(
            f"Mt-KaHyPar runs on {_initialized_threads[0]} thread(s) in this process; "
            f"start a new process for {thread_count}"
        )
    _initialized_threads.append(thread_count)
    return require("mtkahypar").initialize(thread_count, False)
