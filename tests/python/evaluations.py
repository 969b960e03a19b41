# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluation that the tests of the report share."""

from __future__ import annotations

from pathlib import Path

from shapes import bumpy_sphere

from spheroseg.cli import main
from spheroseg.ply import ply_bytes

RUN_METHODS = ("all_pairs", "metis_kway", "region_growing")
COUNTS = (5, 16)


def write_inputs(folder: Path) -> None:
    """Two meshes of 512 triangles; the second is tall, as people are, and far away, as in UTM
    coordinates."""
    folder.mkdir()
    for name, seed, height, place in (
        ("first", 1, 1, 0),
        ("second", 2, 4, (448_251, 5_411_932, 3)),
    ):
        vertices, faces = bumpy_sphere(3, seed)
        (folder / f"{name}.ply").write_bytes(ply_bytes(vertices * [1, height, 1] + place, faces))


def evaluate(source: Path, output: Path, *more: str, methods=RUN_METHODS) -> int:
    arguments = ["evaluate", str(source), "-o", str(output), "--methods", ",".join(methods)]
    return main([*arguments, "-k", *map(str, COUNTS), *more])
