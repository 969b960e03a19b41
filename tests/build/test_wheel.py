# SPDX-License-Identifier: GPL-3.0-or-later
"""The package as pip builds it has the plugin inside, for PyMeshLab and for MeshLab."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import spheroseg
from spheroseg.install import Host, plugin_host

ROOT = Path(__file__).parents[2]
DESKTOP_PLUGIN = "spheroseg/desktop/libfilter_spheroseg.so"
# The compiler's name and the options of the other builds, which may have left objects in ccache.
AS_ELSEWHERE = {"CXX": "c++"}
WARNINGS = "--config-settings=cmake.define.SPHEROSEG_WERROR=ON"


def test_wheel_holds_the_package_the_plugin_and_the_command(tmp_path):
    built = subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-build-isolation", "-w", tmp_path]
        + [WARNINGS, str(ROOT)],
        capture_output=True,
        text=True,
        env={**AS_ELSEWHERE, **os.environ},
    )
    assert built.returncode == 0, built.stderr
    (wheel,) = tmp_path.glob(f"spheroseg-{spheroseg.__version__}-py3-none-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        commands = next(name for name in names if name.endswith("entry_points.txt"))
        assert "spheroseg=spheroseg.cli:main" in archive.read(commands).decode().replace(" ", "")
        archive.extract(DESKTOP_PLUGIN, tmp_path)
    assert plugin_host(tmp_path / DESKTOP_PLUGIN) == Host("2025.07", "float")
    assert {"spheroseg/__init__.py", "spheroseg/py.typed"} <= set(names)
    assert "spheroseg/libfilter_spheroseg.so" in names
    assert not [name for name in names if name.startswith(("tests", "filter_spheroseg"))]
