# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that the Python tests share."""

import numpy as np
import pytest
from mesh_paths import SAMPLES, load_arrays


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
