# SPDX-License-Identifier: GPL-3.0-or-later
"""What the report, the benchmark and the scripts judge results by."""

import math
import statistics
from collections.abc import Iterable, Mapping
from typing import Any

# Of these the one with the shorter boundary is what claims about METIS compare with.
METIS_MODES = ("metis_kway", "metis_recursive")


def hexagonal_bound(face_count: int, k: int) -> float:
    """Boundary edges of k round patches on a regular mesh: sqrt(6 F k) / 2."""
    return math.sqrt(6 * face_count * k) / 2


def is_valid(result: Mapping[str, Any], best_difference: int = 1) -> bool:
    """All sub-meshes there, MTCD at most `best_difference`, each connected, no bowtie; by the
    measures of a result, which may also tell its status and how many labels it has."""
    wanted = result.get("submesh_count")
    return (
        result.get("status", "done") == "done"
        and result.get("found_submesh_count", wanted) == wanted
        and result["min_submesh_triangles"] > 0
        and result["max_triangle_count_difference"] <= best_difference
        and result["bowtie_count"] == 0
        and result["disconnected_submesh_count"] == 0
    )


def geometric_mean(values: Iterable[float]) -> float:
    """Of numbers above 0, never outside of them by rounding; NaN for none."""
    values = list(values)
    if not values:
        return math.nan
    return min(max(statistics.geometric_mean(values), min(values)), max(values))
