# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pictures and the 3D view show of a labelling: boundaries, bowties, counts, memory."""

from dataclasses import dataclass

import numpy as np

from spheroseg.dual_graph import DualGraph

# A vertex is three floats, a corner of a triangle a 16-bit index.
VERTEX_BYTES = 12
TRIANGLE_BYTES = 6


@dataclass(frozen=True, eq=False)
class Anatomy:
    """`boundary_edges` (n, 2): vertices of each edge between two sub-meshes, once.
    `bowtie_vertices`: one entry per bowtie. The others have an entry per sub-mesh."""

    boundary_edges: np.ndarray
    bowtie_vertices: np.ndarray
    triangle_counts: np.ndarray
    vertex_counts: np.ndarray
    edge_counts: np.ndarray
    bowtie_counts: np.ndarray

    @property
    def shared_memory_bytes(self) -> int:
        """Memory of the sub-mesh that needs most: its vertices and its local indices."""
        return int(
            (VERTEX_BYTES * self.vertex_counts + TRIANGLE_BYTES * self.triangle_counts).max()
        )


def anatomy(faces: np.ndarray, graph: DualGraph, labels: np.ndarray, k: int) -> Anatomy:
    """O(F log F), in numpy: independent of the plugin's measures, so that each checks the other."""
    vertex_count = int(faces.max()) + 1
    neighbours = graph.neighbours
    here = np.repeat(labels, 3).reshape(-1, 3)
    there = np.where(neighbours >= 0, labels[neighbours], here)
    cut = here != there
    ends = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2)
    # Each inner edge is seen from both triangles: keep the view of the smaller one.
    once = np.arange(len(faces))[:, None] < neighbours
    # Each fan of the mesh counts as a vertex of its own. There a sub-mesh's t triangles with j
    # inner joints form t - j fans, or one when they close up (t = j).
    corners = graph.fan_of_corner(faces)
    pairs, index = np.unique(
        labels[:, None].astype(np.int64) * corners.size + corners, return_inverse=True
    )
    index = index.reshape(-1, 3)
    triangles = np.bincount(index.ravel(), minlength=len(pairs))
    joined = once & ~cut
    joints = np.bincount(index[joined], minlength=len(pairs))
    joints += np.bincount(np.roll(index, -1, axis=1)[joined], minlength=len(pairs))
    fans = np.maximum(triangles - joints, 1)
    owner, corner = np.divmod(pairs, corners.size)
    vertices_of_submesh = np.unique(labels[:, None].astype(np.int64) * vertex_count + faces)
    return Anatomy(
        boundary_edges=ends[once & cut],
        bowtie_vertices=np.repeat(faces.ravel()[corner], fans - 1),
        triangle_counts=np.bincount(labels, minlength=k),
        vertex_counts=np.bincount(vertices_of_submesh // vertex_count, minlength=k),
        edge_counts=np.bincount(here[cut], minlength=k),
        bowtie_counts=np.bincount(owner, weights=fans - 1, minlength=k).astype(np.int64),
    )
