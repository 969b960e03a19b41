# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that the Python tests share."""

import os
import signal
import subprocess

import hypothesis
import numpy as np
import pytest
from mesh_paths import SAMPLES, load_arrays

# The same examples on every run, few enough for CI; HYPOTHESIS_PROFILE=long tries many others.
SHARED = {
    "deadline": None,
    "print_blob": True,
    "suppress_health_check": [
        hypothesis.HealthCheck.function_scoped_fixture,
        hypothesis.HealthCheck.too_slow,
    ],
}
hypothesis.settings.register_profile(
    "ci", derandomize=True, database=None, max_examples=60, **SHARED
)
hypothesis.settings.register_profile("long", max_examples=3000, **SHARED)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "ci"))


@pytest.fixture(scope="session", autouse=True)
def _interrupt_is_not_ignored():
    """Shells start what runs in the background with SIGINT ignored, and processes inherit that."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def sample_arrays():
    """Vertices and faces of every sample mesh, by file name."""
    return {path.name: load_arrays(path) for path in SAMPLES}


@pytest.fixture(scope="session")
def evaluation(tmp_path_factory):
    """Folder with `in`, two meshes, and `out`, their evaluation (evaluations.py)."""
    for package in ("jinja2", "pyvista", "matplotlib", "pymetis", "numba"):
        pytest.importorskip(package)
    from evaluations import evaluate, write_inputs

    folder = tmp_path_factory.mktemp("evaluation")
    write_inputs(folder / "in")
    assert evaluate(folder / "in", folder / "out") == 0
    return folder


@pytest.fixture
def small_disk(tmp_path):
    """A folder with room for 256 KiB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=256k", "tmpfs", str(disk)]
    if os.geteuid() != 0 or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("mounting a small disk needs root")
    yield disk
    subprocess.run(["umount", str(disk)], check=True)


@pytest.fixture
def cube():
    corners = [[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
    return np.array(corners), np.array(faces)
