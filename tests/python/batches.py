# SPDX-License-Identifier: GPL-3.0-or-later
"""Batches in a process of their own, and what they have written."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
from processes import environment, wait_until
from shapes import bumpy_sphere, octahedron

from spheroseg.batch import jobs
from spheroseg.ply import ply_bytes


def write_mesh(path: Path, seed: int = 0, levels: int = 2) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(ply_bytes(*bumpy_sphere(levels, seed)))


def write_finned(path: Path) -> None:
    """A mesh with an edge of three faces, which is refused."""
    vertices, faces = octahedron()
    finned = np.vstack([vertices, [[3.0, 3.0, 3.0]]]), np.vstack([faces, [[*faces[0][:2], 6]]])
    path.write_bytes(ply_bytes(*finned))


def start_batch(*arguments) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "spheroseg", "batch", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        errors="replace",
        env=environment(),
    )


def run_batch(*arguments) -> tuple[int, str, str]:
    process = start_batch(*arguments)
    said, complained = process.communicate()
    return process.returncode, said, complained


def rows(output: Path) -> list[dict[str, str]]:
    with (output / "manifest.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def record_count(output: Path) -> int:
    return sum(1 for _ in (output / jobs.RECORD_FOLDER).rglob("[!.]*.json"))


def wait_for_records(output: Path, count: int, process: subprocess.Popen) -> None:
    def there() -> bool:
        assert process.poll() is None, process.stderr.read()
        return record_count(output) >= count

    wait_until(there)
