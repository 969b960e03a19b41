# SPDX-License-Identifier: GPL-3.0-or-later
"""The plugin does not load into a host that it was not built for, and the host says so."""

import subprocess
import sys

import pytest

import spheroseg
from spheroseg import install

LOAD = "import sys, pymeshlab; pymeshlab.load_plugin(sys.argv[1])"


def load_in_new_process(path):
    return subprocess.run([sys.executable, "-c", LOAD, path], capture_output=True, text=True)


def test_the_plugin_itself_loads():
    run = load_in_new_process(spheroseg.plugin_path())
    assert run.returncode == 0, run.stderr


def test_a_plugin_for_another_release_is_refused(tmp_path):
    built = spheroseg.plugin_path().read_bytes()
    release = install.plugin_host(spheroseg.plugin_path()).release.encode() + b"d"
    assert release in built
    other = tmp_path / "libfilter_other_release.so"
    other.write_bytes(built.replace(release, b"2021.10d"))
    run = load_in_new_process(other)
    assert run.returncode != 0
    assert "different version" in run.stderr


@pytest.mark.parametrize("content", [b"", b"not a library"])
def test_a_file_that_is_no_plugin_is_refused(tmp_path, content):
    path = tmp_path / "libfilter_nothing.so"
    path.write_bytes(content)
    run = load_in_new_process(path)
    assert run.returncode != 0
    assert "PyMeshLabException" in run.stderr
