# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours for sub-meshes: neighbours never share one."""

from __future__ import annotations

import colorsys

import numpy as np

# Hues far apart first; red is left out, as it marks bowties.
_HUES = (0.58, 0.13, 0.36, 0.76, 0.08, 0.49, 0.20, 0.66, 0.30, 0.87, 0.43, 0.54)


def palette(count: int) -> np.ndarray:
    """(count, 3) uint8 colours, none of them red."""
    colours = []
    for index in range(count):
        level, hue = divmod(index, len(_HUES))
        saturation = (0.55, 0.38, 0.75)[level % 3]
        value = (0.92, 0.70, 0.80)[level % 3] - 0.03 * (level // 3)
        colours.append(colorsys.hsv_to_rgb(_HUES[hue], saturation, max(value, 0.2)))
    return np.round(255 * np.array(colours).reshape(-1, 3)).astype(np.uint8)


def colour_indices(submesh_count: int, starts: np.ndarray, neighbours: np.ndarray) -> np.ndarray:
    """A colour number per sub-mesh, different for neighbours (CSR `starts`, `neighbours`).

    Greedy, by falling number of neighbours; among the colours free the one that was used least,
    out of at least six, so that no colour covers most of the mesh.
    """
    indices = np.full(submesh_count, -1, dtype=np.int32)
    uses = np.zeros(6, dtype=np.int64)
    for submesh in np.argsort(-np.diff(starts), kind="stable"):
        around = indices[neighbours[starts[submesh] : starts[submesh + 1]]]
        free = np.setdiff1d(np.arange(len(uses)), around)
        if len(free) == 0:
            free = np.array([len(uses)])
            uses = np.append(uses, 0)
        indices[submesh] = free[np.argmin(uses[free])]
        uses[indices[submesh]] += 1
    return indices
