# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that runs all methods on one mesh.

A process per mesh gives memory back, keeps a crash to one run, and starts partitioners that carry
state from call to call the same way every time.
"""

import statistics
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

from spheroseg import api, atomic, mesh_files, workers
from spheroseg.dual_graph import DualGraph, build_dual_graph
from spheroseg.errors import InputError, MissingPackageError
from spheroseg.evaluate.folder import arrays_file, stem
from spheroseg.evaluate.judging import hexagonal_bound, is_valid
from spheroseg.evaluate.methods import METHODS, Outcome
from spheroseg.evaluate.topology import anatomy

# Says the engine (errors.h).
MEMORY_REFUSED = "not enough memory"
MEASURES = (
    "boundary_edge_count",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
    "boundary_edge_ratio",
)


def prepare(job: dict) -> tuple[dict, Callable[[dict], dict]]:
    """See `workers.serve`. The mesh's arrays go to `labels/NAME.npz`."""
    mesh_set = mesh_files.read_mesh(job["mesh"])
    vertices = mesh_set.current_mesh().vertex_matrix()
    faces = np.ascontiguousarray(mesh_set.current_mesh().face_matrix(), dtype=np.int32)
    graph = build_dual_graph(faces)
    path = Path(job["folder"]) / arrays_file(job["name"])
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic.atomic_path(path, ".npz") as temporary:
        np.savez(temporary, vertices=vertices, faces=faces)

    def do(task: dict) -> dict:
        return result(vertices, faces, graph, job, task["submesh_count"], task["method"])

    return {"triangle_count": len(faces)}, do


def result(vertices, faces, graph: DualGraph, job: dict, k: int, method: str) -> dict:
    """Status, clock and measures of one method; labels go to `labels/NAME-kK-METHOD.npy`.

    Of several seeds it is the run with the median boundary (of the shorter of two), with the median
    of all times.
    """
    # What a method does not take is no fault of it.
    obstacle = _obstacle(method, len(faces), k, job["all_pairs_limit"])
    if obstacle:
        return {"status": "left out", "error": obstacle}
    runs = []
    for seed in range(job["seed"], job["seed"] + job["seed_count"]):
        try:
            outcome = METHODS[method].run(vertices, faces, k, seed, graph)
        except MissingPackageError:
            raise
        except InputError as error:
            if MEMORY_REFUSED in str(error):
                raise
            return {"status": "left out", "error": workers.explained(error)}
        runs.append((outcome, {"seed": seed} | judged(vertices, faces, graph, outcome, k)))
    runs.sort(key=lambda run: run[1]["boundary_edge_count"])
    outcome, measures = runs[(len(runs) - 1) // 2]
    file = f"{stem(job['name'], k, method)}.npy"
    mesh_files.save_labels(outcome.labels, Path(job["folder"]) / "labels" / file)
    return {
        "status": "done",
        "error": "",
        "run_count": len(runs),
        "valid_run_count": sum(is_valid(judged) for _, judged in runs),
        "seconds": statistics.median(run.seconds for run, _ in runs),
        **measures,
        "labels": file,
        "details": api.plain(outcome.details),
    }


def judged(vertices, faces, graph: DualGraph, outcome: Outcome, k: int) -> dict:
    """What the tables say of one result: k sub-meshes were asked for, and empty ones count."""
    measures = api.measure(vertices, faces, outcome.labels)
    parts = anatomy(faces, graph, outcome.labels, k)
    counts = parts.triangle_counts
    bound = hexagonal_bound(len(faces), k)
    return {
        **{key: measures[key] for key in MEASURES},
        "boundary_edges_over_hexagonal": measures["boundary_edge_count"] / bound,
        "min_submesh_triangles": int(counts.min()),
        "max_submesh_triangles": int(counts.max()),
        "max_triangle_count_difference": int(np.ptp(counts)),
        "coefficient_of_variation": float(counts.std() / counts.mean()),
        "empty_submesh_count": int(np.count_nonzero(counts == 0)),
        "shared_memory_bytes": parts.shared_memory_bytes,
    }


def _obstacle(name: str, face_count: int, k: int, all_pairs_limit: int) -> str | None:
    if k > face_count:
        return f"only {face_count:,} triangle{'' if face_count == 1 else 's'}"
    if name == "all_pairs" and face_count > all_pairs_limit:
        return f"above {all_pairs_limit:,} triangles"
    return None


if __name__ == "__main__":
    sys.exit(workers.serve(prepare))
