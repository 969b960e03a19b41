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

import numpy as np
import pymeshlab
from reproduce import BUILD, build_tools


def write_raw(name: str, raw_path: Path) -> None:
    path, _, times = name.partition("*")
    mesh_set = pymeshlab.MeshSet(verbose=False)
    mesh_set.load_new_mesh(path)
    level = 1
    while times and level < int(times):
        mesh_set.meshing_surface_subdivision_midpoint(
            iterations=1, threshold=pymeshlab.PercentageValue(0)
        )
        level *= 4
    mesh = mesh_set.current_mesh()
    vertices = mesh.vertex_matrix().astype(np.float64)
    faces = mesh.face_matrix().astype(np.int32)
    with raw_path.open("wb") as file:
        np.array([len(vertices), len(faces)], np.int32).tofile(file)
        vertices.tofile(file)
        faces.tofile(file)


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
            write_raw(name, raw)
            command = [str(BUILD / "tools" / "map_quality"), str(arguments.threads), str(raw)]
            subprocess.run(command, check=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
