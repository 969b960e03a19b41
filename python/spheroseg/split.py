# SPDX-License-Identifier: GPL-3.0-or-later
"""One PLY file per sub-mesh, with the way back to the mesh that it comes from."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from spheroseg import atomic
from spheroseg.ply import colour_properties, ply_bytes
from spheroseg.submeshes import SubMeshes

MANIFEST_NAME = "manifest.json"


def write_split(
    submeshes: SubMeshes,
    vertices: np.ndarray,
    folder: Path,
    source: str,
    face_colours: np.ndarray | None = None,
    vertex_colours: np.ndarray | None = None,
) -> Path:
    """Writes `submesh_0000.ply` and so on and, last, `manifest.json`; returns its path.

    Each file has the vertex property `source_vertex`, the face property `source_face` and, as face
    `quality`, the label. `face_colours`, (F, 3) uint8, and `vertex_colours`, (V, 4), are kept where
    given. An empty sub-mesh has no file: its entry in the manifest says null. Where not all can be
    written, also after a KeyboardInterrupt, none of the new files stays.
    """
    digits = max(4, len(str(submeshes.count - 1)))
    entries = []
    with atomic.all_or_none(Path(folder)) as write:
        for submesh in range(submeshes.count):
            name = f"submesh_{submesh:0{digits}d}.ply"
            positions, triangles = submeshes.block(submesh)
            if len(triangles) > 0:
                data = _submesh_bytes(submeshes, submesh, vertices, face_colours, vertex_colours)
                write(name, data)
            entries.append(_entry(submeshes, submesh, name, len(positions), len(triangles)))
        manifest = {"source": source, "submesh_count": submeshes.count, "submeshes": entries}
        write(MANIFEST_NAME, (json.dumps(manifest, indent=1) + "\n").encode())
    return Path(folder) / MANIFEST_NAME


def _submesh_bytes(
    submeshes: SubMeshes, submesh: int, vertices, face_colours, vertex_colours
) -> bytes:
    source_vertices = submeshes.source_vertices[
        slice(*submeshes.vertex_starts[submesh : submesh + 2])
    ]
    source_faces = submeshes.source_triangles[
        slice(*submeshes.triangle_starts[submesh : submesh + 2])
    ]
    face_properties = {
        "quality": np.full(len(source_faces), submesh, dtype=np.float32),
        "source_face": source_faces,
    }
    if face_colours is not None:
        face_properties |= colour_properties(face_colours[source_faces])
    vertex_properties = {"source_vertex": source_vertices}
    if vertex_colours is not None:
        vertex_properties |= colour_properties(vertex_colours[source_vertices])
    return ply_bytes(
        np.asarray(vertices)[source_vertices],
        submeshes.block(submesh)[1],
        vertex_properties,
        face_properties,
    )


def _entry(submeshes: SubMeshes, submesh: int, name: str, vertex_count: int, face_count: int):
    around = slice(*submeshes.neighbour_starts[submesh : submesh + 2])
    return {
        "submesh": submesh,
        "file": name if face_count > 0 else None,
        "vertex_count": vertex_count,
        "triangle_count": face_count,
        "neighbours": submeshes.neighbours[around].tolist(),
        "shared_edges": submeshes.shared_edges[around].tolist(),
    }
