# SPDX-License-Identifier: GPL-3.0-or-later
"""Other methods to compare with: graph partitioners and region growing.

Each module has one function ``segment(vertices, faces, k, seed, *, graph=None) -> labels``:

- ``vertices``: (V, 3) float array; only region growing looks at it.
- ``faces``: (F, 3) integer array, indices in [0, V).
- ``k``: number of sub-meshes, 1 <= k <= F. ``seed``: integer >= 0.
- ``graph``: the mesh's :class:`DualGraph`, when the caller has it already; built from ``faces``
  otherwise.
- returns an int32 array of F labels in [0, k). A method may leave a label unused.

All run on one thread by default and give the same labels for the same seed; Mt-KaHyPar does so
only in a fresh process. :func:`prepare` is for stop watches.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType

import numpy as np

from spheroseg.api import TETRAHEDRON
from spheroseg.baselines._metis import require_one_component
from spheroseg.dual_graph import DualGraph, build_dual_graph
from spheroseg.errors import InputError

__all__ = [
    "BASELINES",
    "Baseline",
    "DualGraph",
    "build_dual_graph",
    "load",
    "prepare",
]


@dataclass(frozen=True)
class Baseline:
    """A method that can be compared with: `name` is its module, `package` what it needs.
    One that `needs_one_component` takes no other meshes."""

    name: str
    title: str
    package: str
    setting: str
    needs_one_component: bool = False


BASELINES: dict[str, Baseline] = {
    baseline.name: baseline
    for baseline in (
        Baseline(
            "metis_kway",
            "METIS k-way",
            "pymetis",
            "k-way, contiguous, other options default (slack 3 %): the paper's setting",
            needs_one_component=True,
        ),
        Baseline(
            "metis_recursive", "METIS recursive", "pymetis", "recursive bisection, options default"
        ),
        Baseline(
            "metis_tight",
            "METIS ufactor 1",
            "pymetis",
            "k-way, contiguous, ufactor = 1 (slack 0.1 %)",
            needs_one_component=True,
        ),
        Baseline(
            "metis_limit",
            "METIS limit +1",
            "pymetis",
            "k-way, contiguous, limit at ceil(F/k) + 1 triangles",
            needs_one_component=True,
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


def load(name: str) -> Callable[..., np.ndarray]:
    """The function of a baseline; raises InputError for an unknown name and ImportError, naming
    the package to install, when its library is absent."""
    return _module(name).segment


def prepare(
    name: str, vertices: np.ndarray, faces: np.ndarray, graph: DualGraph
) -> Callable[[int, int], np.ndarray]:
    """The baseline on one mesh as a function of k and seed, of which a stop watch may measure each
    call: the library is loaded and has run once, the graph is there in its own form, and the mesh
    is one that the baseline takes.

    Raises what `load` raises, and InputError for a mesh that the baseline does not take.
    """
    segment = _warmed_up(name)
    if BASELINES[name].needs_one_component:
        require_one_component(graph)
    own = getattr(_module(name), "prepare", None)
    if own:
        return own(vertices, faces, graph)
    return lambda k, seed: segment(vertices, faces, k, seed, graph=graph)


@functools.cache
def _warmed_up(name: str) -> Callable[..., np.ndarray]:
    """The function of a baseline after a first call, which may import or compile."""
    segment = load(name)
    segment(*TETRAHEDRON, 2, 0)
    return segment


def _module(name: str) -> ModuleType:
    if name not in BASELINES:
        known = ", ".join(BASELINES)
        raise InputError(f"no baseline is called '{name}'; known are {known}")
    return importlib.import_module(f"{__name__}.{name}")
