# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs an evaluation mesh by mesh and writes its numbers."""

import csv
import io
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from spheroseg import atomic, workers
from spheroseg.batch.inputs import Source
from spheroseg.errors import one_line, shown
from spheroseg.evaluate.folder import DOCUMENT, TABLE
from spheroseg.evaluate.folder import files_of as report_files
from spheroseg.evaluate.summary import summary

_COLUMNS_LEFT_OUT = ("labels", "details")


@dataclass(frozen=True)
class Plan:
    """What to run on each mesh. Meshes run one after the other, for times that mean something."""

    submesh_counts: tuple[int, ...]
    methods: tuple[str, ...]
    seed: int
    seed_count: int
    all_pairs_limit: int

    def runs(self, source: Source) -> list[tuple[int, str]]:
        """(k, method) of each run on a mesh."""
        counts = (source.submesh_count,) if source.submesh_count else self.submesh_counts
        return [(k, method) for k in counts for method in self.methods]


def files_of(sources: list[Source], plan: Plan) -> list[str]:
    """Every file that the report may write, relative to its folder."""
    return report_files((s.name, *run) for s in sources for run in plan.runs(s))


def evaluate(
    sources: list[Source], plan: Plan, folder: Path, on_mesh: Callable[[str, str | None], None]
) -> tuple[list[dict], list[dict]]:
    """All rows, and the meshes that failed: `mesh` and `mesh_file` as in rows, `path`, and the
    reason as `error`. `on_mesh` gets each mesh's name and failure."""
    rows, failed_meshes = [], []
    for source in sources:
        found, failure = _evaluate_one(source, plan, folder)
        rows += found
        if failure:
            names = {"mesh": shown(source.name), "mesh_file": shown(source.mesh.name)}
            failed_meshes.append(names | {"path": shown(source.mesh), "error": failure})
        on_mesh(source.name, failure)
    return rows, failed_meshes


def _evaluate_one(source: Source, plan: Plan, folder: Path) -> tuple[list[dict], str | None]:
    """The rows that were finished, and why the others were not begun."""
    tasks = [{"submesh_count": k, "method": method} for k, method in plan.runs(source)]
    job = {
        "mesh": str(source.mesh),
        "name": source.name,
        "folder": str(folder),
        "seed": plan.seed,
        "seed_count": plan.seed_count,
        "all_pairs_limit": plan.all_pairs_limit,
    }
    rows = []
    try:
        for task, result in workers.results("spheroseg.evaluate.worker", job, tasks):
            known = {"mesh": source.name, "mesh_file": source.mesh.name}
            known |= {"triangle_count": result["triangle_count"], **task, "seed": plan.seed}
            rows.append(known | result)
    except workers.WorkerError as error:
        return rows, str(error).removeprefix(f"{one_line(shown(source.mesh))}: ")
    return rows, None


def write_numbers(
    folder: Path, rows: list[dict], failed_meshes: list[dict], environment: dict[str, str]
) -> None:
    """`results.json` with everything, `results.csv` with one line per mesh, k and method, and one
    per mesh that failed."""
    document = {"environment": environment, "summary": summary(rows), "rows": rows}
    document["failed_meshes"] = failed_meshes
    atomic.write_text(folder / DOCUMENT, json.dumps(document, indent=1) + "\n")
    columns = dict.fromkeys(name for row in rows for name in row)
    if failed_meshes:
        columns |= {"status": None, "error": None}
    columns = [name for name in columns if name not in _COLUMNS_LEFT_OUT]
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    writer.writerows(failed | {"status": "failed"} for failed in failed_meshes)
    atomic.write_text(folder / TABLE, buffer.getvalue())
