# SPDX-License-Identifier: GPL-3.0-or-later
"""The methods that a report compares: ours by method and effort, and the baselines."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from spheroseg import api, baselines
from spheroseg.errors import InputError

# all_pairs compares every triangle with every other: about a minute for this many on two cores.
ALL_PAIRS_LIMIT = 25_000


@dataclass(frozen=True)
class Outcome:
    """Labels, wall time, and what only our methods tell (iterations, time per stage)."""

    labels: np.ndarray
    seconds: float
    details: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Method:
    name: str
    title: str
    setting: str
    is_ours: bool
    run: Callable[..., Outcome]


_DETAILS = (
    "cohesion_iterations",
    "refinement_iterations",
    "parametrization_seconds",
    "cohesion_seconds",
    "refinement_seconds",
    "used_cuda",
    "time_limit_hit",
    "boundary_edges_by_iteration",
    "seconds_by_iteration",
    "energy_by_iteration",
)


def _ours(**options) -> Callable[..., Outcome]:
    def run(vertices, faces, k, seed, graph) -> Outcome:
        api.forget_prepared_mesh()
        began = time.perf_counter()
        result = api.segment(vertices, faces, k, seed=seed, **options)
        seconds = time.perf_counter() - began
        details = {key: result.measures[key] for key in _DETAILS if key in result.measures}
        return Outcome(result.labels, seconds, details)

    return run


def _baseline(name: str) -> Callable[..., Outcome]:
    def run(vertices, faces, k, seed, graph) -> Outcome:
        segment = baselines.prepare(name, vertices, faces, graph)
        began = time.perf_counter()
        labels = segment(k, seed)
        return Outcome(labels, time.perf_counter() - began)

    return run


def _all_methods() -> dict[str, Method]:
    methods = [
        Method(
            "all_pairs",
            "All pairs",
            "the paper's method, word for word",
            True,
            _ours(method="all_pairs"),
        )
    ]
    methods += [
        Method(
            f"fast_{effort}",
            f"Fast, {effort}",
            f"method fast, effort {effort}",
            True,
            _ours(method="fast", effort=effort),
        )
        for effort in api.EFFORTS
    ]
    methods += [
        Method(b.name, b.title, b.setting, False, _baseline(b.name))
        for b in baselines.BASELINES.values()
    ]
    return {method.name: method for method in methods}


METHODS = _all_methods()
DEFAULT_METHODS = (
    "all_pairs",
    "fast_draft",
    "fast_standard",
    "fast_high",
    "metis_kway",
    "metis_recursive",
    "metis_limit",
    "region_growing",
)


def chosen(names: str | None) -> list[str]:
    """Method names from a comma-separated list; the default ones for None."""
    if names is None:
        return list(DEFAULT_METHODS)
    wanted = [name.strip() for name in names.split(",")]
    for name in wanted:
        if name not in METHODS:
            raise InputError(f"there is no method '{name}'; choose from {', '.join(METHODS)}")
    return wanted
