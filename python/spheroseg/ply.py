# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary PLY files with per-vertex and per-face properties.

Written here and not by MeshLab, whose writer neither reports a full disk nor takes properties
of other names.
"""

from __future__ import annotations

import numpy as np

from spheroseg.arrays import as_single_precision

_PLY_TYPES = {"f4": "float", "f8": "double", "i4": "int", "u1": "uchar", "u2": "ushort"}


def ply_bytes(
    vertices: np.ndarray,
    faces: np.ndarray,
    vertex_properties: dict[str, np.ndarray] | None = None,
    face_properties: dict[str, np.ndarray] | None = None,
) -> bytes:
    """A binary little-endian PLY file of a triangle mesh.

    `vertices` (V, 3), written as float32 where that loses nothing, else as float64; `faces`
    (F, 3), indices in [0, V). A property is an array with one entry per vertex or face.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    single = as_single_precision(vertices)
    position = single if np.array_equal(single, vertices) else vertices
    vertex_columns = {axis: position[:, i] for i, axis in enumerate("xyz")}
    vertex_columns |= vertex_properties or {}
    vertex_table, vertex_header = _table(vertex_columns, len(vertices))
    face_columns = {"count": np.full(len(faces), 3, dtype=np.uint8)}
    face_columns |= {f"corner{i}": np.asarray(faces)[:, i].astype(np.int32) for i in range(3)}
    corner_columns = len(face_columns)
    face_columns |= face_properties or {}
    face_table, face_header = _table(face_columns, len(faces))
    header = ["ply", "format binary_little_endian 1.0", "comment written by SpheroSeg"]
    header += [f"element vertex {len(vertices)}", *vertex_header]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    header += [*face_header[corner_columns:], "end_header", ""]
    return "\n".join(header).encode() + vertex_table.tobytes() + face_table.tobytes()


def _table(columns: dict[str, np.ndarray], row_count: int) -> tuple[np.ndarray, list[str]]:
    columns = {name: np.asarray(column) for name, column in columns.items()}
    for name, column in columns.items():
        if column.dtype.str[1:] not in _PLY_TYPES:
            raise ValueError(f"property '{name}' has the type {column.dtype}, which PLY has not")
        if column.shape != (row_count,):
            raise ValueError(
                f"property '{name}' must have {row_count} entries, but its shape is {column.shape}"
            )
    types = [(name, "<" + column.dtype.str[1:]) for name, column in columns.items()]
    table = np.empty(row_count, dtype=types)
    for name, column in columns.items():
        table[name] = column
    return table, [f"property {_PLY_TYPES[code[1:]]} {name}" for name, code in types]


def colour_properties(colours: np.ndarray | None) -> dict[str, np.ndarray]:
    """(N, 4) uint8 colours, or (N, 3) without alpha, as the properties that viewers know; none for
    None."""
    if colours is None:
        return {}
    opaque = np.full(len(colours), 255, dtype=np.uint8)
    return {
        "red": colours[:, 0],
        "green": colours[:, 1],
        "blue": colours[:, 2],
        "alpha": colours[:, 3] if colours.shape[1] > 3 else opaque,
    }
