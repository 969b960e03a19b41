# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of labelled meshes without a graphics card or a display: a z-buffer in numpy."""

import struct
import zlib
from pathlib import Path

import numpy as np

BACKGROUND = 255.0
# Rows and columns per pixel; the average over them smooths the edges.
SUPERSAMPLING = 2


def render_labels(
    vertices: np.ndarray,
    faces: np.ndarray,
    labels: np.ndarray,
    face_colors: np.ndarray,
    *,
    size: tuple[int, int] = (900, 600),
    view: tuple[float, float, float] = (0.6, 0.35, 1.0),
    up: tuple[float, float, float] = (0.0, 1.0, 0.0),
) -> np.ndarray:
    """Picture of a mesh with dark lines between its sub-meshes, seen from far along -view. Faces
    are seen from both sides.

    vertices: (V, 3) float; faces: (F, 3) int; labels: (F,) int; face_colors: (F, 3) in [0, 1].
    Returns (height, width, 3) uint8 for size = (width, height). O(F + pixels of the boxes around
    the faces).
    """
    width, height = (SUPERSAMPLING * pixels for pixels in size)
    points = _project(np.asarray(vertices, float), np.asarray(view, float), up, width, height)
    corners = points[faces]
    face_buffer = _visible_faces(corners, width, height)

    shade = _shading(corners)
    colors = np.vstack([255.0 * face_colors * shade[:, None], [[BACKGROUND] * 3]])
    image = colors[face_buffer]
    label_buffer = np.append(labels, -1)[face_buffer]
    image[_borders(label_buffer)] *= 0.25
    blocks = image.reshape(size[1], SUPERSAMPLING, size[0], SUPERSAMPLING, 3)
    return np.rint(blocks.mean(axis=(1, 3))).clip(0, 255).astype(np.uint8)


def write_png(path: Path | str, image: np.ndarray) -> None:
    """Writes an (height, width, 3) uint8 array."""
    height, width, _ = image.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        checksum = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + checksum

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    data = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows.tobytes(), 9))
    Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + data + chunk(b"IEND", b""))


def _project(vertices, view, up, width, height):
    """Pixel coordinates and depth (larger is nearer), the mesh centred with a margin."""
    forward = view / np.linalg.norm(view)
    right = np.cross(up, forward)
    right /= np.linalg.norm(right)
    axes = np.stack([right, -np.cross(forward, right), forward], axis=1)
    points = vertices @ axes
    low, high = points.min(axis=0), points.max(axis=0)
    extent = np.maximum(high - low, 1e-12)
    scale = 0.94 * min(width / extent[0], height / extent[1])
    points = (points - (low + high) / 2) * scale
    return points + [width / 2, height / 2, 0.0]


def _shading(corners):
    """Brightness of each face: a lamp near the eye."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    lamp = np.array([-0.3, -0.5, 0.81])
    # The side that is seen counts, so turn normals to the eye.
    normals *= np.where(normals[:, 2:] < 0.0, -1.0, 1.0)
    return 0.62 + 0.38 * np.clip(normals @ (lamp / np.linalg.norm(lamp)), 0.0, 1.0)


def _visible_faces(corners, width, height):
    """Index of the nearest face at each pixel, or -1."""
    depth = np.full((height, width), -np.inf)
    nearest = np.full((height, width), -1)
    low = np.ceil(corners[:, :, :2].min(axis=1) - 0.5).astype(int).clip(0)
    high = np.floor(corners[:, :, :2].max(axis=1) - 0.5).astype(int)
    a, b, c = (corners[:, i] for i in range(3))
    area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    for f in np.flatnonzero(area):
        x0, y0 = low[f]
        x1, y1 = min(high[f, 0], width - 1) + 1, min(high[f, 1], height - 1) + 1
        if x0 >= x1 or y0 >= y1:
            continue
        x = np.arange(x0, x1)[None, :] + 0.5
        y = np.arange(y0, y1)[:, None] + 0.5
        u = ((x - a[f, 0]) * (c[f, 1] - a[f, 1]) - (y - a[f, 1]) * (c[f, 0] - a[f, 0])) / area[f]
        v = ((b[f, 0] - a[f, 0]) * (y - a[f, 1]) - (b[f, 1] - a[f, 1]) * (x - a[f, 0])) / area[f]
        z = a[f, 2] + u * (b[f, 2] - a[f, 2]) + v * (c[f, 2] - a[f, 2])
        window = (slice(y0, y1), slice(x0, x1))
        hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (z > depth[window])
        depth[window][hit] = z[hit]
        nearest[window][hit] = f
    return nearest


def _borders(labels):
    """True where a pixel and the next one to the right or below show different labels."""
    border = np.zeros(labels.shape, bool)
    border[:, :-1] |= labels[:, :-1] != labels[:, 1:]
    border[:-1, :] |= labels[:-1, :] != labels[1:, :]
    border &= labels >= 0
    return border
