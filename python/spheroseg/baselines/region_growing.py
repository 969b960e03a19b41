# SPDX-License-Identifier: GPL-3.0-or-later
"""Region growing as the paper compares with it (after Lavoué, Dupont, Baskurt 2005 and Yamauchi,
Gumhold, Zayer, Seidel 2005): random seeds; each region in turn takes the unassigned neighbour
nearest to its centre that makes no bowtie.

The inner loop is compiled by numba: it scans a region's whole rim at every step, as its centre
moves, which is too slow in plain Python and of no use to the plugin's engine.
"""

from __future__ import annotations

import numpy as np

from spheroseg.baselines._common import checked_graph, require
from spheroseg.dual_graph import DualGraph

require("numba")
from numba import njit  # noqa: E402 (after the message for a missing package)


def segment(
    vertices: np.ndarray, faces: np.ndarray, k: int, seed: int, *, graph: DualGraph | None = None
) -> np.ndarray:
    """Labels by region growing: connected, bowtie-free, not balanced.

    The centre is the mean of the region's triangle centroids. Where every region is blocked by
    bowties, the triangle that makes fewest is assigned and growth goes on (this does not happen on
    closed genus-0 meshes in practice). Components without a seed go to the nearest centre.
    O(F sqrt(F/k)) for round regions.
    """
    graph = checked_graph(faces, k, seed, graph)
    faces = np.ascontiguousarray(faces, dtype=np.int32)
    centroids = np.asarray(vertices, dtype=np.float64)[faces].mean(axis=1)
    seeds = np.random.default_rng(seed).choice(len(faces), size=k, replace=False)
    vertex_starts, vertex_faces = _faces_around_vertices(faces, len(vertices))
    return _grow(faces, graph.neighbours, centroids, vertex_starts, vertex_faces, seeds)


def _faces_around_vertices(faces: np.ndarray, vertex_count: int):
    starts = np.zeros(vertex_count + 1, dtype=np.int64)
    np.cumsum(np.bincount(faces.ravel(), minlength=vertex_count), out=starts[1:])
    order = np.argsort(faces.ravel(), kind="stable")
    return starts, (order // 3).astype(np.int32)


@njit(cache=True)
def _bowties_made(face, region, faces, neighbours, vertex_starts, vertex_faces, labels):
    """Corners of `face` where the region's triangles would form one more fan."""
    made = 0
    for corner in range(3):
        ahead = neighbours[face, corner]
        behind = neighbours[face, (corner + 2) % 3]
        if (ahead >= 0 and labels[ahead] == region) or (behind >= 0 and labels[behind] == region):
            continue
        vertex = faces[face, corner]
        for slot in range(vertex_starts[vertex], vertex_starts[vertex + 1]):
            if labels[vertex_faces[slot]] == region:
                made += 1
                break
    return made


@njit(cache=True)
def _assign(
    face, region, neighbours, centroids, labels, sums, counts, heads, rim_face, rim_next, rim_size
):
    """Gives the face to the region, whose rim grows by the face's free neighbours; returns the new
    number of rim entries."""
    labels[face] = region
    sums[region] += centroids[face]
    counts[region] += 1
    for side in range(3):
        other = neighbours[face, side]
        if other >= 0 and labels[other] < 0:
            rim_face[rim_size] = other
            rim_next[rim_size] = heads[region]
            heads[region] = rim_size
            rim_size += 1
    return rim_size


@njit(cache=True)
def _nearest_on_rim(
    region,
    bowties_allowed,
    centre,
    centroids,
    faces,
    neighbours,
    vertex_starts,
    vertex_faces,
    labels,
    heads,
    rim_face,
    rim_next,
):
    """The rim's triangle nearest to the centre (ties: lowest index) that makes no more than
    `bowties_allowed` bowties, or -1. Drops assigned triangles from the rim's list."""
    best_face = -1
    best_distance = np.inf
    previous = -1
    node = heads[region]
    while node >= 0:
        face = rim_face[node]
        after = rim_next[node]
        if labels[face] >= 0:
            if previous < 0:
                heads[region] = after
            else:
                rim_next[previous] = after
            node = after
            continue
        dx = centroids[face, 0] - centre[0]
        dy = centroids[face, 1] - centre[1]
        dz = centroids[face, 2] - centre[2]
        distance = dx * dx + dy * dy + dz * dz
        nearer = distance < best_distance or (distance == best_distance and face < best_face)
        if nearer and (
            _bowties_made(face, region, faces, neighbours, vertex_starts, vertex_faces, labels)
            <= bowties_allowed
        ):
            best_face = face
            best_distance = distance
        previous = node
        node = after
    return best_face


@njit(cache=True)
def _region_nearest_to(face, centroids, sums, counts):
    best_region = 0
    best_distance = np.inf
    for region in range(len(counts)):
        offset = centroids[face] - sums[region] / counts[region]
        distance = (offset * offset).sum()
        if distance < best_distance:
            best_distance = distance
            best_region = region
    return best_region


@njit(cache=True)
def _grow(faces, neighbours, centroids, vertex_starts, vertex_faces, seeds):
    face_count = len(faces)
    k = len(seeds)
    labels = np.full(face_count, -1, dtype=np.int32)
    sums = np.zeros((k, 3))
    counts = np.zeros(k, dtype=np.int64)
    heads = np.full(k, -1, dtype=np.int64)
    # Each side of each triangle puts its neighbour on a rim at most once.
    rim_face = np.empty(3 * face_count, dtype=np.int32)
    rim_next = np.empty(3 * face_count, dtype=np.int64)
    regions = (neighbours, centroids, labels, sums, counts, heads, rim_face, rim_next)
    mesh = (centroids, faces, neighbours, vertex_starts, vertex_faces, labels)
    rim_size = 0
    for region in range(k):
        rim_size = _assign(seeds[region], region, *regions, rim_size)
    assigned = k
    bowties_allowed = 0
    first_unassigned = 0
    while assigned < face_count:
        grown = 0
        for region in range(k):
            centre = sums[region] / counts[region]
            face = _nearest_on_rim(
                region, bowties_allowed, centre, *mesh, heads, rim_face, rim_next
            )
            if face < 0:
                continue
            rim_size = _assign(face, region, *regions, rim_size)
            grown += 1
            if bowties_allowed > 0:
                break
        if grown == 0 and bowties_allowed == 3:
            # No region reaches what is left: another component.
            while labels[first_unassigned] >= 0:
                first_unassigned += 1
            region = _region_nearest_to(first_unassigned, centroids, sums, counts)
            rim_size = _assign(first_unassigned, region, *regions, rim_size)
            grown = 1
        bowties_allowed = 0 if grown > 0 else bowties_allowed + 1
        assigned += grown
    return labels
