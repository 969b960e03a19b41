# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours for sub-meshes: neighbours never share one."""

from __future__ import annotations

import heapq

import numpy as np

# Those of the plugin (engine/coloring.cpp): far apart for people with normal sight, protanopia,
# deuteranopia and tritanopia. None is red, which marks bowties.
PALETTE = (
    (237, 238, 84),
    (107, 255, 223),
    (112, 83, 80),
    (90, 67, 198),
    (113, 124, 9),
    (210, 154, 129),
    (43, 146, 153),
    (182, 185, 255),
)


def palette(count: int) -> np.ndarray:
    """(count, 3) uint8 colours: `PALETTE`, then lighter and darker variants of it."""
    index = np.arange(count)
    turn = index // len(PALETTE)
    target = np.where(turn % 2 == 1, 255.0, 0.0)
    share = 1.0 - 1.0 / (1.0 + 0.35 * ((turn + 1) // 2))
    colours = np.array(PALETTE, dtype=float)[index % len(PALETTE)]
    return np.round(colours + (target[:, None] - colours) * share[:, None]).astype(np.uint8)


def colour_indices(submesh_count: int, starts: np.ndarray, neighbours: np.ndarray) -> np.ndarray:
    """A colour number per sub-mesh, different for neighbours (CSR `starts`, `neighbours`).

    Among the colours free the one that was used least. Where the sub-meshes of a closed mesh of
    genus 0 are connected, their graph is planar and `PALETTE` suffices.
    """
    indices = np.full(submesh_count, -1, dtype=np.int32)
    uses = np.zeros(len(PALETTE), dtype=np.int64)
    for submesh in _smallest_last_order(starts, neighbours):
        around = indices[neighbours[starts[submesh] : starts[submesh + 1]]]
        free = np.setdiff1d(np.arange(len(uses)), around)
        if len(free) == 0:
            free = np.array([len(uses)])
            uses = np.append(uses, 0)
        indices[submesh] = free[np.argmin(uses[free])]
        uses[indices[submesh]] += 1
    return indices


def _smallest_last_order(starts: np.ndarray, neighbours: np.ndarray) -> list[int]:
    """Each has few neighbours among those before it: at most five in a planar graph."""
    degree = np.diff(starts).tolist()
    heap = [(d, submesh) for submesh, d in enumerate(degree)]
    heapq.heapify(heap)
    order = []
    while heap:
        d, submesh = heapq.heappop(heap)
        if d != degree[submesh]:
            continue
        degree[submesh] = -1
        order.append(submesh)
        for other in neighbours[starts[submesh] : starts[submesh + 1]].tolist():
            if degree[other] >= 0:
                degree[other] -= 1
                heapq.heappush(heap, (degree[other], other))
    return order[::-1]
