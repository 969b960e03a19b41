# SPDX-License-Identifier: GPL-3.0-or-later
"""One screen for all tests; for each test a fresh home with the plugin, and MeshLab in it."""

import os
import re
import shutil
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from meshlab_window import MeshLabWindow, prepare_home
from screen import Screen

from spheroseg import install

REPOSITORY = Path(__file__).resolve().parents[2]
HOST = install.Host("2025.07", "float")


@pytest.fixture(scope="session")
def meshlab_root() -> Path:
    named = os.environ.get("SPHEROSEG_GUI_ROOT")
    root = Path(named) if named else REPOSITORY / ".cache" / "meshlab-root"
    if not (root / ".complete").is_file():
        pytest.fail(f"no MeshLab in {root}: run scripts/gui_root.sh, or make test-gui")
    return root


@pytest.fixture(scope="session")
def desktop_plugin() -> Path:
    plugin = install.desktop_plugin_path()
    assert install.plugin_host(plugin) == HOST
    return plugin


@pytest.fixture(scope="session")
def screen():
    with Screen() as screen:
        yield screen


@pytest.fixture
def bare_home(tmp_path) -> Path:
    """A home without the plugin."""
    return prepare_home(tmp_path / "home")


@pytest.fixture
def home(bare_home, desktop_plugin, monkeypatch) -> Path:
    """A home in which `spheroseg install-plugin` has put the plugin."""
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setenv("HOME", str(bare_home))
    folder = install.user_plugin_folder(HOST)
    folder.mkdir(parents=True)
    install.install_plugin(folder, plugin=desktop_plugin)
    return bare_home


@pytest.fixture
def artefacts(request) -> Path:
    """Where this test's pictures and MeshLab's log stay after it."""
    folder = REPOSITORY / "out" / "gui" / re.sub(r"\W+", "_", request.node.name).strip("_")
    shutil.rmtree(folder, ignore_errors=True)
    return folder


@pytest.fixture
def meshlab(screen, meshlab_root, home, artefacts):
    with MeshLabWindow(screen, meshlab_root, home, artefacts) as window:
        yield window


@pytest.fixture(scope="session")
def cow() -> Path:
    """5,804 triangles, closed, of genus 0; it comes with PyMeshLab."""
    return Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"


def bumpy_sphere(path: Path, subdivisions: int) -> Path:
    """20 * 4^subdivisions triangles, dented so that nothing is symmetric."""
    meshes = pymeshlab.MeshSet()
    meshes.create_sphere(radius=1, subdiv=subdivisions)
    mesh = meshes.current_mesh()
    points = mesh.vertex_matrix()
    dent = 1 + 0.2 * np.sin(3 * points[:, :1] + 1) * np.cos(2 * points[:, 1:2])
    meshes.add_mesh(pymeshlab.Mesh(points * dent, mesh.face_matrix()))
    meshes.save_current_mesh(str(path))
    return path


@pytest.fixture
def small_mesh(tmp_path) -> Path:
    return bumpy_sphere(tmp_path / "small.ply", 3)


@pytest.fixture
def large_mesh(tmp_path) -> Path:
    return bumpy_sphere(tmp_path / "large.ply", 7)


@pytest.fixture
def finned_mesh(tmp_path, small_mesh) -> Path:
    """The small mesh with a third triangle on one edge."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(small_mesh))
    mesh = meshes.current_mesh()
    vertices, faces = mesh.vertex_matrix(), mesh.face_matrix()
    fin = [*faces[0][:2], len(vertices)]
    tip = 2 * vertices[faces[0][0]]
    meshes.add_mesh(pymeshlab.Mesh(np.vstack([vertices, tip]), np.vstack([faces, fin])))
    path = tmp_path / "fin.ply"
    meshes.save_current_mesh(str(path))
    return path
