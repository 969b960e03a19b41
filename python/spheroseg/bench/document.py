# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes benchmarks.md, benchmarks.csv and the plot."""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

from spheroseg import atomic
from spheroseg.bench import plot
from spheroseg.bench.meshes import SERIES, is_subdivision
from spheroseg.bench.plan import METHODS, Plan
from spheroseg.bench.statistics import (
    COUNT_KINDS,
    STANDARD,
    Bar,
    Summary,
    Table,
    bars,
    growth_exponent,
    submesh_count,
)
from spheroseg.evaluate import environment
from spheroseg.evaluate.judging import geometric_mean, is_valid

TITLES = {
    "fast_draft": "`fast` draft",
    "fast_standard": "`fast` standard",
    "fast_high": "`fast` high",
    "metis_kway": "METIS k-way",
    "metis_recursive": "METIS recursive",
    "metis_tight": "METIS ufactor 1",
    "kaminpar_exact": "KaMinPar exact",
    "mtkahypar_quality": "Mt-KaHyPar",
}
IMAGE = "images/benchmarks.png"


def write(
    folder: Path,
    table: Table,
    sweep: list[dict],
    facts: dict[str, str],
    plan: Plan,
    reasons: list[str],
) -> None:
    """`benchmarks.md`, `benchmarks.csv` (a line per mesh, k, method and measurement) and the plot
    in `images`."""
    folder.mkdir(parents=True, exist_ok=True)
    titles = {name: title.replace("`", "") for name, title in TITLES.items()}
    plot.quality_and_time(folder / IMAGE, table, titles, COUNT_KINDS)
    sections = [
        _introduction(table, sweep, facts, plan, reasons),
        _bar_section(bars(table, sweep)),
        _other_meshes_section(table, sweep),
        f"![Quality against time]({IMAGE})\n\nSmall marks: meshes. Large marks: geometric means, "
        "filled where every result was valid.",
        *(_quality_section(table, kind) for kind in COUNT_KINDS),
        *(_time_section(table, kind) for kind in COUNT_KINDS),
        _stage_section(table),
        _growth_section(table),
        _validity_section(table, sweep),
    ]
    atomic.write_text(folder / "benchmarks.md", "\n\n".join(filter(None, sections)) + "\n")
    atomic.write_text(folder / "benchmarks.csv", _csv(table))


def _introduction(table: Table, sweep, facts: dict[str, str], plan: Plan, reasons) -> str:
    def named(column: str, rows) -> str:
        return ", ".join(sorted({row[column] or "unknown" for row in rows}))

    lines = [
        "# Benchmarks",
        "",
        "Written by `make bench`, on one machine: every time and every boundary is from one run of "
        "that program, the sweep over k (`--validity-sweep`) from another.",
        "",
        "## What is measured",
        "",
        "- **Ours**: method `fast` with its three efforts, through the MeshLab filter. The clock "
        "covers the whole filter call on a mesh that the plugin has not seen: reading the mesh, "
        "checks, dual graph, hierarchy, all stages, measures, writing the labels. It runs on "
        f"{facts['threads'].split(' ')[0]} threads unless a table says otherwise.",
        "- **METIS k-way**: `pymetis`, k-way, contiguous, all other options default (slack 3 %), "
        "as the paper ran it. **METIS recursive**: recursive bisection, options default (no "
        "contiguity option exists). **METIS ufactor 1**: k-way contiguous with a slack of 0.1 %. "
        "*The better METIS mode* is the shorter boundary of k-way and recursive on each mesh; "
        "claims about time are against k-way. With few triangles per part METIS's default limit "
        "leaves it no room, and one more triangle of slack improves it (docs/evaluation.md).",
        "- **KaMinPar exact**: preset strong with exact limits per part. **Mt-KaHyPar**: preset "
        "`quality`, slack 3 %: neither balanced nor always connected.",
        "- Partitioners run on one thread; their clock covers the partitioner's call alone, with "
        "the graph ready in its own form.",
        "- Every labelling is judged by the same measures ([measures.md](measures.md)). *Valid*: "
        "triangle counts differ by at most one, no sub-mesh empty, each connected, no bowtie. "
        "Quality is BE over the hexagonal bound sqrt(6 F k) / 2.",
        f"- Medians of {plan.repeats} runs with seeds 1 to {plan.repeats}, the methods "
        "interleaved within each mesh and k. To keep the whole run short, on meshes above "
        f"{plan.once_limit:,} triangles `high`, METIS ufactor 1, KaMinPar and Mt-KaHyPar run "
        f"once; above {plan.rival_limit:,} these three rivals are left out; above "
        f"{plan.high_limit:,} `high` runs at k = 200 only (up to {plan.huge_limit:,}); above "
        f"{plan.few_limit:,} `draft` and the one-thread and second-call measurements run once.",
        "- Meshes: PyMeshLab's samples, `sample_meshes`, the folder `../shared/meshes` where it is "
        "there, and subdivided ones (`_x4`: each triangle split in four at the middles of its "
        "edges).",
    ]
    lines += [f"- Left out: {reason}." for reason in reasons]
    lines += [
        "",
        "| | |",
        "|---|---|",
        f"| commit | {named('commit', table.rows) or facts['commit']} |",
    ]
    if sweep:
        lines.append(f"| commit of the sweep | {named('commit', sweep)} |")
    machines = named("machine", [*table.rows, *sweep]) or environment.machine(facts)
    lines.append(f"| machine | {machines} |")
    # Of another machine only its name is known.
    if machines == environment.machine(facts):
        shown = ("memory", "system", "Python", "pymeshlab", "pymetis", "kaminpar", "mtkahypar")
        lines += [f"| {name} | {facts[name]} |" for name in shown if name in facts]
    lines.append(f"| threads | {facts['threads']} |")
    return "\n".join(lines)


def _bar_section(found: Iterable[Bar]) -> str:
    return (
        "## The bars\n\nGeometric means over the meshes unless a line says otherwise; BE is the "
        "number of boundary edges, less is better.\n\n" + _bar_table(found)
    )


def _bar_table(found: Iterable[Bar]) -> str:
    body = [
        [b.title, f"{b.bar:g}", f"{b.aim:g}", _number(b.value), str(b.case_count), b.verdict]
        for b in found
    ]
    return _markdown(["", "bar", "aim", "measured", "cases", ""], body)


def _other_meshes_section(table: Table, sweep: list[dict]) -> str:
    """The bars once more, of meshes that are no subdivisions."""
    others = table.without(is_subdivision)
    count = len(table.meshes) - len(others.meshes)
    if not (count and others.meshes):
        return ""
    other_sweep = [row for row in sweep if not is_subdivision(row["mesh"])]
    return (
        f"### Without subdivisions\n\n{count} of the {len(table.meshes)} meshes come from coarser "
        "ones by splitting each triangle in four, which `fast` recognises and undoes. Over the "
        "others:\n\n" + _bar_table(bars(others, other_sweep))
    )


def _quality_section(table: Table, kind: str) -> str:
    columns = _present(table, kind)
    body, ratios = [], []
    for mesh, count in table.meshes.items():
        k = submesh_count(kind, count)
        cases = [table.get(mesh, k, method) for method in columns]
        if not any(cases):
            continue
        mine, metis = table.get(mesh, k, STANDARD), table.metis(mesh, k)
        ratio = mine.boundary_edge_count / metis if mine and metis else math.nan
        ratios.append(ratio)
        body.append([mesh, f"{count:,}", f"{k:,}", *map(_quality, cases), _number(ratio)])
    if not body:
        return ""
    head = ["mesh", "F", "k", *(TITLES[method] for method in columns), "standard / METIS"]
    mean = geometric_mean(ratio for ratio in ratios if not math.isnan(ratio))
    return (
        f"## Quality at k = {kind}\n\nBE over the hexagonal bound; * marks cases with a result "
        "that is not valid. Last column: `standard` over the better METIS mode, geometric mean "
        f"{_number(mean)}.\n\n" + _markdown(head, body)
    )


def _quality(case: Summary | None) -> str:
    if not case:
        return "–"
    return f"{case.boundary_edges_over_hexagonal:.3f}" + ("*" if case.invalid_count else "")


def _time_section(table: Table, kind: str) -> str:
    columns = _present(table, kind)
    body = []
    for mesh, count in table.meshes.items():
        k = submesh_count(kind, count)
        cases = [table.get(mesh, k, method) for method in columns]
        one = table.get(mesh, k, STANDARD, "one_thread")
        again = table.get(mesh, k, STANDARD, "again")
        if any(cases):
            body.append([mesh, f"{count:,}", *map(_seconds, [*cases, one, again])])
    if not body:
        return ""
    head = ["mesh", "F", *(TITLES[method] for method in columns), "standard, 1 thread"]
    head.append("standard, second call")
    empty = [i for i in range(len(head)) if all(line[i] == "–" for line in body)]
    head = [name for i, name in enumerate(head) if i not in empty]
    body = [[cell for i, cell in enumerate(line) if i not in empty] for line in body]
    return f"## Seconds at k = {kind}\n\n" + _markdown(head, body)


def _seconds(case: Summary | None) -> str:
    return f"{case.seconds:.3g}" if case else "–"


def _stage_section(table: Table) -> str:
    memory = {row["mesh"]: row for row in table.rows if row["measurement"] == "memory"}
    body = []
    for mesh, count in table.meshes.items():
        k = submesh_count("F/256", count)
        case = table.get(mesh, k, STANDARD)
        if not case or not case.stages:
            continue
        first, second, third = (
            case.stages[f"{name}_seconds"] for name in ("parametrization", "cohesion", "refinement")
        )
        stages = [first, second, third, case.seconds - first - second - third, case.seconds]
        shares = [f"{100 * value / case.seconds:.0f} %" for value in stages[:4]]
        one = table.get(mesh, k, STANDARD, "one_thread")
        speed_up = _number(one.seconds / case.seconds) if one else "–"
        peak = f"{memory[mesh]['peak_bytes'] / count:.0f}" if mesh in memory else "–"
        per_triangle = f"{1e6 * case.seconds / count:.2f}"
        total = f"{case.seconds:.3g}"
        body.append([mesh, f"{count:,}", total, per_triangle, *shares, speed_up, peak])
    if not body:
        return ""
    head = ["mesh", "F", "seconds", "µs per triangle", "hierarchy and map", "cohesion"]
    head += ["refinement", "rest", "speed-up of all threads over 1", "peak bytes per triangle"]
    return (
        "## Stages, threads and memory, `standard`, k = F/256\n\n*Rest*: reading MeshLab's mesh, "
        "dual graph, checks, measures, writing. *Peak*: growth of the process's peak resident "
        "memory by the filter call, MeshLab's own attribute arrays included, in a process of its "
        "own.\n\n" + _markdown(head, body)
    )


def _growth_section(table: Table) -> str:
    body = []
    for method in METHODS:
        for name, meshes in (("all", None), ("one shape, subdivided", SERIES)):
            cases = table.growth(method, meshes)
            sizes = [case.triangle_count for case in cases]
            exponent = growth_exponent(cases)
            if not math.isnan(exponent):
                span = f"{min(sizes):,} to {max(sizes):,}"
                body.append([TITLES[method], name, str(len(cases)), span, _number(exponent)])
    if not body:
        return ""
    head = ["method", "meshes", "count", "triangles", "exponent"]
    return (
        "## Growth of time\n\nExponent of F at k = F/256: least squares of log t over log F.\n\n"
        + _markdown(head, body)
    )


def _validity_section(table: Table, sweep: list[dict]) -> str:
    groups: dict[str, list[dict]] = {}
    for row in table.rows + table.failures:
        if row["measurement"] != "memory":
            groups.setdefault(TITLES[row["method"]], []).append(row)
    for row in sweep:
        groups.setdefault(f"{TITLES[row['method']]}, sweep over k", []).append(row)
    body = []
    for name, rows in groups.items():
        done = [row for row in rows if row["status"] == "done"]
        body.append(
            [
                name,
                str(len(rows)),
                str(sum(not is_valid(row) for row in rows)),
                str(len(rows) - len(done)),
                str(sum(row["max_triangle_count_difference"] > 1 for row in done)),
                str(sum(row["disconnected_submesh_count"] > 0 for row in done)),
                str(sum(row["bowtie_count"] > 0 for row in done)),
            ]
        )
    head = ["method", "runs", "not valid", "failed", "not balanced", "not connected", "bowties"]
    text = "## Validity\n\nNumber of runs by what is wrong with their result.\n\n"
    if sweep:
        meshes = {row["mesh"]: row["triangle_count"] for row in sweep}
        text += (
            f"The sweep covers {len(meshes)} meshes of {min(meshes.values()):,} to "
            f"{max(meshes.values()):,} triangles, each with 30 or more values of k from 2 to F.\n\n"
        )
    return text + _markdown(head, body)


def _present(table: Table, kind: str) -> list[str]:
    """Methods with any result at this k."""
    return [
        method
        for method in METHODS
        if any(table.get(m, submesh_count(kind, f), method) for m, f in table.meshes.items())
    ]


def _markdown(head: Sequence[str], body: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _number(value: float) -> str:
    return "–" if math.isnan(value) else f"{value:.3f}" if value < 10 else f"{value:.1f}"


def _csv(table: Table) -> str:
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    columns = [name for name in Summary.__dataclass_fields__ if name != "stages"]
    writer.writerow([*columns, "measurement"])
    for measurement, summary in table.summaries():
        values = [getattr(summary, name) for name in columns]
        writer.writerow([f"{v:.6g}" if isinstance(v, float) else v for v in values] + [measurement])
    return buffer.getvalue()
