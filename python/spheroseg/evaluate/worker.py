# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that runs all methods on one mesh: job as JSON from stdin, rows as JSON in a file.

A process per mesh gives memory back, keeps a crash to one mesh, and starts partitioners that carry
state from call to call the same way every time.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np

from spheroseg import api, atomic, mesh_files
from spheroseg.commands.shared import plain
from spheroseg.dual_graph import build_dual_graph
from spheroseg.errors import InputError
from spheroseg.evaluate.methods import METHODS
from spheroseg.evaluate.topology import anatomy

MEASURES = (
    "boundary_edge_count",
    "max_triangle_count_difference",
    "coefficient_of_variation",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
    "boundary_edge_ratio",
)


def main() -> int:
    job = json.load(sys.stdin)
    try:
        rows = evaluate_mesh(job)
        atomic.write_text(Path(job["rows"]), json.dumps(rows))
    except InputError as error:
        print(str(error).removeprefix(f"{job['mesh']}: "), file=sys.stderr)
        return 1
    except atomic.DiskFullError as error:
        print(error.strerror, file=sys.stderr)
        return 1
    return 0


def evaluate_mesh(job: dict) -> list[dict]:
    """A row per k and method. Labels go to `labels/NAME-kK-METHOD.npy`, the mesh's arrays to
    `labels/NAME.npz`."""
    mesh_set = mesh_files.read_mesh(job["mesh"])
    vertices = mesh_set.current_mesh().vertex_matrix()
    faces = np.ascontiguousarray(mesh_set.current_mesh().face_matrix(), dtype=np.int32)
    graph = build_dual_graph(faces)
    arrays_path = Path(job["folder"]) / f"{job['name']}.npz"
    arrays_path.parent.mkdir(parents=True, exist_ok=True)
    with atomic.atomic_path(arrays_path, ".npz") as temporary:
        np.savez(temporary, vertices=vertices, faces=faces)
    rows = []
    for k in job["submesh_counts"]:
        for name in job["methods"]:
            row = {"mesh": job["name"], "triangle_count": len(faces), "submesh_count": k}
            row |= {"method": name, "seed": job["seed"], "status": "done", "error": ""}
            obstacle = _obstacle(name, len(faces), k, job["all_pairs_limit"])
            if obstacle:
                row |= {"status": "left out", "error": obstacle}
            else:
                row |= _result(METHODS[name], vertices, faces, graph, k, job)
            rows.append(row)
    return rows


def _obstacle(name: str, face_count: int, k: int, all_pairs_limit: int) -> str | None:
    if k > face_count:
        return f"only {face_count:,} triangles"
    if name == "all_pairs" and face_count > all_pairs_limit:
        return f"above {all_pairs_limit:,} triangles"
    return None


def _result(method, vertices, faces, graph, k: int, job: dict) -> dict:
    try:
        outcome = method.run(vertices, faces, k, job["seed"], graph)
    except (InputError, ImportError, RuntimeError) as error:
        return {"status": "failed", "error": " ".join(str(error).split())}
    measures = api.measure(vertices, faces, outcome.labels)
    parts = anatomy(faces, graph, outcome.labels, k)
    file = f"{job['name']}-k{k}-{method.name}.npy"
    mesh_files.save_labels(outcome.labels, Path(job["folder"]) / file)
    hexagonal = math.sqrt(6 * len(faces) * k) / 2
    return {
        "seconds": outcome.seconds,
        **{key: measures[key] for key in MEASURES},
        "boundary_edges_over_hexagonal": measures["boundary_edge_count"] / hexagonal,
        "min_submesh_triangles": int(parts.triangle_counts.min()),
        "max_submesh_triangles": int(parts.triangle_counts.max()),
        "empty_submesh_count": int(np.count_nonzero(parts.triangle_counts == 0)),
        "shared_memory_bytes": parts.shared_memory_bytes,
        "labels": file,
        "details": plain(outcome.details),
    }


if __name__ == "__main__":
    sys.exit(main())
