# SPDX-License-Identifier: GPL-3.0-or-later
"""Quality against time as a PNG."""

from pathlib import Path

from matplotlib import pyplot

from spheroseg.bench.statistics import Table, submesh_count
from spheroseg.evaluate.plots import LOOKS, mark_quality_and_time


def quality_and_time(
    path: Path, table: Table, titles: dict[str, str], kinds: tuple[str, ...]
) -> None:
    """BE over the hexagonal bound against microseconds per triangle, one panel per k. Large marks
    are geometric means; filled ones: every result was valid."""
    figure, axes = pyplot.subplots(2, 2, figsize=(9.6, 7.2), layout="constrained")
    for axis, kind in zip(axes.flat, kinds, strict=False):
        for method, title in titles.items():
            cases = [
                table.get(mesh, submesh_count(kind, count), method)
                for mesh, count in table.meshes.items()
            ]
            cases = [case for case in cases if case]
            if not cases:
                continue
            times = [1e6 * case.seconds / case.triangle_count for case in cases]
            edges = [case.boundary_edges_over_hexagonal for case in cases]
            valid = all(case.invalid_count == 0 for case in cases)
            mark_quality_and_time(axis, times, edges, title, *LOOKS[method], valid)
        axis.set_title(f"k = {kind}", fontsize=10)
        axis.grid(alpha=0.3)
        axis.spines[["top", "right"]].set_visible(False)
    handles = {}
    for axis in axes.flat:
        handles |= dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, fontsize=8)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    pyplot.close(figure)
