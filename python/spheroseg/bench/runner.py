# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the runs of a plan mesh by mesh, each mesh in a process of its own."""

import collections
from collections.abc import Callable, Iterable
from dataclasses import asdict

from spheroseg import workers
from spheroseg.bench.meshes import BenchMesh
from spheroseg.bench.plan import Run
from spheroseg.bench.records import Records, key_of

OURS_PREFIX = "fast_"


def run_mesh(
    mesh: BenchMesh,
    runs: list[Run],
    records: Records,
    stamp: dict[str, str],
    thread_count: int,
    on_row: Callable[[dict], None],
) -> None:
    """Adds a row for each run that `records` do not hold yet. A run that ends its process is a
    failed one; the next runs go on in a new process."""
    todo = [run for run in runs if key_of(row_of(mesh, run, thread_count)) not in records]
    # Memory is measured in a process that has done nothing else.
    for group in (
        [run for run in todo if run.measurement != "memory"],
        [run for run in todo if run.measurement == "memory"],
    ):
        for run, result in _results(mesh, group, thread_count):
            row = row_of(mesh, run, thread_count) | result | stamp
            records.add(row)
            on_row(row)


def _results(mesh: BenchMesh, runs: list[Run], thread_count: int) -> Iterable[tuple[Run, dict]]:
    """Each run with its result; all that are left have failed where the mesh can not be read."""
    job = {"mesh": asdict(mesh), "thread_count": thread_count}
    waiting = collections.deque(runs)
    try:
        tasks = [run.as_job() for run in runs]
        for _, result in workers.results("spheroseg.bench.worker", job, tasks):
            yield waiting.popleft(), result
    except workers.WorkerError as error:
        for run in waiting:
            yield run, {"status": "failed", "error": str(error)}


def row_of(mesh: BenchMesh, run: Run, thread_count: int) -> dict:
    """What is known of a run before it is done."""
    is_ours = run.method.startswith(OURS_PREFIX)
    return {
        "mesh": mesh.name,
        "mesh_sha256": mesh.digest,
        "triangle_count": mesh.triangle_count,
        "submesh_count": run.submesh_count,
        "method": run.method,
        "measurement": run.measurement,
        "seed": run.seed,
        "threads": thread_count if is_ours and run.measurement != "one_thread" else 1,
    }
