# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that does the runs of one mesh.

A process per mesh gives memory back and keeps a crash to one run.
"""

import sys
from collections.abc import Callable

import numpy as np

from spheroseg import api, workers
from spheroseg.bench.meshes import BenchMesh, read
from spheroseg.bench.methods import MeshRuns, Timed

MEASURES = (
    "boundary_edge_count",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
)


def prepare(job: dict) -> tuple[dict, Callable[[dict], dict]]:
    """See `workers.serve`. The tasks are runs (plan.py)."""
    mesh_runs = MeshRuns(*read(BenchMesh(**job["mesh"])))

    def do(task: dict) -> dict:
        return result(mesh_runs, task, job["thread_count"])

    return {}, do


def result(mesh_runs: MeshRuns, run: dict, thread_count: int) -> dict:
    """Status, clock and measures of one run."""
    timed = perform(mesh_runs, run, thread_count)
    measures = api.measure(mesh_runs.vertices, mesh_runs.faces, timed.labels)
    # Of all sub-meshes asked for: the measures end with the highest label in use.
    counts = np.bincount(timed.labels, minlength=run["submesh_count"])
    return {
        "status": "done",
        "error": "",
        "seconds": timed.seconds,
        "found_submesh_count": int(np.count_nonzero(counts)),
        "min_submesh_triangles": int(counts.min()),
        "max_triangle_count_difference": int(np.ptp(counts)),
        **{name: measures[name] for name in MEASURES},
        **timed.details,
    }


def perform(mesh_runs: MeshRuns, run: dict, thread_count: int) -> Timed:
    method, k, seed = run["method"], run["submesh_count"], run["seed"]
    if not method.startswith("fast_"):
        return mesh_runs.rival(method, k, seed)
    effort = method.removeprefix("fast_")
    if run["measurement"] == "again":
        return mesh_runs.second_call(effort, k, seed, thread_count, run["before"])
    if run["measurement"] == "memory":
        return mesh_runs.memory(effort, k, seed, thread_count)
    if run["measurement"] == "one_thread":
        thread_count = 1
    return mesh_runs.first_call(effort, k, seed, thread_count)


if __name__ == "__main__":
    sys.exit(workers.serve(prepare))
