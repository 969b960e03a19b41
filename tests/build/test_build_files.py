# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages of the build and set-up files when something is missing."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def run(*command, **options):
    return subprocess.run(command, capture_output=True, text=True, **options)


def test_configuring_without_meshlab_headers_names_the_variable_to_set(tmp_path):
    configured = run(
        *("cmake", "-S", ROOT, "-B", tmp_path / "build"), f"-DMESHLAB_SOURCE_DIR={tmp_path}"
    )
    assert configured.returncode != 0
    text = " ".join(configured.stderr.split())
    assert f"No MeshLab headers in '{tmp_path}': set MESHLAB_SOURCE_DIR to" in text
    assert configured.stderr.count("CMake Error") == 1


def test_configuring_with_an_unknown_scalar_type_names_the_two_that_exist(tmp_path):
    configured = run("cmake", "-S", ROOT, "-B", tmp_path / "build", "-DSPHEROSEG_SCALAR=half")
    assert configured.returncode != 0
    assert "must be double or float, found 'half'" in " ".join(configured.stderr.split())


def check_engine_includes(folder):
    script = ROOT / "cmake" / "check_engine_includes.cmake"
    return run("cmake", "-D", f"ENGINE_DIR={folder}", "-P", script)


def test_the_engine_includes_neither_qt_nor_vcg():
    checked = check_engine_includes(ROOT / "filter_spheroseg" / "engine")
    assert checked.returncode == 0, checked.stderr


@pytest.mark.parametrize(
    "include",
    [
        "<QString>",
        "<QtCore/QString>",
        "<vcg/complex/complex.h>",
        '"wrap/callback.h"',
        "<common/ml_document/cmesh.h>",
    ],
)
def test_an_engine_file_that_includes_qt_or_vcg_is_found(tmp_path, include):
    (tmp_path / "clean.h").write_text("#include <vector>\n")
    assert check_engine_includes(tmp_path).returncode == 0
    (tmp_path / "step.cpp").write_text(f'#include "step.h"\n  #  include {include}\n')
    checked = check_engine_includes(tmp_path)
    assert checked.returncode != 0
    assert "step.cpp" in checked.stderr


def test_header_script_rejects_a_folder_without_headers(tmp_path):
    fetched = run(
        ROOT / "scripts" / "fetch_meshlab_headers.sh",
        env={**os.environ, "MESHLAB_SOURCE_DIR": str(tmp_path)},
    )
    assert fetched.returncode == 1
    assert str(tmp_path) in fetched.stderr


def test_set_up_on_a_system_without_apt_names_the_packages(tmp_path):
    for tool in ("bash", "env", "dirname", "cat", "id"):
        (tmp_path / tool).symlink_to(shutil.which(tool))
    script = ROOT / "scripts" / "setup.sh"
    done = run(tmp_path / "bash", script, "run", env={"PATH": str(tmp_path)})
    assert done.returncode == 1
    for package in ("CMake", "Qt 5.15", "GLEW", "Eigen", "qtbase5-dev"):
        assert package in done.stderr


def test_the_command_runs_where_the_path_has_a_blank(tmp_path):
    folder = tmp_path / "my checkout" / "bin"
    folder.mkdir(parents=True)
    (folder / "python").write_text('#!/bin/sh\necho "$@"\n')
    (folder / "python").chmod(0o755)
    command = shutil.copy(ROOT / "scripts" / "spheroseg.sh", folder / "spheroseg")
    Path(command).chmod(0o755)
    (tmp_path / "link").symlink_to(command)
    done = run(tmp_path / "link", "measure", "a mesh.ply")
    assert done.stdout == "-P -m spheroseg measure a mesh.ply\n"


@pytest.fixture
def checkout(tmp_path):
    """With nothing to install or download."""
    checkout = tmp_path / "ünï"
    for folder in ("scripts", "requirements"):
        shutil.copytree(ROOT / folder, checkout / folder)
    for file in (checkout / "requirements").iterdir():
        file.write_text("")
    for script in ("fetch_meshlab_headers.sh", "gui_root.sh"):
        (checkout / "scripts" / script).write_text("#!/bin/sh\n")
    (checkout / "python" / "found_package").mkdir(parents=True)
    (checkout / ".venv" / "bin").mkdir(parents=True)
    (checkout / ".venv" / "bin" / "python").symlink_to(sys.executable)
    return checkout


def set_up(checkout, level):
    environment = {**os.environ, "SPHEROSEG_SKIP_PACKAGES": "1", "PYTHON": sys.executable}
    return run(checkout / "scripts" / "setup.sh", level, env=environment)


def test_set_up_completes_an_environment_and_finds_the_package_from_any_path(checkout):
    done = set_up(checkout, "run")
    assert done.returncode == 0, done.stderr
    assert "installing Python packages" in done.stdout
    found = run(
        checkout / ".venv" / "bin" / "python",
        "-c",
        "import pip, found_package",
        env={**os.environ, "LC_ALL": "C"},
    )
    assert found.returncode == 0, found.stderr
    assert set_up(checkout, "run").stdout == ""


def test_set_up_fails_with_any_of_its_parts_and_is_done_again(checkout):
    requirements = checkout / "requirements" / "dev.txt"
    requirements.write_text("./absent.whl\n")
    application = checkout / "scripts" / "gui_root.sh"
    for _ in range(2):
        done = set_up(checkout, "gui")
        assert done.returncode == 1
        assert "absent.whl" in done.stderr
    requirements.write_text("")
    application.write_text("#!/bin/sh\nexit 3\n")
    assert set_up(checkout, "dev").returncode == 0
    assert set_up(checkout, "gui").returncode == 3


def test_set_up_rejects_an_unknown_level():
    done = run(ROOT / "scripts" / "setup.sh", "everything")
    assert done.returncode == 2
    assert "expected run, dev or gui" in done.stderr
