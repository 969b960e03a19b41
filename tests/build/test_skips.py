# SPDX-License-Identifier: GPL-3.0-or-later
"""A test that is skipped is seen where CI is set."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]
MODULE = """
import pytest
pytest.importorskip("no_such_package")
def test_nothing(): pass
"""
SKIPS = """
import pytest

@pytest.fixture
def disk(): pytest.skip("no such rights")

def test_setup(disk): pass

def test_call(): pytest.skip("no such machine")

@pytest.mark.skipif(True, reason="no such system")
def test_mark(): pass

def test_allowed(): pytest.skip("there is a usable GPU")

@pytest.mark.xfail
def test_expected(): assert False

def test_passes(): pass
"""


def run_tests(folder, **environment):
    kept = {name: value for name, value in os.environ.items() if name != "CI"}
    options = ["-p", "no:cacheprovider", "--continue-on-collection-errors", "-ra"]
    return subprocess.run(
        [sys.executable, "-m", "pytest", "--rootdir", folder, *options, folder],
        capture_output=True,
        text=True,
        env={**kept, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", **environment},
    )


def test_a_skip_fails_where_ci_is_set_unless_its_reason_is_known(tmp_path):
    shutil.copy(TESTS / "conftest.py", tmp_path)
    (tmp_path / "test_module.py").write_text(MODULE)
    (tmp_path / "test_skips.py").write_text(SKIPS)

    elsewhere = run_tests(tmp_path)
    assert elsewhere.returncode == 0
    assert " 1 passed, 5 skipped, 1 xfailed in " in elsewhere.stdout

    in_ci = run_tests(tmp_path, CI="1")
    assert in_ci.returncode == 1
    assert " 1 failed, 1 passed, 1 skipped, 1 xfailed, 3 errors in " in in_ci.stdout
    for reason in ("no_such_package", "rights", "machine", "system"):
        assert reason in in_ci.stdout
