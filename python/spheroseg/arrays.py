# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks of the arrays that callers hand in; each message quotes what it found."""

import numpy as np
from numpy.typing import ArrayLike

from spheroseg.errors import InputError

#: Of labels: MeshLab keeps them in the face quality, which may be of 32 bits.
LABEL_LIMIT = 2**24


def as_mesh(vertices: ArrayLike, faces: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Arrays of (V, 3) float64 and, as `as_faces`, of (F, 3) int32. Vertices that a face names are
    finite; the others do not matter."""
    points = _double(_numeric("vertices", vertices, (3,), "(V, 3)"))
    triangles = as_faces(faces, len(points))
    bad = ~np.isfinite(points)
    if bad.any():
        is_named = np.zeros(len(points), dtype=bool)
        is_named[triangles] = True
        for row, column in np.argwhere(bad & is_named[:, np.newaxis])[:1]:
            raise InputError(
                f"vertices must be finite; vertex {row} has {'xyz'[column]} = {points[row, column]}"
            )
    return points, triangles


def as_faces(faces: ArrayLike, vertex_count: int) -> np.ndarray:
    """A (F, 3) array of int32 in [0, vertex_count), C-contiguous, F at least 1."""
    array = _whole("faces", _numeric("faces", faces, (3,), "(F, 3)"))
    if not len(array):
        raise InputError("faces must hold at least one triangle, got none")
    bad = np.argwhere((array < 0) | (array >= vertex_count))
    if len(bad):
        row, column = (int(index) for index in bad[0])
        raise InputError(
            f"faces must hold vertex indices in [0, {vertex_count}); face {row} names vertex "
            f"{array[row, column]}"
        )
    return array.astype(np.int32, order="C")


def as_labels(
    labels: ArrayLike,
    face_count: int,
    submesh_count: int | None = None,
    name: str = "labels",
) -> np.ndarray:
    """A (face_count,) array of int32 in [0, submesh_count), by default in [0, LABEL_LIMIT).
    `name`: what errors call it."""
    array = _whole(name, _numeric(name, labels, (), "(F,)"))
    if len(array) != face_count:
        raise InputError(f"{name} must have one entry per face: {face_count}, got {len(array)}")
    limit = LABEL_LIMIT if submesh_count is None else submesh_count
    bad = np.flatnonzero((array < 0) | (array >= limit))
    if len(bad):
        raise InputError(
            f"{name} must be whole numbers in [0, {limit}); face {bad[0]} has {array[bad[0]]}"
        )
    return array.astype(np.int32)


def as_face_weights(weights: ArrayLike, face_count: int) -> np.ndarray:
    """A (face_count,) array of float64; the filter checks the values."""
    array = _numeric("face_weights", weights, (), "(F,)")
    if len(array) != face_count:
        raise InputError(
            f"face_weights must have one entry per face: {face_count}, got {len(array)}"
        )
    return _double(array)


def _numeric(name: str, values: ArrayLike, tail: tuple[int, ...], shape: str) -> np.ndarray:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{name} must be an array of shape {shape}: {error}") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"{name} must be numbers, got an array of {array.dtype}")
    if array.ndim != 1 + len(tail) or array.shape[1:] != tail:
        raise InputError(f"{name} must have the shape {shape}, got {array.shape}")
    return array


def _whole(name: str, array: np.ndarray) -> np.ndarray:
    if array.dtype.kind != "f":
        return array
    bad = np.argwhere(~np.isfinite(array) | (array != np.floor(array)))
    if len(bad):
        index = tuple(int(part) for part in bad[0])
        raise InputError(f"{name} must be whole numbers; the entry at {index} is {array[index]}")
    # Limits are beyond what 16 bits hold.
    return array.astype(np.result_type(array, np.float32), copy=False)


def _double(array: np.ndarray) -> np.ndarray:
    """As C-contiguous float64; infinite where a longer type has a number beyond it."""
    with np.errstate(over="ignore"):
        return array.astype(np.float64, order="C")


def as_single_precision(values: np.ndarray) -> np.ndarray:
    """As float32; infinite where that type has no such number."""
    with np.errstate(over="ignore"):
        return values.astype(np.float32)
