# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the meshes of the tests lie."""

from pathlib import Path

import pymeshlab

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
