# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods of the benchmark, each with its own clock.

A partitioner's clock covers its call alone, with the graph in its own form at hand. Ours covers
the whole filter call: reading MeshLab's mesh, checks, dual graph, hierarchy, all stages, measures
and writing the labels.
"""

import ctypes
import functools
import re
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pymeshlab

from spheroseg import api, baselines
from spheroseg.bench.statistics import STAGES
from spheroseg.dual_graph import DualGraph, build_dual_graph


@dataclass(frozen=True)
class Timed:
    """Labels and wall time; `details` are the stages of our methods, or the peak memory."""

    labels: np.ndarray
    seconds: float
    details: dict[str, float] = field(default_factory=dict)


class MeshRuns:
    """One mesh with what the partitioners want of it, each made once."""

    def __init__(self, vertices: np.ndarray, faces: np.ndarray):
        self.vertices = vertices
        self.faces = faces
        self._rivals: dict[str, Callable[[int, int], np.ndarray]] = {}

    def rival(self, method: str, k: int, seed: int) -> Timed:
        """A partitioner on one thread."""
        if method not in self._rivals:
            self._rivals[method] = baselines.prepare(
                method, self.vertices, self.faces, self._dual_graph
            )
        segment = self._rivals[method]
        began = time.perf_counter()
        labels = segment(k, seed)
        return Timed(labels, time.perf_counter() - began)

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

    @functools.cached_property
    def _dual_graph(self) -> DualGraph:
        return build_dual_graph(self.faces)

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


def _start_of_peak() -> int:
    """Gives freed memory back, resets the peak (Linux) and returns the resident bytes."""
    ctypes.CDLL(None).malloc_trim(0)
    Path("/proc/self/clear_refs").write_text("5")
    return _memory("VmRSS")


def _memory(name: str) -> int:
    status = Path("/proc/self/status").read_text()
    return 1024 * int(re.search(rf"^{name}:\s*(\d+) kB", status, re.MULTILINE)[1])
