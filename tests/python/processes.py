# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes that run Python with this package, and what they are doing."""

import contextlib
import os
import subprocess
import sys
import time
from pathlib import Path

from mesh_paths import REPOSITORY

from spheroseg import _plugin


def environment(**others):
    return {**os.environ, "PYTHONPATH": str(REPOSITORY / "python"), **others}


def run_python(*arguments, **others):
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        capture_output=True,
        text=True,
        env=environment(**others),
    )


def run_program(*arguments, **others):
    return run_python("-m", "spheroseg", *arguments, **others)


def run_shell(line, *arguments):
    """Runs a line of the shell in which "$@" is the program with its arguments."""
    program = [sys.executable, "-m", "spheroseg", *map(str, arguments)]
    return subprocess.run(
        ["bash", "-c", line, "bash", *program],
        capture_output=True,
        text=True,
        env=environment(PYTHONUNBUFFERED=""),
    )


def wait_until(condition, seconds=60):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def is_running(process_id):
    """Not so is one that has ended but that its parent has not asked about."""
    state = read_or_nothing(Path(f"/proc/{process_id}/stat")).rpartition(")")[2].split()
    return bool(state) and state[0] != "Z"


def children(process_id):
    found = Path(f"/proc/{process_id}/task").glob("*/children")
    return {int(child) for path in found for child in read_or_nothing(path).split()}


def jobs_of(batch):
    """The processes of the jobs of a batch, from when on they would end with their nursery, and
    have no input."""
    return {job for nursery in children(batch) for job in children(nursery) if _has_no_input(job)}


def _has_no_input(process_id):
    with contextlib.suppress(OSError):  # it may have ended
        return str(Path(f"/proc/{process_id}/fd/0").readlink()) == os.devnull
    return False


def is_filter_running():
    """One of another thread of this process."""
    is_free = _plugin._one_at_a_time.acquire(blocking=False)
    if is_free:
        _plugin._one_at_a_time.release()
    return not is_free


def read_or_nothing(path):
    """Of a process that may have ended."""
    try:
        return path.read_text()
    except OSError:
        return ""
