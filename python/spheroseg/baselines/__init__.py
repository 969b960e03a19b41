# SPDX-License-Identifier: GPL-3.0-or-later
"""Other methods to compare with: graph partitioners and region growing.

Each module has one function ``segment(vertices, faces, k, seed, *, graph=None) -> labels``:

- ``vertices``: (V, 3) float array; only region growing looks at it.
- ``faces``: (F, 3) integer array, indices in [0, V).
- ``k``: number of sub-meshes, 1 <= k <= F. ``seed``: integer >= 0.
- ``graph``: the mesh's :class:`DualGraph`, when the caller has it already (so that a stop watch
  measures the method alone); built from ``faces`` otherwise.
- returns an int32 array of F labels in [0, k). A method may leave a label unused.

All run on one thread by default and give the same labels for the same seed; Mt-KaHyPar does so
only in a fresh process.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from spheroseg.dual_graph import DualGraph, build_dual_graph
from spheroseg.errors import InputError

__all__ = ["BASELINES", "Baseline", "DualGraph", "baseline_names", "build_dual_graph", "load"]


@dataclass(frozen=True)
class Baseline:
    """A method that can be compared with: `name` is its module, `package` what it needs."""

    name: str
    title: str
    package: str
    setting: str


BASELINES: dict[str, Baseline] = {
    baseline.name: baseline
    for baseline in (
        Baseline(
            "metis_kway",
            "METIS k-way",
            "pymetis",
            "k-way, contiguous, other options default (slack 3 %): the paper's setting",
        ),
        Baseline(
            "metis_recursive", "METIS recursive", "pymetis", "recursive bisection, options default"
        ),
        Baseline(
            "metis_tight",
            "METIS ufactor 1",
            "pymetis",
            "k-way, contiguous, ufactor = 1 (slack 0.1 %)",
        ),
        Baseline(
            "metis_limit",
            "METIS limit +1",
            "pymetis",
            "k-way, contiguous, limit at ceil(F/k) + 1 triangles",
        ),
        Baseline(
            "kaminpar_exact",
            "KaMinPar exact",
            "kaminpar",
            "strong, limits floor(F/k) or ceil(F/k) per part",
        ),
        Baseline("mtkahypar_quality", "Mt-KaHyPar quality", "mtkahypar", "quality, slack 3 %"),
        Baseline(
            "region_growing",
            "Region growing",
            "numba",
            "random seeds; nearest neighbour to the region's centre that makes no bowtie",
        ),
    )
}


def baseline_names() -> list[str]:
    """The names that `load` knows."""
    return list(BASELINES)


def load(name: str) -> Callable[..., np.ndarray]:
    """The function of a baseline; raises InputError for an unknown name and ImportError, naming
    the package to install, when its library is absent."""
    if name not in BASELINES:
        known = ", ".join(BASELINES)
        raise InputError(f"no baseline is called '{name}'; known are {known}")
    return importlib.import_module(f"{__name__}.{name}").segment
