# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed meshes made in code for the tests of baselines, evaluation, batch and export."""

from __future__ import annotations

import numpy as np


def octahedron() -> tuple[np.ndarray, np.ndarray]:
    vertices = np.array(
        [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float
    )
    upper = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]]
    lower = [[2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]]
    return vertices, np.array(upper + lower, dtype=np.int32)


def subdivided_sphere(levels: int) -> tuple[np.ndarray, np.ndarray]:
    """Octahedron with each triangle split in four `levels` times: 8 * 4**levels triangles."""
    vertices, faces = octahedron()
    for _ in range(levels):
        edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        unique, index = np.unique(edges, axis=0, return_inverse=True)
        middle = vertices[unique].sum(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        ab, bc, ca = (len(vertices) + index.reshape(-1, 3)).T
        a, b, c = faces.T
        faces = np.concatenate(
            [np.column_stack(t) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
        ).astype(np.int32)
        vertices = np.concatenate((vertices, middle))
    return vertices, faces


def bumpy_sphere(levels: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A subdivided sphere pushed in and out by a few random waves; star-shaped, so closed."""
    vertices, faces = subdivided_sphere(levels)
    generator = np.random.default_rng(seed)
    waves = generator.normal(size=(4, 3)) * 3
    phase = generator.uniform(0, 6, size=4)
    height = 1 + 0.12 * np.cos(vertices @ waves.T + phase).sum(axis=1)
    return vertices * height[:, None], faces


def star_of_strips(length: int) -> tuple[np.ndarray, np.ndarray]:
    """A triangle with a strip of `length` triangles on each side; any places."""
    faces = [(0, 1, 2)]
    for side in range(3):
        a, b = side, (side + 1) % 3
        for i in range(length):
            tip = len(faces) + 2
            faces.append((b, a, tip))
            a, b = (tip, b) if i % 2 == 0 else (a, tip)
    return np.random.default_rng(0).normal(size=(len(faces) + 2, 3)), np.array(faces)
