# SPDX-License-Identifier: GPL-3.0-or-later
"""Command line of the benchmark: `python -m spheroseg.bench --help`."""

import argparse
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

from spheroseg import PluginError, load_plugin, workers
from spheroseg.bench import meshes, records
from spheroseg.bench.plan import METHODS, Plan, Run, sweep_runs
from spheroseg.bench.runner import row_of, run_mesh
from spheroseg.bench.statistics import COUNT_KINDS, Bar, Table, bars
from spheroseg.cores import core_count
from spheroseg.digests import plugin_digest
from spheroseg.evaluate import environment
from spheroseg.evaluate.judging import is_valid

REPOSITORY = Path(__file__).resolve().parents[3]
# The validity sweep of the docs: methods, and values of k per mesh.
SWEEP_METHODS = ("fast_draft", "fast_standard")
SWEEP_COUNT = 30
# Options that change no result.
NEUTRAL = ("output", "docs", "resume", "report_only", "validity_sweep")


def main(arguments: list[str] | None = None) -> int:
    parser = _parser()
    options = parser.parse_args(arguments)
    changed = _changed(parser, options)
    if not (REPOSITORY / "sample_meshes").is_dir():
        print(
            f"python -m spheroseg.bench: {Path(__file__).parent} is no part of a checkout of "
            "SpheroSeg, whose meshes it runs on and whose docs it writes; run it in one",
            file=sys.stderr,
        )
        return 2
    from spheroseg.bench import document  # needs packages that come with a checkout's set-up

    if not options.report_only:
        load_plugin()
    found, reasons = meshes.available(options.samples, options.more_meshes)
    for reason in reasons:
        print(reason, file=sys.stderr)
    chosen = _chosen(parser, options, found)
    facts = environment.surroundings()
    options.threads = options.threads or core_count()
    facts["threads"] = f"{options.threads} for ours, 1 for the partitioners"
    if not options.report_only:
        work = [(mesh, _runs(options, mesh)) for mesh in chosen]
        if not any(runs for _, runs in work):
            parser.error("these options leave no run on any mesh")
        _measure(work, options, facts)
    table = Table(records.load(options.output / "runs.csv"))
    sweep = records.load(options.output / "sweep.csv")
    if not (table.meshes or sweep):
        parser.error(f"there are no results in {options.output}")
    lacking = f"{changed} given" if changed else _missing(chosen, table, sweep)
    folder = options.output if lacking else options.docs
    document.write(folder, table, sweep, facts, _plan(options), reasons)
    for bar in bars(table, sweep):
        print(_line(bar))
    left = f"; {options.docs / 'benchmarks.md'} is left as it is: {lacking}" if lacking else ""
    print(f"written: {folder / 'benchmarks.md'}{left}")
    return 0


def _parser() -> argparse.ArgumentParser:
    plan = Plan()
    parser = argparse.ArgumentParser(
        prog="python -m spheroseg.bench",
        description="Time and quality against graph partitioners.",
        epilog="The docs are written where the folder of --output holds all results of both a run "
        "without options and one with --validity-sweep; of anything less the document lies there.",
    )
    add = parser.add_argument
    methods = f"comma-separated, of {','.join(METHODS)}"
    kinds = f"comma-separated, of {','.join(COUNT_KINDS)} or any number"
    add("--meshes", metavar="NAMES", help="comma-separated names, * and ? allowed; default: all")
    add("--k", metavar="KINDS", type=_kinds, default=COUNT_KINDS, help=kinds)
    add("--methods", metavar="NAMES", type=_methods, help=methods)

    def number(name: str, default: int, help_text: str | None = None, least: int = 0) -> None:
        add(name, type=_at_least(least), default=default, metavar="N", help=help_text)

    number("--repeats", plan.repeats, "runs per case, with seeds 1, 2, ...", least=1)
    number("--threads", 0, "threads of ours; 0: all cores")
    number("--min-triangles", 1_000)
    number("--max-triangles", 1_400_000)
    number("--once-limit", plan.once_limit, "F above which slow methods run once")
    number("--rival-limit", plan.rival_limit, "F above which slow rivals rest")
    number("--high-limit", plan.high_limit, "F above which high is k = 200 only")
    number("--few-limit", plan.few_limit, "F above which less is repeated")
    add("--samples", type=Path, default=REPOSITORY / "sample_meshes")
    add("--more-meshes", type=Path, default=REPOSITORY.parent / "shared" / "meshes")
    add("--output", type=Path, default=REPOSITORY / "out" / "bench", help="folder of runs.csv")
    add("--docs", type=Path, default=REPOSITORY / "docs", help="folder of benchmarks.md")
    add("--resume", action="store_true", help="keep rows of this plugin, machine, meshes, threads")
    add("--report-only", action="store_true", help="write the document from the rows at hand")
    add("--validity-sweep", action="store_true", help="many values of k, draft and standard")
    number("--sweep-count", SWEEP_COUNT, "values of k per mesh", least=1)
    return parser


def _kinds(text: str) -> tuple[str, ...]:
    kinds = tuple(text.split(","))
    for kind in kinds:
        if not re.fullmatch(r"F/[1-9]\d*|[2-9]|[1-9]\d+", kind, re.ASCII):
            raise argparse.ArgumentTypeError(f"expected numbers from 2 on or F/N, found '{kind}'")
    return kinds


def _methods(text: str) -> tuple[str, ...]:
    methods = tuple(text.split(","))
    for method in methods:
        if method not in METHODS:
            raise argparse.ArgumentTypeError(
                f"there is no method '{method}'; there are {', '.join(METHODS)}"
            )
    return methods


def _at_least(least: int) -> Callable[[str], int]:
    def number(text: str) -> int:
        value = int(text)
        if value < least:
            raise argparse.ArgumentTypeError(f"must be {least} or more, got {value}")
        return value

    return number


def _changed(parser: argparse.ArgumentParser, options) -> str:
    """The options that change results and differ from their defaults."""
    defaults = vars(parser.parse_args([]))
    names = [name for name in defaults if name not in NEUTRAL]
    changed = [name for name in names if getattr(options, name) != defaults[name]]
    return ", ".join(f"--{name.replace('_', '-')}" for name in changed)


def _chosen(parser: argparse.ArgumentParser, options, found) -> list[meshes.BenchMesh]:
    """By rising size."""
    for pattern in options.meshes.split(",") if options.meshes is not None else ():
        if not meshes.chosen(found, pattern):
            parser.error(f"argument --meshes: no mesh is named '{pattern}'")
    chosen = [
        mesh
        for mesh in meshes.chosen(found, options.meshes)
        if options.min_triangles <= mesh.triangle_count <= options.max_triangles
    ]
    return sorted(chosen, key=lambda mesh: (mesh.triangle_count, mesh.name))


def _missing(chosen: list[meshes.BenchMesh], table: Table, sweep: list[dict]) -> str:
    """What the rows lack of the two runs that make the docs; empty for nothing."""
    for rows, option, runs_of in (
        ([*table.rows, *table.failures], "--resume", Plan().runs),
        (
            sweep,
            "--validity-sweep --resume",
            lambda count: sweep_runs(count, SWEEP_METHODS, SWEEP_COUNT),
        ),
    ):
        there = {records.case_of(row) for row in rows}
        planned = [row_of(mesh, run, 0) for mesh in chosen for run in runs_of(mesh.triangle_count)]
        missing = sum(records.case_of(row) not in there for row in planned)
        if missing:
            return f"{missing:,} of {len(planned):,} runs are missing (run with {option})"
    return ""


def _plan(options) -> Plan:
    return Plan(
        kinds=options.k,
        methods=options.methods or METHODS,
        repeats=options.repeats,
        once_limit=options.once_limit,
        rival_limit=options.rival_limit,
        high_limit=options.high_limit,
        few_limit=options.few_limit,
    )


def _runs(options, mesh: meshes.BenchMesh) -> list[Run]:
    if options.validity_sweep:
        methods = options.methods or SWEEP_METHODS
        return sweep_runs(mesh.triangle_count, methods, options.sweep_count)
    return _plan(options).runs(mesh.triangle_count)


def _measure(work: list[tuple[meshes.BenchMesh, list[Run]]], options, facts) -> None:
    path = options.output / ("sweep.csv" if options.validity_sweep else "runs.csv")
    stamp = {
        "commit": facts["commit"],
        "plugin": plugin_digest(),
        "machine": environment.machine(facts),
    }
    planned = [row_of(mesh, run, options.threads) for mesh, runs in work for run in runs]
    earlier = records.load(path) if options.resume else []
    store = records.Records(path, records.current(earlier, planned, stamp))
    began = time.perf_counter()
    for number, (mesh, runs) in enumerate(work, 1):
        print(f"[{number}/{len(work)}] {mesh.name}, {mesh.triangle_count:,} triangles", flush=True)
        run_mesh(mesh, runs, store, stamp, options.threads, _print_row)
        print(f"  {time.perf_counter() - began:.0f} s so far", flush=True)
    store.close()


def _print_row(row: dict) -> None:
    line = f"  k {row['submesh_count']:>6}  {row['method']:<18} {row['measurement']:<10} "
    if row["status"] == "done":
        line += f"{row['seconds']:8.3f} s  BE {row['boundary_edge_count']:>6}"
        line += "" if is_valid(row) else "  not valid"
    else:
        line += f"failed: {row['error']}"
    print(line, flush=True)


def _line(bar: Bar) -> str:
    return f"{bar.value:8.3f}  (bar {bar.bar:g}, aim {bar.aim:g})  {bar.verdict:<13} {bar.title}"


if __name__ == "__main__":
    try:
        sys.exit(main())
    except PluginError as error:
        sys.exit(f"python -m spheroseg.bench: {workers.explained(error)}")
