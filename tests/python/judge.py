# SPDX-License-Identifier: GPL-3.0-or-later
"""Judges labels on any surface in numpy and scipy, from the definitions (docs/measures.md,
docs/input.md); shares no code with the package. recount.py does the same slowly, and
test_surfaces.py compares the two."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True)
class Verdict:
    boundary_edge_count: int
    max_triangle_count_difference: int
    min_submesh_triangles: int
    disconnected_submesh_count: int
    bowtie_count: int


class Judge:
    """A surface, ready to judge labels. An edge joins two faces when it has exactly two sides."""

    def __init__(self, faces: np.ndarray):
        self.faces = np.asarray(faces)
        self.face_count = len(faces)
        ends = np.stack((self.faces, np.roll(self.faces, -1, axis=1)), axis=2).reshape(-1, 2)
        low, high = np.sort(ends, axis=1).astype(np.int64).T
        _, edge, sides = np.unique(low << 32 | high, return_inverse=True, return_counts=True)
        order = np.argsort(edge, kind="stable")
        order = order[sides[edge[order]] == 2]
        one, other = order[0::2], order[1::2]
        self.pairs = np.column_stack((one // 3, other // 3))
        self.edge_count = len(sides)
        self.sides = (one, other)
        # At each end of the edge the corners of both faces are joined.
        starts_there, ends_there = other, self._ahead(other)
        same_way = ends[one, 0] == ends[other, 0]
        self.joints = np.concatenate(
            (
                np.column_stack((one, np.where(same_way, starts_there, ends_there))),
                np.column_stack((self._ahead(one), np.where(same_way, ends_there, starts_there))),
            )
        )
        self.component_of_face = pieces(self.face_count, self.pairs)
        self.fan_of_corner = pieces(3 * self.face_count, self.joints)

    @staticmethod
    def _ahead(corner):
        return corner - corner % 3 + (corner + 1) % 3

    def component_sizes(self) -> np.ndarray:
        return np.bincount(self.component_of_face)

    def judge(self, labels: np.ndarray, submesh_count: int) -> Verdict:
        labels = np.asarray(labels)
        counts = np.bincount(labels, minlength=submesh_count)
        assert len(counts) == submesh_count
        alike = labels[self.pairs[:, 0]] == labels[self.pairs[:, 1]]
        piece = pieces(self.face_count, self.pairs[alike])
        # Labels of the pieces: a label that comes twice is in two pieces.
        label_of_piece = labels[np.unique(piece, return_index=True)[1]]
        pieces_per_label = np.bincount(label_of_piece, minlength=submesh_count)
        corner_labels = np.repeat(labels, 3)
        alike = corner_labels[self.joints[:, 0]] == corner_labels[self.joints[:, 1]]
        fans = pieces(3 * self.face_count, self.joints[alike]).max() + 1
        own = np.unique(self.fan_of_corner.astype(np.int64) * submesh_count + corner_labels)
        return Verdict(
            boundary_edge_count=int((labels[self.pairs[:, 0]] != labels[self.pairs[:, 1]]).sum()),
            max_triangle_count_difference=int(counts.max() - counts.min()),
            min_submesh_triangles=int(counts.min()),
            disconnected_submesh_count=int((pieces_per_label > 1).sum()),
            bowtie_count=int(fans) - len(own),
        )


def pieces(count: int, links: np.ndarray) -> np.ndarray:
    """Number of the connected piece that each of `count` things is in."""
    graph = coo_array((np.ones(len(links)), links.T), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def best_difference(sizes: np.ndarray, submesh_count: int) -> int:
    """Least MTCD of components parted as evenly as can be. With all counts in [least, most], a
    component of n faces takes from ceil(n / most) to floor(n / least) sub-meshes."""
    sizes = np.asarray(sizes)
    total = int(sizes.sum())
    best = int(sizes.max())
    # The mean lies between least and most.
    for least in range(min(int(sizes.min()), total // submesh_count), 0, -1):
        upper = sizes // least
        if upper.sum() < submesh_count:
            continue
        for most in range(-(-total // submesh_count), least + best):
            lower = -(-sizes // most)
            if (lower <= upper).all() and lower.sum() <= submesh_count:
                best = most - least
                break
    return best


def all_shares(sizes: tuple[int, ...], submesh_count: int):
    """Every way to give each component one sub-mesh or more, no more than its faces."""
    if len(sizes) == 1:
        if 1 <= submesh_count <= sizes[0]:
            yield (submesh_count,)
        return
    for own in range(1, min(sizes[0], submesh_count - len(sizes) + 1) + 1):
        for rest in all_shares(sizes[1:], submesh_count - own):
            yield (own, *rest)


def share_quality(sizes, shares) -> tuple[int, int, int]:
    """What shares are judged by, less is better: MTCD, largest sub-mesh, sum of squared counts
    (which orders as the variance does, the mean being F / k)."""
    counts = [
        n // parts + (i < n % parts)
        for n, parts in zip(sizes, shares, strict=True)
        for i in range(parts)
    ]
    return max(counts) - min(counts), max(counts), sum(count * count for count in counts)
