# SPDX-License-Identifier: GPL-3.0-or-later
"""The meshes of the benchmark: PyMeshLab's samples, ours, a folder of others, subdivided ones."""

import fnmatch
import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spheroseg import mesh_files
from spheroseg.batch.inputs import MESH_SUFFIXES
from spheroseg.digests import sha256
from spheroseg.errors import InputError
from spheroseg.file_checks import checked_counts

PYMESHLAB_SAMPLES = ("cow.obj", "airplane.obj", "bone.ply", "bunny.obj")
# Sample, and how often each triangle is split in four; the first is the series of the exponent.
SUBDIVIDED = {"displaced_sphere": (1, 2, 3, 4), "limbed_figure": (1, 2), "cow": (2,)}
# Of ours, those that `generate.py` splits so.
SPLIT_SAMPLES = ("displaced_sphere", "flat_leaf", "limbed_figure")
SERIES = ("displaced_sphere", *(f"displaced_sphere_x{4**level}" for level in (1, 2, 3, 4)))


@dataclass(frozen=True)
class BenchMesh:
    """A mesh file, and how often each of its triangles is split in four."""

    name: str
    path: str
    levels: int = 0

    @functools.cached_property
    def triangle_count(self) -> int:
        """By the faces in the file; 0 for one that can not be used."""
        try:
            return (checked_counts(Path(self.path)).triangles or 0) * 4**self.levels
        except InputError:
            return 0

    @functools.cached_property
    def digest(self) -> str:
        """Of the file."""
        return sha256(Path(self.path))[:12]


def available(sample_folder: Path, more_folder: Path) -> tuple[list[BenchMesh], list[str]]:
    """All meshes that are there, and a line for each folder that is not."""
    sources = {}
    reasons = []
    for path in map(mesh_files.sample_mesh, PYMESHLAB_SAMPLES):
        if path.is_file():
            sources[path.stem] = path
        else:
            reasons.append(f"{path.name}: not among PyMeshLab's samples of this installation")
    for folder in (sample_folder, more_folder):
        if not folder.is_dir():
            reasons.append(f"{folder}: no such folder, its meshes are left out")
            continue
        for path in sorted(folder.iterdir()):
            if path.suffix.lower() in MESH_SUFFIXES:
                name = path.stem if path.stem not in sources else f"{path.stem}_{path.suffix[1:]}"
                sources[name] = path
    meshes = [BenchMesh(name, str(path)) for name, path in sources.items()]
    for name, levels in SUBDIVIDED.items():
        if name in sources:
            meshes += [BenchMesh(f"{name}_x{4**n}", str(sources[name]), n) for n in levels]
    return meshes, reasons


def chosen(meshes: list[BenchMesh], patterns: str | None) -> list[BenchMesh]:
    """Those whose names match one of the comma-separated patterns; all for None."""
    if patterns is None:
        return meshes
    wanted = patterns.split(",")
    return [mesh for mesh in meshes if any(fnmatch.fnmatchcase(mesh.name, w) for w in wanted)]


def is_subdivision(name: str) -> bool:
    """Does the mesh of that name come from another one by splitting each triangle in four?"""
    return name in SPLIT_SAMPLES or any(
        name == f"{sample}_x{4**level}" for sample, levels in SUBDIVIDED.items() for level in levels
    )


def read(mesh: BenchMesh) -> tuple[np.ndarray, np.ndarray]:
    """(V, 3) vertices and (F, 3) int32 faces."""
    mesh_set = mesh_files.read_mesh(mesh.path)
    vertices = mesh_set.current_mesh().vertex_matrix()
    faces = np.ascontiguousarray(mesh_set.current_mesh().face_matrix(), dtype=np.int32)
    for _ in range(mesh.levels):
        vertices, faces = subdivided(vertices, faces)
    return vertices, faces


def subdivided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each triangle split in four at the middles of its edges; orientation is kept.

    Returns (V + E, 3) vertices, the old ones first, and (4 F, 3) int32 faces.
    """
    ends = np.stack((faces, np.roll(faces, -1, axis=1)), axis=2).reshape(-1, 2)
    key = ends.min(axis=1).astype(np.int64) << 32 | ends.max(axis=1)
    edges, edge_of_side = np.unique(key, return_inverse=True)
    middles = (vertices[edges >> 32] + vertices[edges & 0xFFFFFFFF]) / 2
    ab, bc, ca = (len(vertices) + edge_of_side.reshape(-1, 3)).T
    a, b, c = faces.T
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    split = np.stack([np.column_stack(corner) for corner in corners], axis=1)
    return np.concatenate((vertices, middles)), split.reshape(-1, 3).astype(np.int32)
