# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares our methods with METIS and region growing, as the paper does, and writes a report.

DIR/report.html is one file that works offline; results.csv, results.json, the pictures, the plots
and all labels lie beside it. A mesh or a method that fails costs a line and exit code 1; the report
is written all the same. docs/evaluation.md tells what is measured and how.
"""

import importlib
from pathlib import Path

from spheroseg import api
from spheroseg.baselines import BASELINES
from spheroseg.batch import inputs
from spheroseg.commands import shared
from spheroseg.errors import InputError
from spheroseg.evaluate import folder as report_folder
from spheroseg.evaluate import methods, runner
from spheroseg.evaluate.environment import describe
from spheroseg.packages import require_all
from spheroseg.progress import MeshProgress

VIEWER_LIMIT = 120_000


def add_arguments(parser):
    parser.add_argument("inputs", metavar="INPUTS", nargs="+", help="meshes, folders, globs, CSV")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder to write")
    parser.add_argument(
        "-k",
        "--submesh-counts",
        metavar="N",
        type=int,
        nargs="+",
        default=[200],
        help="where no CSV says otherwise (200)",
    )
    parser.add_argument(
        "--methods",
        metavar="LIST",
        help=f"out of {', '.join(methods.METHODS)} (default: {', '.join(methods.DEFAULT_METHODS)})",
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="for all methods (0)")
    parser.add_argument(
        "--seeds", type=int, default=1, metavar="N", help="runs, from --seed on; median shown (1)"
    )
    parser.add_argument(
        "--all-pairs-limit",
        type=int,
        default=methods.ALL_PAIRS_LIMIT,
        metavar="N",
        help=f"leave all_pairs out above N triangles ({methods.ALL_PAIRS_LIMIT})",
    )
    parser.add_argument(
        "--viewer-limit",
        type=int,
        default=VIEWER_LIMIT,
        metavar="N",
        help=f"leave meshes above N triangles out of the 3D view ({VIEWER_LIMIT})",
    )


def run(arguments) -> int:
    folder = Path(arguments.output)
    shared.check_folder(folder)
    plan = _plan(arguments)
    sources = inputs.collect(arguments.inputs)
    report = _report_module(plan)
    files = runner.files_of(sources, plan)
    with report_folder.prepared(folder, files) as earlier:
        rows, failed_meshes, failures = _evaluate(sources, plan, folder)
        if all(row["status"] == "left out" for row in rows):
            report_folder.keep_only(folder, earlier)
            raise InputError(_why_nothing_ran(rows, failures))
        environment = describe(arguments.command_line, _seeds(plan))
        runner.write_numbers(folder, rows, failed_meshes, environment)
        page = report.write_report(folder, rows, failed_meshes, environment, arguments.viewer_limit)
        report_folder.keep_only(folder, files)
    print(page)
    return 1 if failures else 0


def _evaluate(
    sources: list[inputs.Source], plan: runner.Plan, folder: Path
) -> tuple[list[dict], list[dict], list[str]]:
    """All rows, the meshes that failed, and a line for each failure, which is said, too."""
    with MeshProgress("Evaluating", len(sources)) as progress:
        rows, failed_meshes = runner.evaluate(sources, plan, folder, lambda *_: progress.advance())
    failures = [f"{failed['path']}: {failed['error']}" for failed in failed_meshes]
    failures += [
        f"{row['mesh']}, k = {row['submesh_count']}, {row['method']}: {row['error']}"
        for row in rows
        if row["status"] == "failed"
    ]
    if rows or len(failures) > 1:  # else the one line of the error says it
        for failure in failures:
            progress.say_failed(failure)
    return rows, failed_meshes, failures


def _plan(arguments) -> runner.Plan:
    counts = tuple(dict.fromkeys(arguments.submesh_counts))
    for option, value, least in (
        ("-k", min(counts), 1),
        ("--seed", arguments.seed, 0),
        ("--seeds", arguments.seeds, 1),
        ("--all-pairs-limit", arguments.all_pairs_limit, 0),
        ("--viewer-limit", arguments.viewer_limit, 0),
    ):
        if value < least:
            raise InputError(f"{option} must be {least} or more, got {value}")
    api.segment_parameters(
        {"submesh_count": max(counts), "seed": arguments.seed + arguments.seeds - 1}
    )
    names = tuple(dict.fromkeys(methods.chosen(arguments.methods)))
    return runner.Plan(counts, names, arguments.seed, arguments.seeds, arguments.all_pairs_limit)


def _seeds(plan: runner.Plan) -> str:
    last = plan.seed + plan.seed_count - 1
    return str(plan.seed) if last == plan.seed else f"{plan.seed} to {last}"


def _why_nothing_ran(rows: list[dict], failures: list[str]) -> str:
    if not rows:
        return failures[0] if len(failures) == 1 else "no mesh could be evaluated"
    first = rows[0]
    return (
        f"no method could run: {first['mesh']}, k = {first['submesh_count']}, {first['method']}: "
        f"{first['error']}"
    )


def _report_module(plan: runner.Plan):
    purposes = dict.fromkeys(("jinja2", "matplotlib", "pyvista"), "a report")
    for name in plan.methods:
        if name in BASELINES:
            purposes.setdefault(BASELINES[name].package, f"the method {name}")
    require_all(purposes)
    return importlib.import_module("spheroseg.evaluate.report")
