# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces of every kind made in code: borders, handles, one-sided ones, pieces, pinches, soups.

`SURFACES` has a maker for each, with what it must be; test_surfaces.py counts it after.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from mesh_paths import PYMESHLAB_FOLDER, load_arrays

Arrays = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class Surface:
    """A maker and its topology. `euler` is V - E + F over the vertices that faces name,
    `pinches` the number of fans beyond the first at each vertex."""

    make: Callable[[], Arrays]
    euler: int
    border_loops: int = 0
    components: int = 1
    pinches: int = 0
    orientable: bool = True
    #: Faces look the same way wherever the surface is orientable.
    oriented: bool = True


def grid_faces(columns: int, rows: int, wrap_x: str = "", wrap_y: bool = False) -> np.ndarray:
    """Two triangles per square of a grid. wrap_x: "" (open), "plain" or "flipped", where the last
    column meets the first one upside down. The vertex at (x, y) is y * width + x."""
    width = columns + (not wrap_x)
    height = rows + (not wrap_y)

    def vertex(x, y):
        y = np.where((x == columns) & (wrap_x == "flipped"), rows - y, y)
        return (y % height) * width + x % width

    y, x = (index.ravel() for index in np.mgrid[:rows, :columns])
    a, b, c, d = vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)
    # Rows of one square, so that faces lie in the order of their squares.
    return np.column_stack((a, b, c, a, c, d)).reshape(-1, 3).astype(np.int32)


def plane(columns: int = 48, rows: int = 32) -> Arrays:
    x, y = _parameters(columns, rows, "", False)
    return (
        np.column_stack((1.5 * x, y, 0.1 * np.sin(6 * x) * np.cos(5 * y))),
        grid_faces(columns, rows),
    )


def plane_with_holes() -> Arrays:
    """A plane of 48 x 32 squares less five rectangles of squares."""
    vertices, faces = plane()
    squares = np.ones((32, 48), dtype=bool)
    for x, y, width, height in ((5, 5, 4, 4), (15, 10, 10, 3), (30, 4, 3, 12), (8, 20, 6, 8)):
        squares[y : y + height, x : x + width] = False
    squares[25, 40] = False
    return vertices, faces[np.repeat(squares.ravel(), 2)]


def cylinder(columns: int = 60, rows: int = 24) -> Arrays:
    angle, height = _parameters(columns, rows, "plain", False)
    vertices = np.column_stack((np.cos(angle), 2 * height, -np.sin(angle)))
    return vertices, grid_faces(columns, rows, "plain")


def moebius_band(columns: int = 120, rows: int = 12) -> Arrays:
    angle, across = _parameters(columns, rows, "flipped", False)
    across = across - 0.5
    radius = 1.2 + across * np.cos(angle / 2)
    vertices = np.column_stack(
        (radius * np.cos(angle), radius * np.sin(angle), across * np.sin(angle / 2))
    )
    return vertices, grid_faces(columns, rows, "flipped")


def klein_bottle(columns: int = 64, rows: int = 24) -> Arrays:
    """A figure of eight that turns over once while it goes round."""
    u, v = _parameters(columns, rows, "flipped", True)
    radius = 2.5 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    vertices = np.column_stack((radius * np.cos(u), radius * np.sin(u), height))
    return vertices, grid_faces(columns, rows, "flipped", True)


def torus(columns: int = 64, rows: int = 24) -> Arrays:
    u, v = _parameters(columns, rows, "plain", True)
    radius = 2 + 0.8 * np.cos(v)
    vertices = np.column_stack((radius * np.cos(u), radius * np.sin(u), 0.8 * np.sin(v)))
    return vertices, grid_faces(columns, rows, "plain", True)


def double_torus() -> Arrays:
    """A torus and its mirror image, joined by a tube between two squares."""
    columns, rows = 48, 20
    vertices, faces = torus(columns, rows)
    # The square at u = v = 0 looks along x.
    square = np.array([0, 1, columns + 1, columns])
    faces = faces[2:]
    other = vertices * [-1, 1, 1] + [6.2, 0, 0]
    first, second = square, square + len(vertices)
    ahead, ahead_there = np.roll(first, -1), np.roll(second, -1)
    tube = np.concatenate(
        (
            np.column_stack((first, ahead, ahead_there)),
            np.column_stack((first, ahead_there, second)),
        )
    )
    joined = np.concatenate((faces, faces[:, ::-1] + len(vertices), tube))
    return np.concatenate((vertices, other)), joined.astype(np.int32)


def surface_of_cubes(solid: np.ndarray) -> Arrays:
    """Of unit cubes, where `solid` (X x Y x Z, bool) is true. Two triangles per square."""
    padded = np.pad(solid, 1)
    squares = []
    for axis in range(3):
        for side in (0, 1):
            beyond = np.roll(padded, 1 - 2 * side, axis)
            corner = np.argwhere(padded & ~beyond) - 1
            corner[:, axis] += side
            u, v = np.roll(np.eye(3, dtype=int), -axis - 1, axis=0)[:2]
            around = (0 * u, u, u + v, v) if side else (0 * u, v, u + v, u)
            squares.append(np.stack([corner + step for step in around], axis=1))
    vertices, index = np.unique(np.concatenate(squares).reshape(-1, 3), axis=0, return_inverse=True)
    a, b, c, d = index.reshape(-1, 4).T
    faces = np.column_stack((a, b, c, a, c, d)).reshape(-1, 3).astype(np.int32)
    return vertices.astype(float), faces


def lattice(nodes: int = 4) -> Arrays:
    """A cubic grid of struts, of genus 3 nodes^2 (nodes - 1) - nodes^3 + 1: mostly handles."""
    odd = np.indices(3 * (2 * nodes - 1,)) % 2
    return surface_of_cubes(odd.sum(axis=0) <= 1)


def comb(teeth: int = 20, height: int = 14) -> Arrays:
    """A bar with teeth that are two cubes wide and two apart."""
    x, y, _ = np.indices((4 * teeth - 2, height + 2, 2))
    return surface_of_cubes((y < 2) | (x % 4 < 2))


def globe(columns: int, rows: int) -> Arrays:
    """A sphere by longitude and latitude: 2 * columns * (rows - 1) triangles, poles of valence
    `columns`."""
    longitude = np.arange(columns) * 2 * np.pi / columns
    latitude = np.pi * np.arange(1, rows) / rows
    ring = np.column_stack((np.cos(longitude), np.sin(longitude)))
    body = np.concatenate(
        [np.column_stack((np.sin(t) * ring, np.full(columns, -np.cos(t)))) for t in latitude]
    )
    vertices = np.concatenate((body, [[0, 0, -1], [0, 0, 1]]))
    along = np.arange(columns)
    ahead = (along + 1) % columns
    south = np.column_stack((ahead, along, np.full(columns, len(body))))
    top = len(body) - columns
    north = np.column_stack((along + top, ahead + top, np.full(columns, len(body) + 1)))
    middle = grid_faces(columns, rows - 2, "plain") if rows > 2 else np.empty((0, 3), int)
    return vertices, np.concatenate((south, middle, north)).astype(np.int32)


def joined(pieces: list[Arrays]) -> Arrays:
    """Several meshes as one, nothing merged."""
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in pieces])
    faces = [faces + start for (_, faces), start in zip(pieces, starts, strict=False)]
    return (
        np.concatenate([vertices for vertices, _ in pieces]),
        np.concatenate(faces).astype(np.int32),
    )


def spheres(count: int = 50) -> Arrays:
    """Globes of different sizes on a lattice: 12 triangles the smallest, 440 the largest of 50."""
    pieces = []
    for i in range(count):
        vertices, faces = globe(6 + i // 3, 2 + i // 5)
        place = [i % 10, i // 10, 0]
        pieces.append((vertices * (0.2 + 0.005 * i) + place, faces))
    return joined(pieces)


def soup(count: int = 300) -> Arrays:
    """Triangles that share nothing, though many lie edge to edge."""
    vertices, faces = globe(20, 10)
    corners = faces[:count].ravel()
    return vertices[corners], np.arange(len(corners), dtype=np.int32).reshape(-1, 3)


def pinched_spheres(count: int = 5) -> Arrays:
    """Spheres of different sizes in a row; each has its north pole in common with the next one's
    south pole."""
    sizes = [(24 + 4 * i, 12 + i) for i in range(count)]
    vertices, faces = joined(
        [(v + [0, 0, 2 * i], f) for i, (v, f) in enumerate(globe(*size) for size in sizes)]
    )
    ends = np.cumsum([columns * (rows - 1) + 2 for columns, rows in sizes])
    for end, following in zip(ends[:-1], ends[1:], strict=True):
        faces[faces == following - 2] = end - 1
    return vertices, faces


def pinched_ring() -> Arrays:
    """A long ball whose poles meet: one piece with one pinch."""
    vertices, faces = globe(30, 40)
    angle = np.pi * vertices[:, 2]
    bent = np.column_stack(
        (
            (2 + 0.6 * vertices[:, 0]) * np.cos(angle),
            (2 + 0.6 * vertices[:, 0]) * np.sin(angle),
            0.6 * vertices[:, 1],
        )
    )
    north = len(vertices) - 1
    faces[faces == north] = north - 1
    return bent, faces


def touching_discs(count: int = 6) -> Arrays:
    """Planes that all meet in one vertex, and in nothing else."""
    pieces = []
    for i in range(count):
        vertices, faces = plane(16, 12 + i)
        angle = 2 * np.pi * i / count
        x, y, z = vertices.T
        pieces.append((np.column_stack((x * np.cos(angle), x * np.sin(angle), y + 2 * z)), faces))
    vertices, faces = joined(pieces)
    starts = np.cumsum([0] + [len(v) for v, _ in pieces[:-1]])
    faces[np.isin(faces, starts)] = 0
    return vertices, faces


def open_fan(valence: int = 500) -> Arrays:
    """Triangles around one vertex, not closed up."""
    angle = np.linspace(0, 1.9 * np.pi, valence + 1)
    vertices = np.column_stack((np.cos(angle), np.sin(angle), 0 * angle))
    rim = np.arange(valence)
    faces = np.column_stack((np.full(valence, valence + 1), rim, rim + 1))
    return np.concatenate((vertices, [[0, 0, 0.5]])), faces.astype(np.int32)


def slivers() -> Arrays:
    """A bar drawn out so far that its triangles are 10,000 times as long as they are wide."""
    vertices, faces = globe(40, 30)
    return vertices * [1, 1, 15_000], faces


def needle() -> Arrays:
    """A tube of three squares around: its sub-meshes are rings, cut where three edges end."""
    angle, height = _parameters(3, 400, "plain", False)
    return np.column_stack((np.cos(angle), np.sin(angle), 300 * height)), grid_faces(
        3, 400, "plain"
    )


def with_stars_cut_out(arrays: Arrays, count: int, seed: int) -> Arrays:
    """Less all faces around some vertices. The mesh must be closed and manifold."""
    _, faces = arrays
    return _with_holes(arrays, count, seed, np.unique(faces), lambda v: (faces == v).any(axis=1))


def with_faces_cut_out(arrays: Arrays, count: int, seed: int) -> Arrays:
    """Less some single faces. The mesh must be closed and manifold."""
    indices = np.arange(len(arrays[1]))
    return _with_holes(arrays, count, seed, indices, lambda face: indices == face)


def _with_holes(
    arrays: Arrays,
    count: int,
    seed: int,
    places: np.ndarray,
    faces_at: Callable[[int], np.ndarray],
) -> Arrays:
    """Holes at places chosen at random, no two of which have a vertex in common."""
    vertices, faces = arrays
    keep = np.ones(len(faces), dtype=bool)
    near = np.zeros(len(vertices), dtype=bool)
    holes = 0
    for place in np.random.default_rng(seed).permutation(places):
        hole = faces_at(place)
        if near[faces[hole]].any():
            continue
        near[faces[hole]] = True
        keep &= ~hole
        holes += 1
        if holes == count:
            return vertices, faces[keep]
    raise ValueError(f"only {holes} of {count} holes have room")


def turned_at_random(arrays: Arrays, seed: int = 1) -> Arrays:
    """The same surface; every other face looks the other way."""
    vertices, faces = arrays
    turned = np.random.default_rng(seed).random(len(faces)) < 0.5
    return vertices, np.where(turned[:, None], faces[:, ::-1], faces)


def with_loose_vertices(arrays: Arrays) -> Arrays:
    """Also vertices that no face names: before, between and after the others."""
    vertices, faces = arrays
    loose = np.full((1, 3), 7.0)
    middle = len(vertices) // 2
    moved = faces + 1 + (faces >= middle)
    parts = (loose, vertices[:middle], loose, vertices[middle:], loose)
    return np.concatenate(parts), moved.astype(np.int32)


def flattened(arrays: Arrays) -> Arrays:
    """Half of the vertices at one place: many faces have no area, none names a vertex twice."""
    vertices, faces = arrays
    return np.where(np.arange(len(vertices))[:, None] % 2, vertices, vertices[0]), faces


@cache
def sample(name: str) -> Arrays:
    """A mesh that PyMeshLab brings along."""
    return load_arrays(PYMESHLAB_FOLDER / name)


def bone_with_holes() -> Arrays:
    return with_stars_cut_out(sample("bone.ply"), 12, 2)


def _parameters(columns: int, rows: int, wrap_x: str, wrap_y: bool) -> Arrays:
    """Both parameters of each vertex of a grid: angles where it is wrapped, else in [0, 1]."""
    u = np.arange(columns) * 2 * np.pi / columns if wrap_x else np.linspace(0, 1, columns + 1)
    v = np.arange(rows) * 2 * np.pi / rows if wrap_y else np.linspace(0, 1, rows + 1)
    return np.tile(u, len(v)), np.repeat(v, len(u))


SURFACES: dict[str, Surface] = {
    "plane": Surface(plane, euler=1, border_loops=1),
    "plane with holes": Surface(plane_with_holes, euler=-4, border_loops=6),
    "cylinder": Surface(cylinder, euler=0, border_loops=2),
    "moebius band": Surface(
        moebius_band, euler=0, border_loops=1, orientable=False, oriented=False
    ),
    "klein bottle": Surface(klein_bottle, euler=0, orientable=False, oriented=False),
    "torus": Surface(torus, euler=0),
    "double torus": Surface(double_torus, euler=-2),
    "torus turned at random": Surface(lambda: turned_at_random(torus()), euler=0, oriented=False),
    "50 spheres": Surface(spheres, euler=100, components=50),
    "soup": Surface(soup, euler=300, border_loops=300, components=300),
    "pinched spheres": Surface(pinched_spheres, euler=6, components=5, pinches=4),
    "pinched ring": Surface(pinched_ring, euler=1, pinches=1),
    "touching discs": Surface(touching_discs, euler=1, border_loops=6, components=6, pinches=5),
    "open fan of 500": Surface(open_fan, euler=1, border_loops=1),
    "globe with poles of 500": Surface(lambda: globe(500, 4), euler=2),
    "comb": Surface(comb, euler=2),
    "lattice": Surface(lattice, euler=-160),
    "slivers": Surface(slivers, euler=2),
    "needle": Surface(needle, euler=0, border_loops=2),
    "loose vertices": Surface(lambda: with_loose_vertices(torus(40, 16)), euler=0),
    "faces without area": Surface(lambda: flattened(plane(30, 20)), euler=1, border_loops=1),
    "cow with holes": Surface(
        lambda: with_stars_cut_out(sample("cow.obj"), 25, 1), euler=-23, border_loops=25
    ),
    "bone with holes": Surface(bone_with_holes, euler=-10, border_loops=12),
    "airplane with holes": Surface(
        lambda: with_stars_cut_out(sample("airplane.obj"), 40, 3), euler=-38, border_loops=40
    ),
    "cow with pinholes": Surface(
        lambda: with_faces_cut_out(sample("cow.obj"), 150, 4), euler=-148, border_loops=150
    ),
}
