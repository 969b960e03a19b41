# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality against time as a PNG."""

from pathlib import Path

import matplotlib

from spheroseg.bench.statistics import Table, submesh_count
from spheroseg.evaluate.judging import geometric_mean

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402 (after the choice of the backend)

_COLOURS = ("#66c2a5", "#2ca25f", "#006d2c", "#e6550d", "#fd8d3c", "#fdae6b", "#756bb1", "#08519c")
_MARKERS = "osD^vP*X"


def quality_and_time(
    path: Path, table: Table, titles: dict[str, str], kinds: tuple[str, ...]
) -> None:
    """BE over the hexagonal bound against microseconds per triangle, one panel per k. Large marks
    are geometric means; filled ones: every result was valid."""
    methods = list(titles)
    figure, axes = pyplot.subplots(2, 2, figsize=(9.6, 7.2), layout="constrained")
    for axis, kind in zip(axes.flat, kinds, strict=False):
        for index, method in enumerate(methods):
            cases = [
                table.get(mesh, submesh_count(kind, count), method)
                for mesh, count in table.meshes.items()
            ]
            cases = [case for case in cases if case]
            if not cases:
                continue
            times = [1e6 * case.seconds / case.triangle_count for case in cases]
            edges = [case.boundary_edges_over_hexagonal for case in cases]
            colour, marker = _COLOURS[index], _MARKERS[index]
            axis.scatter(times, edges, s=12, alpha=0.3, color=colour, marker=marker)
            valid = all(case.invalid_count == 0 for case in cases)
            axis.scatter(
                [geometric_mean(times)],
                [geometric_mean(edges)],
                s=90,
                marker=marker,
                facecolor=colour if valid else "white",
                edgecolor="black" if valid else colour,
                linewidth=1 if valid else 2,
                label=titles[method],
                zorder=3,
            )
        axis.set_xscale("log")
        axis.set_title(f"k = {kind}", fontsize=10)
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
        axis.set_xlabel("microseconds per triangle")
        axis.set_ylabel("boundary edges / hexagonal bound")
    handles = {}
    for axis in axes.flat:
        handles |= dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    pyplot.close(figure)
