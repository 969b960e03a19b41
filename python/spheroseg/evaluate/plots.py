# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's diagrams as SVG text, by matplotlib."""

import io
import warnings

import matplotlib

from spheroseg.evaluate.judging import geometric_mean

matplotlib.use("Agg")
from matplotlib import pyplot, ticker  # noqa: E402 (after the choice of the backend)

_STYLE = {
    "svg.hashsalt": "spheroseg",
    "svg.fonttype": "none",
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
}
# Colour and marker of each method, the same in every report.
LOOKS = {
    "all_pairs": ("#0b6e99", "o"),
    "fast_draft": ("#66c2a5", "s"),
    "fast_standard": ("#2ca25f", "D"),
    "fast_high": ("#006d2c", "^"),
    "metis_kway": ("#e6550d", "v"),
    "metis_recursive": ("#fd8d3c", "P"),
    "metis_tight": ("#a63603", "p"),
    "metis_limit": ("#fdbe85", "*"),
    "kaminpar_exact": ("#dd1c77", "h"),
    "mtkahypar_quality": ("#c994c7", "<"),
    "region_growing": ("#756bb1", "X"),
}
# Characters that a diagram has room for.
_LONGEST_NAME = 48
_LONGEST_TITLE = 96


def iterations(row: dict, title: str) -> str | None:
    """Boundary edges and seconds per iteration (the paper's Fig. 9); None without a series."""
    edges = row["details"].get("boundary_edges_by_iteration") or []
    seconds = row["details"].get("seconds_by_iteration") or []
    if len(edges) < 2:
        return None
    cohesion = row["details"].get("cohesion_iterations", 0)
    with pyplot.rc_context(_STYLE):
        figure, axes = pyplot.subplots(1, 2, figsize=(8.4, 2.8), layout="constrained")
        for axis, values, label in zip(
            axes, (edges, seconds), ("boundary edges", "seconds per iteration"), strict=True
        ):
            numbers = range(1, len(values) + 1)
            axis.plot(numbers, values, ".-", color=LOOKS[row["method"]][0])
            if 0 < cohesion < len(values):
                axis.axvline(cohesion + 0.5, color="#888888", linestyle="--", linewidth=1)
                axis.annotate(
                    "refinement",
                    (cohesion + 0.6, 1),
                    xycoords=("data", "axes fraction"),
                    va="top",
                    fontsize=8,
                    color="#555555",
                )
            axis.xaxis.set_major_locator(ticker.MaxNLocator(integer=True))
            axis.set_xlabel("iteration")
            axis.set_ylabel(label)
            if values is seconds:
                axis.set_yscale("log")
                _label_plainly(axis.yaxis)
        figure.suptitle(_shortened(title, _LONGEST_TITLE), fontsize=10, parse_math=False)
        return _svg(figure)


def shared_memory(rows: list[dict], titles: dict[str, str]) -> str:
    """Bytes of the largest sub-mesh by mesh and method (the paper's Fig. 10, bottom)."""
    meshes = list(dict.fromkeys(row["mesh"] for row in rows))
    names = [_shortened(mesh, _LONGEST_NAME) for mesh in meshes]
    height = 3.2 + 0.05 * max(map(len, names))  # names must not take their room from the bars
    methods = list(titles)
    width = 0.8 / len(methods)
    with pyplot.rc_context(_STYLE):
        figure, axis = pyplot.subplots(
            figsize=(min(12, 5 + 1.2 * len(meshes)), height), layout="constrained"
        )
        for index, method in enumerate(methods):
            values = {
                r["mesh"]: r["shared_memory_bytes"] / 1024 for r in rows if r["method"] == method
            }
            places = [meshes.index(mesh) + (index + 0.5) * width - 0.4 for mesh in values]
            colour = LOOKS[method][0]
            axis.bar(places, values.values(), width, label=titles[method], color=colour)
        turned = {"rotation": 45, "ha": "right", "rotation_mode": "anchor"}
        axis.set_xticks(range(len(meshes)), names, parse_math=False, **turned)
        axis.set_yscale("log")
        _label_plainly(axis.yaxis)
        # Else the least bar has no length, and all differ from it by much.
        bytes_of = [row["shared_memory_bytes"] for row in rows]
        axis.set_ylim(min(bytes_of) / 1024 / 2, max(bytes_of) / 1024 * 1.2)
        axis.grid(visible=False, axis="x")
        axis.set_ylabel("KiB of the largest sub-mesh")
        axis.legend(fontsize=7, loc="upper left", bbox_to_anchor=(1, 1))
        return _svg(figure)


def mark_quality_and_time(
    axis, times: list[float], edges: list[float], title: str, color: str, marker: str, valid: bool
) -> None:
    """A method on an axis with the boundary over the hexagonal bound against microseconds per
    triangle: results as small marks, their geometric means as a large one, which is filled where
    every result is valid."""
    axis.scatter(times, edges, s=15, alpha=0.3, color=color, marker=marker)
    axis.scatter(
        [geometric_mean(times)],
        [geometric_mean(edges)],
        s=90,
        marker=marker,
        facecolor=color if valid else "white",
        edgecolor="black" if valid else color,
        linewidth=1 if valid else 2,
        label=title,
        zorder=3,
    )
    axis.set_xscale("log")
    _label_plainly(axis.xaxis)
    axis.set_xlabel("microseconds per triangle")
    axis.set_ylabel("boundary edges / hexagonal bound")


def quality_and_time(rows: list[dict], titles: dict[str, str]) -> str:
    """All meshes and k, as mark_quality_and_time draws them."""
    with pyplot.rc_context(_STYLE):
        figure, axis = pyplot.subplots(figsize=(7.2, 4), layout="constrained")
        for method, title in titles.items():
            mine = [row for row in rows if row["method"] == method]
            times = [1e6 * row["seconds"] / row["triangle_count"] for row in mine]
            edges = [row["boundary_edges_over_hexagonal"] for row in mine]
            valid = all(row["valid_run_count"] == row["run_count"] for row in mine)
            mark_quality_and_time(axis, times, edges, title, *LOOKS[method], valid)
        # Rows as high as the marks.
        axis.legend(fontsize=7, labelspacing=1.1, loc="upper left", bbox_to_anchor=(1, 1))
        return _svg(figure)


class _PlainNumbers(ticker.LogFormatter):
    """Labels the ticks that matplotlib labels, with 0.01 instead of a power of ten, which it takes
    longer to typeset than to draw all else."""

    def __call__(self, x, pos=None):
        return f"{x:g}" if super().__call__(x, pos) else ""


def _label_plainly(logarithmic_axis) -> None:
    logarithmic_axis.set_major_formatter(_PlainNumbers())
    logarithmic_axis.set_minor_formatter(_PlainNumbers())


def _shortened(text: str, longest: int) -> str:
    """The text, or its two ends where it is longer."""
    half = longest // 2
    return text if len(text) <= longest else f"{text[:half]}…{text[-half:]}"


def _svg(figure) -> str:
    buffer = io.StringIO()
    with warnings.catch_warnings():
        # The text is drawn by the browser, which has other fonts.
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    pyplot.close(figure)
    text = buffer.getvalue()
    return text[text.index("<svg") :]
