# SPDX-License-Identifier: GPL-3.0-or-later
"""The dual graph of a triangle mesh in numpy: triangles that share an edge are neighbours."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from spheroseg.errors import InputError


@dataclass(frozen=True, eq=False)
class DualGraph:
    """`neighbours` is (F, 3) int32: the triangle across the edge from corner i to corner i + 1,
    or -1 on an open border. `starts` (F + 1) and `adjacent` hold the same as a CSR graph."""

    neighbours: np.ndarray
    starts: np.ndarray
    adjacent: np.ndarray

    @property
    def face_count(self) -> int:
        return len(self.neighbours)

    def edges(self) -> np.ndarray:
        """(E, 2) array of neighbouring triangles, each pair once, the smaller index first."""
        source = np.repeat(np.arange(self.face_count), np.diff(self.starts))
        once = source < self.adjacent
        return np.column_stack((source[once], self.adjacent[once]))

    @functools.cached_property
    def component_count(self) -> int:
        """Number of connected components, counted once."""
        return len(np.unique(self.component_of_triangle()))

    def component_of_triangle(self) -> np.ndarray:
        """The lowest triangle of the connected component that each triangle is in."""
        return lowest_connected(self.face_count, *self.edges().T)

    def fan_of_corner(self, faces: np.ndarray) -> np.ndarray:
        """(F, 3) int: equal for two corners in one fan, that is at one vertex, around which edges
        connect their triangles. A vertex where a surface is pinched has several fans."""
        face, side = np.nonzero(self.neighbours >= 0)
        beyond = faces[self.neighbours[face, side]]
        links = []
        for corner in (side, (side + 1) % 3):
            same = beyond == faces[face, corner][:, None]
            links.append((3 * face + corner, 3 * self.neighbours[face, side] + same.argmax(axis=1)))
        left, right = np.concatenate(links, axis=1)
        return lowest_connected(3 * self.face_count, left, right).reshape(-1, 3)


def lowest_connected(count: int, left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """(count,) int: for each node of an undirected graph the lowest node of its component.

    left, right: the nodes in [0, count) that each edge joins.
    """
    lowest = np.arange(count)
    while (apart := lowest[left] != lowest[right]).any():
        left, right = left[apart], right[apart]
        pair = lowest[left], lowest[right]
        np.minimum.at(lowest, np.maximum(*pair), np.minimum(*pair))
        while (lowest != (further := lowest[lowest])).any():
            lowest = further
    return lowest


def build_dual_graph(faces: np.ndarray) -> DualGraph:
    """Dual graph in O(F log F). Raises InputError when an edge has more than two triangles."""
    faces = np.asarray(faces)
    if faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError(f"faces must have shape (F, 3), but the shape is {faces.shape}")
    face_count = len(faces)
    corners = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
    key = corners.min(axis=1).astype(np.int64) << 32 | corners.max(axis=1)
    order = np.argsort(key, kind="stable")
    sorted_key = key[order]
    same = sorted_key[1:] == sorted_key[:-1]
    if np.any(same[1:] & same[:-1]):
        first, second = corners[order[:-2][same[1:] & same[:-1]][0]]
        raise InputError(
            f"the edge between vertices {first} and {second} has more than two triangles; "
            "repair the mesh first (in MeshLab: Repair non Manifold Edges)"
        )
    left, right = order[:-1][same], order[1:][same]
    neighbours = np.full(3 * face_count, -1, dtype=np.int32)
    neighbours[left] = right // 3
    neighbours[right] = left // 3
    neighbours = neighbours.reshape(-1, 3)
    return _with_csr(neighbours)


def _with_csr(neighbours: np.ndarray) -> DualGraph:
    # Two triangles that share two edges are one pair of the graph.
    present = neighbours >= 0
    present[:, 1] &= neighbours[:, 1] != neighbours[:, 0]
    present[:, 2] &= (neighbours[:, 2] != neighbours[:, 0]) & (neighbours[:, 2] != neighbours[:, 1])
    starts = np.zeros(len(neighbours) + 1, dtype=np.int64)
    np.cumsum(present.sum(axis=1), out=starts[1:])
    return DualGraph(neighbours, starts, neighbours[present].astype(np.int64))
