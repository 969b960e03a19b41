#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps meshes onto the sphere and prints the table of docs/parametrization.md.

Usage: .venv/bin/python scripts/map_quality.py [--threads N] MESH...

A mesh named NAME*4 is subdivided once (each triangle in four), NAME*16 twice, and so on.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from pathlib import Path

import pymeshlab
from reproduce import BUILD, build_tools, write_raw_mesh


def write_subdivided(path: str, times: int, raw_path: Path) -> None:
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.load_new_mesh(path)
    level = 1
    while level < times:
        mesh_set.meshing_surface_subdivision_midpoint(
            iterations=1, threshold=pymeshlab.PercentageValue(0)
        )
        level *= 4
    write_raw_mesh(mesh_set.current_mesh(), raw_path)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="MESH")
    parser.add_argument("--threads", type=int, default=0, help="0: all cores")
    arguments = parser.parse_args()
    build_tools()
    print("| mesh | F | flipped | anisotropy | area: mean | area: largest | collapse s | all s |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        for name in arguments.meshes:
            path, _, times = name.partition("*")
            raw = Path(folder) / f"{Path(path).stem}{'_x' + times if times else ''}.raw"
            write_subdivided(path, int(times or 1), raw)
            command = [str(BUILD / "tools" / "map_quality"), str(arguments.threads), str(raw)]
            subprocess.run(command, check=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
