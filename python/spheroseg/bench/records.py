# SPDX-License-Identifier: GPL-3.0-or-later
"""The CSV file of runs: written row by row, so that an interrupted benchmark goes on."""

import csv
from pathlib import Path

from spheroseg.bench.statistics import STAGES

WORDS = ("mesh", "method", "measurement", "status", "error", "commit", "plugin")
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
    "plugin",
)
KEY = ("mesh", "method", "submesh_count", "measurement", "seed")


class Records:
    """Rows in memory and in a file that grows with them."""

    def __init__(self, path: Path, rows: list[dict]):
        self.rows = rows
        self._keys = {key_of(row) for row in rows}
        path.parent.mkdir(parents=True, exist_ok=True)
        self._stream = path.open("w", newline="")
        self._writer = csv.DictWriter(self._stream, COLUMNS, lineterminator="\n")
        self._writer.writeheader()
        self._writer.writerows(rows)
        self._stream.flush()

    def __contains__(self, key: tuple) -> bool:
        return key in self._keys

    def add(self, row: dict) -> None:
        self.rows.append(row)
        self._keys.add(key_of(row))
        self._writer.writerow(row)
        self._stream.flush()

    def close(self) -> None:
        self._stream.close()


def key_of(row: dict) -> tuple:
    return tuple(row[name] for name in KEY)


def load(path: Path) -> list[dict]:
    """Rows of a file with their numbers as numbers; a half-written last line is left out."""
    if not path.is_file():
        return []
    with path.open(newline="") as stream:
        return [
            {name: _value(name, text) for name, text in row.items()}
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
