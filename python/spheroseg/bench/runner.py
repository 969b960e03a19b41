# SPDX-License-Identifier: GPL-3.0-or-later
"""Does the runs of a plan mesh by mesh, each mesh in a process of its own."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict

from spheroseg.batch.jobs import package_environment
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
        while group:
            done = 0
            for run, result in zip(group, _results(mesh, group, thread_count), strict=False):
                row = row_of(mesh, run, thread_count) | result | stamp
                records.add(row)
                on_row(row)
                done += 1
            group = group[done:]


def _results(mesh: BenchMesh, runs: list[Run], thread_count: int) -> Iterable[dict]:
    """A result per run; a last one with the status `failed` where the process ended early."""
    job = {"mesh": asdict(mesh), "runs": [run.as_job() for run in runs]}
    with subprocess.Popen(
        [sys.executable, "-m", "spheroseg.bench.worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=package_environment(),
    ) as process:
        try:
            process.stdin.write(json.dumps(job | {"thread_count": thread_count}))
            process.stdin.close()
            for line in process.stdout:
                yield json.loads(line)
        except BaseException:
            process.kill()
            raise
    if process.returncode != 0:
        yield {"status": "failed", "error": f"the process ended with {process.returncode}"}


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
