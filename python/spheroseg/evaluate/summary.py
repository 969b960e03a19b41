# SPDX-License-Identifier: GPL-3.0-or-later
"""What a report says in short: valid results and geometric means of each method."""

from typing import Any

from spheroseg.evaluate.judging import METIS_MODES, geometric_mean
from spheroseg.evaluate.methods import METHODS

# Key of the mean, the methods of which the one with the shortest boundary counts, and a title.
RIVALS = (
    (
        "boundary_over_metis",
        METIS_MODES,
        "METIS (the better of k-way and recursive on each mesh)",
    ),
    (
        "boundary_over_metis_limit",
        ("metis_limit",),
        "METIS with the limit at one triangle above ceil(F/k)",
    ),
)


def summary(rows: list[dict]) -> list[dict[str, Any]]:
    """Numbers of each method over its finished rows, by the keys of docs/evaluation.md; None for a
    mean over nothing."""
    done = [row for row in rows if row["status"] == "done"]
    return [_of_method(name, done) for name in in_order(done)]


def sentences(numbers: list[dict[str, Any]]) -> list[str]:
    """The same in words; METIS is not compared with itself."""
    lines = []
    for one in numbers:
        line = (
            f"{METHODS[one['method']].title}: {one['valid_count']} of {one['result_count']} "
            "results are balanced within one triangle, connected and free of bowties"
        )
        if not one["method"].startswith("metis"):
            ratios = [
                f"{one[key]:.3f} times that of {title}"
                for key, _, title in RIVALS
                if one[key] is not None
            ]
            if ratios:
                line += f"; its boundary is on average {' and '.join(ratios)}"
        lines.append(line + ".")
    return lines


def in_order(rows: list[dict]) -> list[str]:
    """The methods of rows, in the order of METHODS."""
    present = {row["method"] for row in rows}
    return [name for name in METHODS if name in present]


def with_boundary(rows: list[dict]) -> list[dict]:
    """Those that count in means: where nothing had to be cut (k = 1, or a sub-mesh for each
    component), neither boundary nor time says anything."""
    return [row for row in rows if row["boundary_edge_count"] > 0]


def _of_method(name: str, done: list[dict]) -> dict[str, Any]:
    mine = [row for row in done if row["method"] == name]
    cut = with_boundary(mine)
    over_bound = [row["boundary_edges_over_hexagonal"] for row in cut]
    times = [1e6 * row["seconds"] / row["triangle_count"] for row in cut]
    numbers = {
        "method": name,
        "result_count": sum(row["run_count"] for row in mine),
        "valid_count": sum(row["valid_run_count"] for row in mine),
        "boundary_edges_over_hexagonal": _mean(over_bound),
        "microseconds_per_triangle": _mean(times),
    }
    for key, rivals, _ in RIVALS:
        ratios = _ratios(cut, done, rivals)
        numbers |= {key: _mean(ratios), f"{key}_case_count": len(ratios)}
    return numbers


def _mean(values: list[float]) -> float | None:
    return geometric_mean(values) if values else None


def _ratios(mine: list[dict], done: list[dict], rivals: tuple[str, ...]) -> list[float]:
    """Boundary over that of the best rival, for each mesh and k that all rivals have done."""
    edges: dict[tuple, list[int]] = {}
    for row in done:
        if row["method"] in rivals:
            key = row["mesh"], row["submesh_count"]
            edges.setdefault(key, []).append(row["boundary_edge_count"])
    ratios = []
    for row in mine:
        found = edges.get((row["mesh"], row["submesh_count"]), [])
        if len(found) == len(rivals) and min(found) > 0:
            ratios.append(row["boundary_edge_count"] / min(found))
    return ratios
