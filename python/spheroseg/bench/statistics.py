# SPDX-License-Identifier: GPL-3.0-or-later
"""Pure functions on the rows of a benchmark: means, exponent, ratios, the table of bars."""

import math
import statistics
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

from spheroseg.evaluate.judging import METIS_MODES, geometric_mean, hexagonal_bound, is_valid

COUNT_KINDS = ("20", "200", "F/256", "F/64")
STANDARD, HIGH, MTKAHYPAR = "fast_standard", "fast_high", "mtkahypar_quality"
EFFORT_METHODS = ("fast_draft", STANDARD, HIGH)
SMALL_LIMIT, LARGE_LIMIT = 60_000, 100_000
EXPONENT_RANGE = (4_900, 1_400_000)
# An exponent fitted to sizes closer together says nothing.
LEAST_SPAN = 10


def fitted_exponent(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Slope of log time over log size by least squares; NaN with fewer than two sizes."""
    if len(set(sizes)) < 2:
        return math.nan
    return statistics.linear_regression(
        [math.log(size) for size in sizes], [math.log(time) for time in times]
    ).slope


def growth_exponent(cases: Sequence["Summary"]) -> float:
    """Exponent of time in F; NaN where the sizes span less than LEAST_SPAN."""
    sizes = [case.triangle_count for case in cases]
    if not sizes or max(sizes) < LEAST_SPAN * min(sizes):
        return math.nan
    return fitted_exponent(sizes, [case.seconds for case in cases])


def submesh_count(kind: str, face_count: int) -> int:
    """k for a kind: a plain number, or ceil(F / n) for "F/n"."""
    return -(-face_count // int(kind[2:])) if kind.startswith("F/") else int(kind)


@dataclass(frozen=True)
class Summary:
    """Medians over the runs of one method on one mesh with one k."""

    mesh: str
    triangle_count: int
    submesh_count: int
    method: str
    invalid_count: int
    boundary_edge_count: float
    boundary_edges_over_hexagonal: float
    max_triangle_count_difference: int
    bowtie_count: int
    disconnected_submesh_count: int
    seconds: float
    stages: dict[str, float]


STAGES = ("parametrization_seconds", "cohesion_seconds", "refinement_seconds", "total_seconds")


class Table:
    """The rows of a benchmark by mesh, k, method and measurement (`plan.Run`)."""

    def __init__(self, rows: Iterable[dict]):
        rows = list(rows)
        self.rows = [row for row in rows if row["status"] == "done"]
        self.failures = [row for row in rows if row["status"] != "done"]
        groups: dict[tuple, list[dict]] = {}
        for row in self.rows:
            key = (row["mesh"], row["submesh_count"], row["method"], row["measurement"])
            groups.setdefault(key, []).append(row)
        self._summaries = {key: _summary(group) for key, group in groups.items()}
        sizes = {row["mesh"]: row["triangle_count"] for row in rows}
        self.meshes = dict(sorted(sizes.items(), key=lambda item: (item[1], item[0])))

    def summaries(self) -> list[tuple[str, Summary]]:
        """(measurement, summary) of every group."""
        return [(key[3], summary) for key, summary in self._summaries.items()]

    def without(self, is_left_out: Callable[[str], bool]) -> "Table":
        """The rows of all meshes but those whose names are left out."""
        return Table(row for row in self.rows + self.failures if not is_left_out(row["mesh"]))

    def get(self, mesh: str, k: int, method: str, measurement: str = "first") -> Summary | None:
        return self._summaries.get((mesh, k, method, measurement))

    def metis(self, mesh: str, k: int) -> float | None:
        """Boundary edges of the better METIS mode; None unless both modes ran."""
        both = [self.get(mesh, k, mode) for mode in METIS_MODES]
        return min(one.boundary_edge_count for one in both) if all(both) else None

    def edge_ratios(self, method: str, kinds: Sequence[str], rival: str = "metis") -> list[float]:
        """Boundary edges of a method over METIS's better mode, or over another method."""
        ratios = []
        for mesh, face_count in self.meshes.items():
            for kind in kinds:
                k = submesh_count(kind, face_count)
                mine = self.get(mesh, k, method)
                if rival == "metis":
                    theirs = self.metis(mesh, k)
                else:
                    other = self.get(mesh, k, rival)
                    theirs = other.boundary_edge_count if other else None
                if mine and theirs:
                    ratios.append(mine.boundary_edge_count / theirs)
        return ratios

    def time_ratios(
        self,
        kind: str,
        least: int,
        most: float,
        one: tuple[str, str] = (STANDARD, "first"),
        other: tuple[str, str] = ("metis_kway", "first"),
    ) -> list[float]:
        """Seconds of (method, measurement) over those of another, on meshes of least..most."""
        ratios = []
        for mesh, face_count in self.meshes.items():
            k = submesh_count(kind, face_count)
            mine, theirs = self.get(mesh, k, *one), self.get(mesh, k, *other)
            if least <= face_count <= most and mine and theirs:
                ratios.append(mine.seconds / theirs.seconds)
        return ratios

    def growth(self, method: str = STANDARD, names: Iterable[str] | None = None) -> list[Summary]:
        """What the exponent is fitted to: k = F/256, one summary per mesh."""
        found = []
        for mesh in self.meshes if names is None else names:
            face_count = self.meshes.get(mesh, 0)
            summary = self.get(mesh, submesh_count("F/256", face_count), method)
            if summary and EXPONENT_RANGE[0] <= face_count <= EXPONENT_RANGE[1]:
                found.append(summary)
        return found

    def bytes_per_triangle(self) -> list[tuple[str, float]]:
        return [
            (row["mesh"], row["peak_bytes"] / row["triangle_count"])
            for row in self.rows
            if row["measurement"] == "memory" and row["triangle_count"] > LARGE_LIMIT
        ]


def _summary(group: list[dict]) -> Summary:
    first = group[0]
    edges = statistics.median(row["boundary_edge_count"] for row in group)
    hexagonal = hexagonal_bound(first["triangle_count"], first["submesh_count"])
    return Summary(
        mesh=first["mesh"],
        triangle_count=first["triangle_count"],
        submesh_count=first["submesh_count"],
        method=first["method"],
        invalid_count=sum(not is_valid(row) for row in group),
        boundary_edge_count=edges,
        boundary_edges_over_hexagonal=edges / hexagonal,
        max_triangle_count_difference=max(r["max_triangle_count_difference"] for r in group),
        bowtie_count=max(row["bowtie_count"] for row in group),
        disconnected_submesh_count=max(row["disconnected_submesh_count"] for row in group),
        seconds=statistics.median(row["seconds"] for row in group),
        stages={
            name: statistics.median(row[name] for row in group)
            for name in STAGES
            if first.get(name) is not None
        },
    )


@dataclass(frozen=True)
class Bar:
    """One line of the table of bars; `value` is NaN when nothing was measured."""

    title: str
    bar: float
    aim: float
    value: float
    case_count: int
    more_is_better: bool = False

    @property
    def verdict(self) -> str:
        if math.isnan(self.value):
            return "not measured"
        sign = -1 if self.more_is_better else 1
        if sign * self.value <= sign * self.aim:
            return "aim reached"
        return "bar reached" if sign * self.value <= sign * self.bar else "not reached"


def bars(table: Table, sweep: Iterable[dict] = ()) -> list[Bar]:
    """The bars of `fast`, each with what was measured (geometric means, unless said otherwise)."""
    return [
        *_edge_bars(table),
        *_time_bars(table),
        _validity_bar(table, sweep),
        *_machine_bars(table),
    ]


def _edge_bars(table: Table) -> list[Bar]:
    metis, slack = "BE over the better METIS mode", "BE over Mt-KaHyPar `quality` (3 % slack)"

    def edges(method: str, kinds: Sequence[str], rival: str = "metis") -> list[float]:
        return table.edge_ratios(method, kinds, rival)

    return [
        _mean(f"{metis}, k = 200, `standard`", 0.95, 0.90, edges(STANDARD, ["200"])),
        _mean(f"{metis}, k = 200, `high`", 0.90, 0.87, edges(HIGH, ["200"])),
        _mean(f"{slack}, k = 200, `standard`", 1.00, 0.96, edges(STANDARD, ["200"], MTKAHYPAR)),
        _mean(f"{slack}, k = 200, `high`", 0.96, 0.93, edges(HIGH, ["200"], MTKAHYPAR)),
        _mean(f"{metis}, F/64 and F/256, `standard`", 0.97, 0.93, edges(STANDARD, COUNT_KINDS[2:])),
        _worst(f"{metis}, k = 20, `standard`, worst mesh", 1.05, 0.97, edges(STANDARD, ["20"])),
    ]


def _time_bars(table: Table) -> list[Bar]:
    everywhere = (0, math.inf)
    small, large = (0, SMALL_LIMIT), (LARGE_LIMIT + 1, math.inf)
    clock = "total time over METIS k-way contiguous"
    fast = f"{clock}, k = 200, `standard`"
    fine = f"{clock}, F/64, `standard`, any F"
    again = table.time_ratios("200", *everywhere, (STANDARD, "again"), (STANDARD, "first"))
    growth = table.growth()
    exponent = "fitted exponent of time in F, k = F/256, `standard`"
    return [
        _mean(f"{fast}, F up to 60,000", 2.0, 1.0, table.time_ratios("200", *small)),
        _mean(f"{fast}, F above 100,000", 3.0, 1.0, table.time_ratios("200", *large)),
        _mean(fine, 0.6, 0.3, table.time_ratios("F/64", *everywhere)),
        _mean("second call with another k over a first one, k = 200, `standard`", 0.5, 0.2, again),
        Bar(exponent, 1.15, 1.05, growth_exponent(growth), len(growth)),
    ]


def _validity_bar(table: Table, sweep: Iterable[dict]) -> Bar:
    ours = [row for row in (*table.rows, *table.failures) if row["method"] in EFFORT_METHODS]
    ours = [row for row in ours if row["measurement"] != "memory"] + list(sweep)
    valid = 100 * sum(map(is_valid, ours)) / len(ours) if ours else math.nan
    return Bar("valid results of ours, per cent", 100, 100, valid, len(ours), more_is_better=True)


def _machine_bars(table: Table) -> list[Bar]:
    large = (LARGE_LIMIT + 1, math.inf)
    one_thread = (STANDARD, "one_thread")
    speed_up = table.time_ratios("F/256", *large, one_thread, (STANDARD, "first"))
    threads = "speed-up of 2 threads over 1, F above 100,000, k = F/256"
    memory = "peak memory per triangle in bytes, F above 100,000, worst mesh"
    return [
        _mean(threads, 1.5, 1.8, speed_up, more_is_better=True),
        _worst(memory, 400, 200, [value for _, value in table.bytes_per_triangle()]),
    ]


def _mean(
    title: str, bar: float, aim: float, ratios: list[float], more_is_better: bool = False
) -> Bar:
    return Bar(title, bar, aim, geometric_mean(ratios), len(ratios), more_is_better)


def _worst(title: str, bar: float, aim: float, values: list[float]) -> Bar:
    return Bar(title, bar, aim, max(values, default=math.nan), len(values))
