# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pymeshlab
import pytest

import spheroseg  # noqa: F401 (loads the plugin)
from spheroseg._plugin import forget_failed_call


@pytest.fixture(autouse=True)
def _failed_calls_are_forgotten():
    """Else the next file that a test loads may end the process, as tests call filters that fail."""
    yield
    forget_failed_call()


@pytest.fixture
def sample():
    """Opens one of the meshes that PyMeshLab brings along."""
    folder = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"

    def load(name):
        mesh_set = pymeshlab.MeshSet()
        mesh_set.load_new_mesh(str(folder / name))
        return mesh_set

    return load
