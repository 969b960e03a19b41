# SPDX-License-Identifier: GPL-3.0-or-later
"""Generates the sample meshes, byte for byte: python sample_meshes/generate.py [FOLDER].

Each mesh is one closed, outward-oriented, two-manifold surface of genus 0. Coordinates are rounded
to six decimals before they are stored as float32, so that the last bits of a platform's sines do
not matter. Needs numpy only.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np

Mesh = tuple[np.ndarray, np.ndarray]

DECIMALS = 6


def cube() -> Mesh:
    """A low-poly solid: 12 triangles, fewer than most numbers of sub-meshes."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], dtype=float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, _split_quads(np.array(quads))


def displaced_sphere() -> Mesh:
    """A ball with smooth bumps: 5,120 triangles of about one size."""
    vertices, faces = _icosphere(4)
    x, y, z = vertices.T
    bumps = np.sin(5 * x + 1) * np.sin(4 * y + 2) * np.sin(6 * z + 3) + 0.4 * np.sin(9 * x * y + z)
    return vertices * (1 + 0.18 * bumps)[:, None], faces


def flat_leaf() -> Mesh:
    """An ellipsoid 200 times longer than thick: 1,280 triangles, two sides nearly touching."""
    vertices, faces = _icosphere(3)
    return vertices * np.array([5.0, 1.5, 0.025]), faces


def limbed_figure() -> Mesh:
    """A figure with head, arms, fingers and legs, made of blocks and smoothed: long limbs are what
    a map onto the sphere has to squeeze."""
    blocks = [  # (low corner, high corner) in lattice units: x right, y up, z forward
        ((-4, 0, -2), (4, 12, 2)),  # torso
        ((-1, 12, -1), (1, 14, 1)),  # neck
        ((-3, 14, -3), (3, 20, 3)),  # head
        ((4, 9, -1), (14, 12, 1)),  # arms, then two fingers each
        ((-14, 9, -1), (-4, 12, 1)),
        ((14, 9, -1), (18, 10, 1)),
        ((14, 11, -1), (18, 12, 1)),
        ((-18, 9, -1), (-14, 10, 1)),
        ((-18, 11, -1), (-14, 12, 1)),
        ((-4, -14, -2), (-1, 0, 1)),  # legs, then feet
        ((1, -14, -2), (4, 0, 1)),
        ((-4, -14, 1), (-1, -12, 3)),
        ((1, -14, 1), (4, -12, 3)),
    ]
    offset = np.array([20, 16, 6])
    filled = np.zeros((40, 40, 12), dtype=bool)
    for low, high in blocks:
        (x0, y0, z0), (x1, y1, z1) = np.add(low, offset), np.add(high, offset)
        filled[x0:x1, y0:y1, z0:z1] = True
    vertices, faces = _midpoint_subdivision(*_block_surface(filled))
    return _smooth((vertices - offset) / 10, faces, rounds=6), faces


def sliver_rod() -> Mesh:
    """A rod of 240 sides in 3 long segments with zigzag caps: nearly all triangles are slivers."""
    sides = 240
    angles = 2 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    heights = np.array([0.0, 4.0, 7.0, 12.0])
    vertices = np.concatenate([_ring(circle, height) for height in heights])
    faces = [_band(level * sides, (level + 1) * sides, sides) for level in range(len(heights) - 1)]
    cap = _zigzag(sides)
    faces += [cap[:, ::-1], cap + (len(heights) - 1) * sides]
    return vertices, np.concatenate(faces)


def spindle() -> Mesh:
    """Two vertices of valence 500 joined by a band: 2,000 triangles."""
    sides = 500
    angles = 2 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    rings = [_ring(circle, -0.3), _ring(circle, 0.3)]
    vertices = np.concatenate([*rings, [[0.0, 0.0, -1.5], [0.0, 0.0, 1.5]]])
    faces = [_band(0, sides, sides), _fan(2 * sides, 0, sides)[:, ::-1]]
    faces.append(_fan(2 * sides + 1, sides, sides))
    return vertices, np.concatenate(faces)


def spiral_tube() -> Mesh:
    """A tube of 12 sides along a widening helix, tapered to both ends: 6,000 triangles."""
    sides, stations = 12, 250
    turn = np.linspace(0.0, 8 * np.pi, stations)
    radius = 0.6 + 0.08 * turn
    axis = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.25 * turn], axis=1)
    tangent = np.gradient(axis, axis=0)
    tangent /= np.sqrt((tangent**2).sum(axis=1))[:, None]
    side = np.cross(tangent, [0.0, 0.0, 1.0])
    side /= np.sqrt((side**2).sum(axis=1))[:, None]
    up = np.cross(side, tangent)
    thickness = 0.05 + 0.2 * np.sin(np.pi * np.arange(stations) / (stations - 1))
    angles = 2 * np.pi * np.arange(sides) / sides
    offsets = (
        np.cos(angles)[None, :, None] * side[:, None]
        + np.sin(angles)[None, :, None] * (up[:, None])
    )
    rings = axis[:, None] + thickness[:, None, None] * offsets
    ends = [axis[0] - 0.05 * tangent[0], axis[-1] + 0.05 * tangent[-1]]
    vertices = np.concatenate([rings.reshape(-1, 3), ends])
    last = (stations - 1) * sides
    faces = [_band(level * sides, (level + 1) * sides, sides) for level in range(stations - 1)]
    faces.append(_fan(last + sides, 0, sides)[:, ::-1])
    faces.append(_fan(last + sides + 1, last, sides))
    # The frame (side, up, tangent) is left-handed: turn every triangle to look outward.
    return vertices, np.concatenate(faces)[:, ::-1]


SAMPLES: dict[str, Callable[[], Mesh]] = {
    "cube.obj": cube,
    "displaced_sphere.ply": displaced_sphere,
    "flat_leaf.ply": flat_leaf,
    "limbed_figure.ply": limbed_figure,
    "sliver_rod.ply": sliver_rod,
    "spindle.ply": spindle,
    "spiral_tube.ply": spiral_tube,
}


def _icosphere(levels: int) -> Mesh:
    """Unit icosphere with 20 * 4^levels triangles."""
    golden = (1 + np.sqrt(5.0)) / 2
    vertices = np.array(
        [[sign_a, sign_b * golden, 0] for sign_a in (-1, 1) for sign_b in (-1, 1)], dtype=float
    )
    vertices = np.concatenate([np.roll(vertices, shift, axis=1) for shift in range(3)])
    vertices /= np.sqrt(1 + golden**2)
    edge = 2 / np.sqrt(1 + golden**2)
    distance = np.sqrt(((vertices[:, None] - vertices[None]) ** 2).sum(axis=2))
    near = np.abs(distance - edge) < 1e-6
    faces = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[a, c]:
                    outward = np.linalg.det(vertices[[a, b, c]]) > 0
                    faces.append((a, b, c) if outward else (a, c, b))
    triangles = np.array(faces)
    for _ in range(levels):
        vertices, triangles = _midpoint_subdivision(vertices, triangles)
        vertices /= np.sqrt((vertices**2).sum(axis=1))[:, None]
    return vertices, triangles


def _midpoint_subdivision(vertices: np.ndarray, faces: np.ndarray) -> Mesh:
    """Cuts each triangle into four; each edge gets one vertex in its middle."""
    corners = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, edge_of_corner = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True)
    middles = (vertices[edges[:, 0]] + vertices[edges[:, 1]]) / 2
    ab, bc, ca = (edge_of_corner.reshape(-1, 3) + len(vertices)).T
    a, b, c = faces.T
    children = np.stack([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
    return np.concatenate([vertices, middles]), children.transpose(2, 0, 1).reshape(-1, 3)


def _block_surface(filled: np.ndarray) -> Mesh:
    """Boundary of the filled lattice cells, two triangles per cell side, looking outward."""
    quads = []
    cells = np.argwhere(filled)
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        for direction in (0, 1):
            step = np.eye(3, dtype=int)[axis] * (2 * direction - 1)
            open_side = ~filled[tuple((cells + step).T)]
            base = cells[open_side] + np.eye(3, dtype=int)[axis] * direction
            quad = np.stack([base, base + u, base + u + v, base + v], axis=1)
            quads.append(quad if direction else quad[:, ::-1])
    corners = np.concatenate(quads).reshape(-1, 3)
    vertices, index = np.unique(corners, axis=0, return_inverse=True)
    return vertices.astype(float), _split_quads(index.reshape(-1, 4))


def _smooth(vertices: np.ndarray, faces: np.ndarray, rounds: int) -> np.ndarray:
    """Moves each vertex half-way to the mean of its neighbours and, every second round, back by a
    little more, so that thin limbs do not shrink away."""
    # Each edge of a closed oriented mesh occurs once in each direction.
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    degree = np.bincount(start)[:, None]
    for step in range(2 * rounds):
        sums = np.stack([np.bincount(start, vertices[end, axis]) for axis in range(3)], axis=1)
        vertices = vertices + (0.5, -0.52)[step % 2] * (sums / degree - vertices)
    return vertices


def _ring(circle: np.ndarray, height: float) -> np.ndarray:
    return np.column_stack([circle, np.full(len(circle), height)])


def _band(lower: int, upper: int, sides: int) -> np.ndarray:
    """Two triangles per side between two rings of vertices, given by their first index."""
    here = np.arange(sides)
    following = (here + 1) % sides
    return _split_quads(
        np.stack([lower + here, lower + following, upper + following, upper + here], axis=1)
    )


def _fan(apex: int, first: int, sides: int) -> np.ndarray:
    here = np.arange(sides)
    return np.stack([np.full(sides, apex), first + here, first + (here + 1) % sides], axis=1)


def _zigzag(sides: int) -> np.ndarray:
    """Triangulates a convex polygon by a strip from one end to the other."""
    low, high, faces = 0, sides - 1, []
    while high - low > 1:
        if len(faces) % 2 == 0:
            faces.append((low, low + 1, high))
            low += 1
        else:
            faces.append((low, high - 1, high))
            high -= 1
    return np.array(faces)


def _split_quads(quads: np.ndarray) -> np.ndarray:
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def encode(name: str, mesh: Mesh) -> bytes:
    """The bytes of the file `name`: .obj as text, .ply as little-endian binary."""
    vertices, faces = mesh
    # Adding 0 turns -0.0 into 0.0.
    rounded = np.round(vertices, DECIMALS) + 0.0
    if name.endswith(".obj"):
        lines = ["v {:g} {:g} {:g}\n".format(*vertex) for vertex in rounded]
        lines += ["f {} {} {}\n".format(*face) for face in faces + 1]
        return "".join(lines).encode()
    header = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    triangles = np.empty(len(faces), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    triangles["count"] = 3
    triangles["corners"] = faces
    return header.encode() + rounded.astype("<f4").tobytes() + triangles.tobytes()


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for name, build in SAMPLES.items():
        (folder / name).write_bytes(encode(name, build()))


if __name__ == "__main__":
    main()
