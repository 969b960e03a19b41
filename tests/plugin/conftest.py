# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pymeshlab
import pytest

import spheroseg  # noqa: F401 (loads the plugin)


@pytest.fixture
def sample():
    """Opens one of the meshes that PyMeshLab brings along."""
    folder = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"

    def load(name):
        mesh_set = pymeshlab.MeshSet()
        mesh_set.load_new_mesh(str(folder / name))
        return mesh_set

    return load
