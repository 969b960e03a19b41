# SPDX-License-Identifier: GPL-3.0-or-later
"""The CSV file of runs: written row by row, so that an interrupted benchmark goes on."""

import csv
import io
from collections.abc import Iterable
from pathlib import Path

from spheroseg import atomic
from spheroseg.bench.statistics import STAGES

WORDS = ("mesh", "method", "measurement", "status", "error", "commit", "machine")
WORDS += ("mesh_sha256", "plugin")
COLUMNS = (
    "mesh",
    "triangle_count",
    "submesh_count",
    "method",
    "measurement",
    "seed",
    "threads",
    "status",
    "seconds",
    *STAGES,
    "boundary_edge_count",
    "max_triangle_count_difference",
    "min_submesh_triangles",
    "found_submesh_count",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
    "peak_bytes",
    "error",
    "commit",
    "machine",
    "mesh_sha256",
    "plugin",
)
CASE = ("mesh", "method", "submesh_count", "measurement", "seed")
KEY = (*CASE, "threads", "mesh_sha256")


class Records:
    """Rows in memory and in a file that grows with them."""

    def __init__(self, path: Path, rows: list[dict]):
        self.rows = rows
        self._keys = {key_of(row) for row in rows}
        path.parent.mkdir(parents=True, exist_ok=True)
        kept = io.StringIO()
        writer = _writer(kept)
        writer.writeheader()
        writer.writerows(rows)
        # The earlier rows are there until the kept ones are.
        atomic.write_text(path, kept.getvalue())
        self._stream = path.open("a", newline="")
        self._writer = _writer(self._stream)

    def __contains__(self, key: tuple) -> bool:
        return key in self._keys

    def add(self, row: dict) -> None:
        self.rows.append(row)
        self._keys.add(key_of(row))
        self._writer.writerow(row)
        self._stream.flush()

    def close(self) -> None:
        self._stream.close()


def _writer(stream) -> csv.DictWriter:
    return csv.DictWriter(stream, COLUMNS, lineterminator="\n")


def key_of(row: dict) -> tuple:
    return tuple(row[name] for name in KEY)


def case_of(row: dict) -> tuple:
    return tuple(row[name] for name in CASE)


def current(rows: Iterable[dict], planned: Iterable[dict], stamp: dict[str, str]) -> list[dict]:
    """The finished rows of this plugin and machine, without those that `planned` ones replace: the
    same case, but with other threads or another content of the mesh."""
    keys = {case_of(row): key_of(row) for row in planned}
    return [
        row
        for row in rows
        if all(row[name] == stamp[name] for name in ("plugin", "machine"))
        and row["status"] == "done"
        and keys.get(case_of(row), key_of(row)) == key_of(row)
    ]


def load(path: Path) -> list[dict]:
    """Rows of a file with their numbers as numbers; a half-written last line is left out."""
    if not path.is_file():
        return []
    with path.open(newline="") as stream:
        return [
            {name: _value(name, row.get(name) or "") for name in COLUMNS}
            for row in csv.DictReader(stream)
            if row.get("plugin")
        ]


def _value(name: str, text: str):
    if name in WORDS:
        return text
    if text == "":
        return None
    try:
        return int(text)
    except ValueError:
        return float(text)
