# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods of the benchmark, each with its own clock.

A partitioner's clock covers its call alone, with the graph in its own form at hand. Ours covers
the whole filter call: reading MeshLab's mesh, checks, dual graph, hierarchy, all stages, measures
and writing the labels.
"""

import ctypes
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pymeshlab

from spheroseg import api, baselines
from spheroseg.baselines import kaminpar_exact, mtkahypar_quality
from spheroseg.bench.statistics import STAGES
from spheroseg.dual_graph import DualGraph, build_dual_graph


@dataclass(frozen=True)
class Timed:
    """Labels and wall time; `details` are the stages of our methods, or the peak memory."""

    labels: np.ndarray
    seconds: float
    details: dict[str, float] = field(default_factory=dict)


class MeshRuns:
    """One mesh with the graphs that the partitioners want, each built once."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self.vertices = vertices
        self.faces = faces
        self._graphs: dict[str, object] = {}

    def rival(self, method: str, k: int, seed: int) -> Timed:
        """A partitioner on one thread."""
        if method == "kaminpar_exact":
            graph = self._graph(
                method, lambda dual: kaminpar_exact.load_graph(self.faces, 2, 0, dual)
            )
            return _timed(lambda: kaminpar_exact.partition(graph, len(self.faces), k, seed, 1))
        if method == "mtkahypar_quality":
            graph = self._graph(
                method, lambda dual: mtkahypar_quality.load_graph(self.faces, graph=dual)
            )
            return _timed(lambda: mtkahypar_quality.partition(graph, k, seed))
        segment = baselines.load(method)
        dual = self._graph("dual", lambda dual: dual)
        segment(*api.TETRAHEDRON, 2, 0)  # loads the library
        return _timed(lambda: segment(self.vertices, self.faces, k, seed, graph=dual))

    def first_call(self, effort: str, k: int, seed: int, thread_count: int) -> Timed:
        """Ours on a mesh that the plugin has not seen."""
        return self._ours(self._unseen(), effort, k, seed, thread_count)

    def second_call(self, effort: str, k: int, seed: int, thread_count: int, before: int) -> Timed:
        """Ours on a mesh that was cut into `before` sub-meshes by the call before."""
        mesh_set = self._unseen()
        self._ours(mesh_set, "draft", before, seed, thread_count)
        return self._ours(mesh_set, effort, k, seed, thread_count)

    def memory(self, effort: str, k: int, seed: int, thread_count: int) -> Timed:
        """A first call; `peak_bytes` is its peak of resident memory less what was there before."""
        mesh_set = self._unseen()
        before = _start_of_peak()
        timed = self._ours(mesh_set, effort, k, seed, thread_count)
        return Timed(timed.labels, timed.seconds, {"peak_bytes": _memory("VmHWM") - before})

    def _graph(self, name: str, build: Callable[[DualGraph], object]) -> object:
        if "dual" not in self._graphs:
            self._graphs["dual"] = build_dual_graph(self.faces)
        if name not in self._graphs:
            self._graphs[name] = build(self._graphs["dual"])
        return self._graphs[name]

    def _unseen(self) -> pymeshlab.MeshSet:
        """A new MeshSet with the mesh, of which the plugin has prepared nothing."""
        api.forget_prepared_mesh()
        mesh_set = pymeshlab.MeshSet()
        mesh_set.add_mesh(pymeshlab.Mesh(self.vertices, self.faces))
        return mesh_set

    @staticmethod
    def _ours(mesh_set, effort: str, k: int, seed: int, thread_count: int) -> Timed:
        began = time.perf_counter()
        measures = api.run_filter(
            mesh_set,
            api.SEGMENT_FILTER,
            submesh_count=k,
            method="fast",
            effort=effort,
            seed=seed,
            thread_count=thread_count,
            colorize=False,
        )
        seconds = time.perf_counter() - began
        labels = mesh_set.current_mesh().face_scalar_array().astype(np.int32)
        return Timed(labels, seconds, {name: measures[name] for name in STAGES})


def _timed(call: Callable[[], np.ndarray]) -> Timed:
    began = time.perf_counter()
    labels = call()
    return Timed(labels, time.perf_counter() - began)


def _start_of_peak() -> int:
    """Gives freed memory back, resets the peak (Linux) and returns the resident bytes."""
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5")
    return _memory("VmRSS")


def _memory(name: str) -> int:
    status = Path("/proc/self/status").read_text()
    return 1024 * int(re.search(rf"^{name}:\s*(\d+) kB", status, re.MULTILINE)[1])
