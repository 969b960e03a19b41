# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that does the runs of one mesh: job as JSON from stdin, a line of JSON per run.

A process per mesh gives memory back and keeps a crash to one run.
"""

import json
import os
import sys

import numpy as np

from spheroseg import api
from spheroseg.bench.meshes import BenchMesh, read
from spheroseg.bench.methods import MeshRuns, Timed

MEASURES = (
    "boundary_edge_count",
    "max_triangle_count_difference",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
)


def main() -> int:
    # Partitioners print; the rows have a channel of their own.
    channel = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    job = json.load(sys.stdin)
    vertices, faces = read(BenchMesh(**job["mesh"]))
    mesh_runs = MeshRuns(vertices, faces)
    for run in job["runs"]:
        print(json.dumps(result(mesh_runs, run, job["thread_count"])), file=channel, flush=True)
    return 0


def result(mesh_runs: MeshRuns, run: dict, thread_count: int) -> dict:
    """Status, clock and measures of one run."""
    try:
        timed = perform(mesh_runs, run, thread_count)
        labels = timed.labels
        measures = api.measure(mesh_runs.vertices, mesh_runs.faces, labels)
    except Exception as error:  # noqa: BLE001 (whatever a rival throws is one failed run)
        return {"status": "failed", "error": " ".join(f"{type(error).__name__}: {error}".split())}
    return {
        "status": "done",
        "error": "",
        "seconds": timed.seconds,
        "found_submesh_count": len(np.unique(labels)),
        "min_submesh_triangles": int(measures["submesh_triangles"].min()),
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
    sys.exit(main())
