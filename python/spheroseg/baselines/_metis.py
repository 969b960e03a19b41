# SPDX-License-Identifier: GPL-3.0-or-later
"""METIS through pymetis (Karypis and Kumar, "A fast and high quality multilevel scheme for
partitioning irregular graphs", 1998)."""

from __future__ import annotations

import numpy as np

from spheroseg.baselines._common import checked_graph, int32_labels, require
from spheroseg.dual_graph import DualGraph
from spheroseg.errors import InputError


def partition(
    faces: np.ndarray, k: int, seed: int, graph: DualGraph | None, *, recursive: bool, **options
) -> np.ndarray:
    """Labels by METIS; `options` are METIS options by their lower-case names. Seed 0 is its own
    default: METIS would take 0 for 1.

    Raises InputError when contiguous parts are asked for on more than one component.
    """
    pymetis = require("pymetis")
    graph = checked_graph(faces, k, seed, graph)
    if options.get("contig"):
        require_one_component(graph)
    # METIS leaves a single part's labels alone, and with a part per triangle it may leave parts
    # empty; neither is a question of quality.
    if k == 1:
        return np.zeros(graph.face_count, dtype=np.int32)
    if seed != 0:
        options["seed"] = seed
    result = pymetis.part_graph(
        k,
        pymetis.CSRAdjacency(graph.starts, graph.adjacent),
        recursive=recursive,
        options=pymetis.Options(**options),
    )
    return int32_labels(result.vertex_part)


def require_one_component(graph: DualGraph) -> None:
    """METIS refuses contiguous parts of several components, and pymetis then returns whatever was
    in memory."""
    if graph.component_count > 1:
        raise InputError(
            "METIS makes contiguous parts of one component only, but the mesh has "
            f"{graph.component_count}; compare with metis_recursive"
        )
