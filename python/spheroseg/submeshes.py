# SPDX-License-Identifier: GPL-3.0-or-later
"""A labelled mesh as one block of arrays per sub-mesh, the form that a GPU reads."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from spheroseg.arrays import as_labels, as_mesh, as_single_precision
from spheroseg.dual_graph import build_dual_graph
from spheroseg.errors import InputError

# The largest 16-bit value restarts primitives on some devices, so no vertex may have it as index.
MAX_SHORT_VERTICES = 65535
# More than there are triangles are taken up to here: what is written grows with the empty ones.
_MOST_SUBMESHES = 65536
# Of the mesh's size: single precision keeps a position up to here within 1e-6 of that size.
_FARTHEST = 16


@dataclass(frozen=True, eq=False)
class SubMeshes:
    """k sub-meshes in CSR form: block i of an array lies at [starts[i], starts[i + 1]).

    A vertex on a boundary is in the block of every sub-mesh that has it.
    """

    #: (k + 1) bounds of each sub-mesh in the arrays per local vertex.
    vertex_starts: np.ndarray
    #: Global vertex index of each local vertex, rising within a block.
    source_vertices: np.ndarray
    #: (n, 3) float32 position of each local vertex, from `origin` on; infinite where that type has
    #: no such number.
    positions: np.ndarray
    #: (3) float64: 0, or a point amid a mesh that single precision would not hold where it lies.
    origin: np.ndarray
    #: bool per local vertex: another sub-mesh has this vertex too.
    on_boundary: np.ndarray
    #: (k + 1) bounds of each sub-mesh in the arrays per triangle.
    triangle_starts: np.ndarray
    #: Global triangle index of each triangle, rising within a block.
    source_triangles: np.ndarray
    #: (F, 3) corners as local indices, counted from the block's first vertex; uint16 where every
    #: block has at most 65,535 vertices, else uint32.
    triangles: np.ndarray
    #: (k + 1) bounds of each sub-mesh in `neighbours` and `shared_edges`.
    neighbour_starts: np.ndarray
    #: Sub-meshes that share an edge with this one, rising within a block.
    neighbours: np.ndarray
    #: Number of edges shared with each of them.
    shared_edges: np.ndarray

    @property
    def count(self) -> int:
        return len(self.vertex_starts) - 1

    def block(self, submesh: int) -> tuple[np.ndarray, np.ndarray]:
        """Positions and local triangles of one sub-mesh."""
        return (
            self.positions[slice(*self.vertex_starts[submesh : submesh + 2])],
            self.triangles[slice(*self.triangle_starts[submesh : submesh + 2])],
        )

    def arrays(self) -> dict[str, np.ndarray]:
        return {field.name: getattr(self, field.name) for field in fields(self)}


def split_into_submeshes(
    vertices: np.ndarray, faces: np.ndarray, labels: np.ndarray, submesh_count: int | None = None
) -> SubMeshes:
    """Blocks for `labels` (one per face, in [0, k)); k is the largest label + 1 unless given.

    O(F log F + k). Raises InputError when an array can not be used, an edge has more than two
    faces, or a label is so large that nearly all sub-meshes would be empty.
    """
    vertices, faces = as_mesh(vertices, faces)
    labels = as_labels(labels, len(faces), submesh_count)
    if submesh_count is None:
        submesh_count = int(labels.max()) + 1
        if submesh_count > max(len(faces), _MOST_SUBMESHES):
            raise InputError(
                f"face {labels.argmax()} has the label {labels.max()}, which means "
                f"{submesh_count:,} sub-meshes of {len(faces):,} triangles; number the labels from "
                "0 on, as numpy.unique(labels, return_inverse=True)[1] does"
            )
    source_triangles = np.argsort(labels, kind="stable").astype(np.int32)
    triangle_starts = _starts(labels, submesh_count)
    vertex_count = len(vertices)
    key = labels[:, None].astype(np.int64) * vertex_count + faces
    unique, local = np.unique(key, return_inverse=True)
    owner, source_vertices = np.divmod(unique, vertex_count)
    vertex_starts = _starts(owner, submesh_count)
    local = local.reshape(-1, 3) - vertex_starts[labels][:, None]
    short = np.diff(vertex_starts).max() <= MAX_SHORT_VERTICES
    neighbour_starts, neighbours, shared_edges = _adjacency(faces, labels, submesh_count)
    points = vertices[source_vertices]
    origin = _origin(points)
    return SubMeshes(
        vertex_starts=vertex_starts,
        source_vertices=source_vertices.astype(np.int32),
        positions=as_single_precision(points - origin),
        origin=origin,
        on_boundary=np.bincount(source_vertices, minlength=vertex_count)[source_vertices] > 1,
        triangle_starts=triangle_starts,
        source_triangles=source_triangles,
        triangles=local[source_triangles].astype(np.uint16 if short else np.uint32),
        neighbour_starts=neighbour_starts,
        neighbours=neighbours,
        shared_edges=shared_edges,
    )


def _starts(owner: np.ndarray, count: int) -> np.ndarray:
    starts = np.zeros(count + 1, dtype=np.int64)
    np.cumsum(np.bincount(owner, minlength=count), out=starts[1:])
    return starts


def _origin(points: np.ndarray) -> np.ndarray:
    """The origin of `SubMeshes`: 0, or a point amid points that lie so far away that single
    precision would lose their shape. Its own coordinates are exact in single precision, as some
    readers add it to the positions there."""
    low, high = points.min(axis=0), points.max(axis=0)
    with np.errstate(over="ignore"):
        size = (high - low).max()
        centre = as_single_precision(low / 2 + high / 2).astype(np.float64)
        is_far = np.abs(points).max() > _FARTHEST * size
    return centre if is_far and np.isfinite(centre).all() else np.zeros(3)


def _adjacency(faces: np.ndarray, labels: np.ndarray, submesh_count: int):
    neighbours = build_dual_graph(faces).neighbours
    here = np.repeat(labels, 3).astype(np.int64)
    there = np.where(neighbours >= 0, labels[neighbours], labels[:, None]).ravel()
    cut = here != there
    pairs, edges = np.unique(here[cut] * submesh_count + there[cut], return_counts=True)
    owner, other = np.divmod(pairs, submesh_count)
    return _starts(owner, submesh_count), other.astype(np.int32), edges.astype(np.int32)
