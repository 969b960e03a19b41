# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and paths that the Python tests share."""

from pathlib import Path

import numpy as np
import pymeshlab
import pytest

REPOSITORY = Path(__file__).resolve().parents[2]
SAMPLE_FOLDER = REPOSITORY / "sample_meshes"
PYMESHLAB_FOLDER = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
SAMPLES = sorted(path for path in SAMPLE_FOLDER.iterdir() if path.suffix in (".ply", ".obj"))
PYMESHLAB_MESHES = [
    PYMESHLAB_FOLDER / name for name in ("cow.obj", "airplane.obj", "bone.ply", "bunny.obj")
]


def load_arrays(path):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(path))
    mesh = mesh_set.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix()


@pytest.fixture(scope="session")
def sample_arrays():
    """Vertices and faces of every sample mesh, by file name."""
    return {path.name: load_arrays(path) for path in SAMPLES}


@pytest.fixture
def cube():
    corners = [[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
    return np.array(corners), np.array(faces)
