# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs an evaluation mesh by mesh and writes its numbers."""

import csv
import io
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from spheroseg import atomic
from spheroseg.batch.inputs import Source
from spheroseg.batch.jobs import package_environment

_COLUMNS_LEFT_OUT = ("labels", "details")


@dataclass(frozen=True)
class Plan:
    """What to run on each mesh. Meshes run one after the other, for times that mean something."""

    submesh_counts: tuple[int, ...]
    methods: tuple[str, ...]
    seed: int
    all_pairs_limit: int


def evaluate(
    sources: list[Source], plan: Plan, folder: Path, on_mesh: Callable[[str, str | None], None]
) -> tuple[list[dict], list[str]]:
    """All rows, and a line per mesh that failed. `on_mesh` gets each mesh's name and failure."""
    rows, failures = [], []
    for source in sources:
        found, failure = _evaluate_one(source, plan, folder / "labels")
        rows += found
        if failure:
            failures.append(f"{source.mesh}: {failure}")
        on_mesh(source.name, failure)
    return rows, failures


def _evaluate_one(source: Source, plan: Plan, folder: Path) -> tuple[list[dict], str | None]:
    counts = (source.submesh_count,) if source.submesh_count else plan.submesh_counts
    with tempfile.TemporaryDirectory() as scratch:
        result = Path(scratch) / "rows.json"
        job = {
            "mesh": str(source.mesh),
            "name": source.name,
            "folder": str(folder),
            "rows": str(result),
            "submesh_counts": counts,
            "methods": plan.methods,
            "seed": plan.seed,
            "all_pairs_limit": plan.all_pairs_limit,
        }
        process = subprocess.run(
            [sys.executable, "-m", "spheroseg.evaluate.worker"],
            input=json.dumps(job),
            capture_output=True,
            text=True,
            check=False,
            env=package_environment(),
        )
        if process.returncode == 0:
            return json.loads(result.read_text()), None
    if process.returncode < 0:
        return [], f"the process was ended by signal {-process.returncode}"
    return [], (process.stderr.strip().splitlines() or ["failed without a word"])[-1]


def write_numbers(folder: Path, rows: list[dict], environment: dict[str, str]) -> None:
    """`results.json` with everything, `results.csv` with one line per mesh, k and method."""
    document = {"environment": environment, "rows": rows}
    atomic.write_text(folder / "results.json", json.dumps(document, indent=1) + "\n")
    columns = list(dict.fromkeys(name for row in rows for name in row))
    columns = [name for name in columns if name not in _COLUMNS_LEFT_OUT]
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    atomic.write_text(folder / "results.csv", buffer.getvalue())
