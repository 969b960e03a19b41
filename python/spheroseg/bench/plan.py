# SPDX-License-Identifier: GPL-3.0-or-later
"""Which runs a mesh gets, in which order."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass

import numpy as np

from spheroseg.bench.statistics import (
    COUNT_KINDS,
    EFFORT_METHODS,
    HIGH,
    MTKAHYPAR,
    STANDARD,
    submesh_count,
)
from spheroseg.evaluate.judging import METIS_MODES

METHODS = (*EFFORT_METHODS, *METIS_MODES, "metis_tight", "kaminpar_exact", MTKAHYPAR)
SLOW_RIVALS = ("metis_tight", "kaminpar_exact", MTKAHYPAR)
MEMORY_LEAST = 50_000


@dataclass(frozen=True)
class Run:
    """`measurement`: `first` (a first call), `one_thread` (the same on one thread), `again` (a
    second call, after one with `before` sub-meshes), `memory`, or `sweep`."""

    method: str
    submesh_count: int
    measurement: str
    seed: int
    before: int = 0

    def as_job(self) -> dict:
        return asdict(self)


@dataclass(frozen=True)
class Plan:
    """What to run and how often. Every `..._limit` is a triangle count.

    Repetitions use the seeds 1, 2, ... (METIS takes 0 for 1). Above `once_limit` the slow methods
    run once: `high` and the rivals of SLOW_RIVALS, which are left out above `rival_limit`. Above
    `high_limit` the effort `high` runs at k = 200 only, above `huge_limit` not at all. Above
    `few_limit` only `standard` and METIS's two modes are repeated.
    """

    kinds: tuple[str, ...] = COUNT_KINDS
    methods: tuple[str, ...] = METHODS
    repeats: int = 3
    once_limit: int = 15_000
    rival_limit: int = 200_000
    high_limit: int = 60_000
    few_limit: int = 250_000
    huge_limit: int = 600_000

    def runs(self, face_count: int) -> list[Run]:
        """Repetition by repetition and k by k, so that all methods meet the same disturbances."""
        counts = [submesh_count(kind, face_count) for kind in self.kinds]
        counts = sorted({k for k in counts if 2 <= k <= face_count})
        runs = [
            run
            for repeat in range(self.repeats)
            for k in counts
            for method in self.methods
            for run in self._of_method(method, k, repeat, face_count)
        ]
        if STANDARD in self.methods and face_count >= MEMORY_LEAST and "F/256" in self.kinds:
            runs.append(Run(STANDARD, submesh_count("F/256", face_count), "memory", 0))
        return runs

    def _of_method(self, method: str, k: int, repeat: int, face_count: int) -> Iterable[Run]:
        if repeat >= self._repeats(method, face_count):
            return
        if method in SLOW_RIVALS and face_count > self.rival_limit:
            return
        if method == HIGH and face_count > self.high_limit and k != 200:
            return
        if method == HIGH and face_count > self.huge_limit:
            return
        seed = repeat + 1
        yield Run(method, k, "first", seed)
        if method != STANDARD:
            return
        often = repeat == 0 or face_count <= self.few_limit
        if often and k in (200, submesh_count("F/256", face_count)):
            yield Run(method, k, "one_thread", seed)
        if often and k == 200:
            yield Run(method, k, "again", seed, before=20)

    def _repeats(self, method: str, face_count: int) -> int:
        if method == STANDARD or method in METIS_MODES:
            return self.repeats
        slow = method == HIGH or method in SLOW_RIVALS
        return 1 if face_count > (self.once_limit if slow else self.few_limit) else self.repeats


def sweep_counts(face_count: int, count: int = 30) -> list[int]:
    """At least `count` values of k from 2 to F (all of them when F is smaller): a geometric
    series, and the extremes F/2, F - 1 and F."""
    wanted = min(count, face_count - 1)
    steps = wanted
    while True:
        series = np.unique(np.geomspace(2, face_count, steps).round().astype(int))
        if len(series) >= wanted:
            break
        steps += 1 + steps // 8
    return sorted({*series.tolist(), max(2, face_count // 2), max(2, face_count - 1)})


def sweep_runs(face_count: int, methods: tuple[str, ...], count: int) -> list[Run]:
    return [
        Run(method, k, "sweep", 0) for k in sweep_counts(face_count, count) for method in methods
    ]
