# SPDX-License-Identifier: GPL-3.0-or-later
"""Command line of the benchmark: `python -m spheroseg.bench --help`."""

import argparse
import sys
import time
from pathlib import Path

from spheroseg.batch.jobs import plugin_digest
from spheroseg.bench import document, meshes, records
from spheroseg.bench.plan import METHODS, Plan, Run, sweep_runs
from spheroseg.bench.runner import row_of, run_mesh
from spheroseg.bench.statistics import COUNT_KINDS, Bar, Table, bars
from spheroseg.cores import core_count
from spheroseg.evaluate import environment
from spheroseg.evaluate.judging import is_valid

REPOSITORY = Path(__file__).resolve().parents[3]
SWEEP_METHODS = ("fast_draft", "fast_standard")


def main(arguments: list[str] | None = None) -> int:
    options = _parser().parse_args(arguments)
    if not (REPOSITORY / "sample_meshes").is_dir():
        print(
            f"python -m spheroseg.bench: {Path(__file__).parent} is no part of a checkout of "
            "SpheroSeg, whose meshes it runs on and whose docs it writes; run it in one",
            file=sys.stderr,
        )
        return 2
    found, reasons = meshes.available(options.samples, options.more_meshes)
    for reason in reasons:
        print(reason, file=sys.stderr)
    chosen = [
        mesh
        for mesh in meshes.chosen(found, options.meshes)
        if options.min_triangles <= mesh.triangle_count <= options.max_triangles
    ]
    chosen.sort(key=lambda mesh: (mesh.triangle_count, mesh.name))
    facts = environment.surroundings()
    options.threads = options.threads or core_count()
    facts["threads"] = f"{options.threads} for ours, 1 for the partitioners"
    if not options.report_only:
        work = [(mesh, _runs(options, mesh)) for mesh in chosen]
        _measure(work, options, facts)
    table = Table(records.load(options.output / "runs.csv"))
    sweep = records.load(options.output / "sweep.csv")
    folder = options.docs or (options.output if _is_part(options) else REPOSITORY / "docs")
    document.write(folder, table, sweep, facts, _plan(options), reasons)
    for bar in bars(table, sweep):
        print(_line(bar))
    print(f"written: {folder / 'benchmarks.md'}")
    return 0


def _parser() -> argparse.ArgumentParser:
    plan = Plan()
    parser = argparse.ArgumentParser(prog="python -m spheroseg.bench", description=__doc__)
    add = parser.add_argument
    add("--meshes", metavar="NAMES", help="comma-separated names, * and ? allowed; default: all")
    add("--k", metavar="KINDS", help=f"comma-separated, of {','.join(COUNT_KINDS)} or any number")
    add("--methods", metavar="NAMES", help=f"comma-separated, of {','.join(METHODS)}")
    add("--repeats", type=int, default=plan.repeats, help="runs per case, with seeds 1, 2, ...")
    add("--threads", type=int, default=0, help="threads of ours; 0: all cores")
    add("--min-triangles", type=int, default=1_000)
    add("--max-triangles", type=int, default=1_400_000)
    add(
        "--once-limit",
        type=int,
        default=plan.once_limit,
        help="F above which slow methods run once",
    )
    add("--rival-limit", type=int, default=plan.rival_limit, help="F above which slow rivals rest")
    add(
        "--high-limit", type=int, default=plan.high_limit, help="F above which high is k = 200 only"
    )
    add("--few-limit", type=int, default=plan.few_limit, help="F above which less is repeated")
    add("--samples", type=Path, default=REPOSITORY / "sample_meshes")
    add("--more-meshes", type=Path, default=REPOSITORY.parent / "shared" / "meshes")
    add("--output", type=Path, default=REPOSITORY / "out" / "bench", help="folder of runs.csv")
    add("--docs", type=Path, help="folder of benchmarks.md; default: docs, or --output for a part")
    add("--resume", action="store_true", help="keep rows of this plugin, machine, meshes, threads")
    add("--report-only", action="store_true", help="write the document from the rows at hand")
    add("--validity-sweep", action="store_true", help="30 values of k per mesh, draft and standard")
    add("--sweep-count", type=int, default=30)
    return parser


def _plan(options) -> Plan:
    return Plan(
        kinds=tuple(options.k.split(",")) if options.k else COUNT_KINDS,
        methods=tuple(options.methods.split(",")) if options.methods else METHODS,
        repeats=options.repeats,
        once_limit=options.once_limit,
        rival_limit=options.rival_limit,
        high_limit=options.high_limit,
        few_limit=options.few_limit,
    )


def _is_part(options) -> bool:
    choices = ("meshes", "k", "methods", "repeats", "min_triangles", "max_triangles")
    return any(getattr(options, name) != _parser().get_default(name) for name in choices)


def _runs(options, mesh: meshes.BenchMesh) -> list[Run]:
    if options.validity_sweep:
        methods = options.methods.split(",") if options.methods else SWEEP_METHODS
        return sweep_runs(mesh.triangle_count, tuple(methods), options.sweep_count)
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
    sys.exit(main())
