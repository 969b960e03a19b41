#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tries mesh files that nobody had in mind here ("Meshes of others" in docs/reliability.md).

Usage: .venv/bin/pip install nibabel; .venv/bin/python scripts/meshes_of_others.py FOLDER

Fetches Python packages that bring meshes along (parts of robots from CAD, scans, surfaces of
brains), about 600 MB, and writes into FOLDER: `meshes`, all mesh files of different content;
`results`, a batch of them at k = 20; `large`, links to those of one component and at least 10,000
triangles that it cut, one of each number of triangles, since what is connected alike is cut alike;
`bench`, the benchmark and the sweep over k on these. What is there is not fetched again.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import nibabel
import numpy as np
import pymeshlab

REPOSITORY = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "python"))

from spheroseg.batch.inputs import MESH_SUFFIXES  # noqa: E402
from spheroseg.digests import sha256  # noqa: E402

PACKAGES = (
    "brainspace==0.3.0",
    "compas==2.15.1",
    "dm_control==1.0.50",
    "example-robot-data==6.0.0",
    "gymnasium-robotics==1.4.2",
    "HippoMaps==0.1.17",
    "mani_skill==3.0.1",
    "meshcat==0.3.2",
    "pycortex==1.4.0",
    "robosuite==1.5.2",
    "tvb-data==3.0.0",
)
# Of the surfaces of brains in GIFTI files; others are these again, made flat or round.
SURFACES = ("pia", "midthickness", "conte69_32k_lh.gii", "conte69_32k_rh.gii", "cortex")
SUBMESH_COUNT = "20"
LEAST_TRIANGLES = 10_000
METHODS = "fast_standard,fast_high,metis_kway,metis_recursive,mtkahypar_quality"
PREFIX = "other_"


def fetch(packages: Path) -> None:
    """The archives of all packages, without those that they need."""
    pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--dest", str(packages), *PACKAGES], check=True)


def unpack(packages: Path, meshes: Path) -> None:
    """Their mesh files, each content once, below a folder per package."""
    known = set()
    for archive in sorted(packages.iterdir()):
        package = archive.name.split("-")[0]
        with tempfile.TemporaryDirectory() as folder:
            shutil.unpack_archive(archive, folder, "zip" if archive.suffix == ".whl" else None)
            for path in sorted(Path(folder).rglob("*")):
                is_mesh = path.suffix.lower() in MESH_SUFFIXES
                is_surface = ".gii" in path.suffixes and any(name in path.name for name in SURFACES)
                if not path.is_file() or not (is_mesh or is_surface):
                    continue
                digest = sha256(path)
                if digest in known:
                    continue
                known.add(digest)
                place = meshes / package / path.relative_to(folder)
                place.parent.mkdir(parents=True, exist_ok=True)
                if is_mesh:
                    shutil.copyfile(path, place)
                else:
                    write_surface(path, place.with_name(place.name.split(".gii")[0] + ".ply"))


def write_surface(source: Path, target: Path) -> None:
    """The surface of a GIFTI file as a PLY; nothing where it holds no surface."""
    image = nibabel.load(source)
    vertices = image.agg_data("pointset")
    faces = image.agg_data("triangle")
    if len(vertices) and len(faces):
        mesh_set = pymeshlab.MeshSet()
        mesh_set.add_mesh(pymeshlab.Mesh(np.asarray(vertices, float), np.asarray(faces, np.int32)))
        mesh_set.save_current_mesh(str(target))


def run(*arguments: str | Path) -> None:
    """A module of the package; a batch where some mesh fails ends with 1."""
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "python")}
    call = [sys.executable, "-m", *map(str, arguments)]
    if subprocess.run(call, env=environment, check=False).returncode > 1:
        sys.exit(f"{' '.join(call)}: failed")


def link_large_ones(manifest: Path, large: Path) -> None:
    shutil.rmtree(large, ignore_errors=True)
    large.mkdir()
    known = set()
    with manifest.open(newline="") as lines:
        for row in csv.DictReader(lines):
            if row["status"] != "done" or row["component_count"] != "1":
                continue
            triangles = int(row["triangle_count"])
            if triangles >= LEAST_TRIANGLES and triangles not in known:
                known.add(triangles)
                mesh = Path(row["mesh"]).resolve()
                (large / f"{PREFIX}{len(known):02}_{mesh.name}").symlink_to(mesh)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="made where it is not there")
    folder = parser.parse_args().folder
    meshes, results, large = (folder / name for name in ("meshes", "results", "large"))
    if not meshes.exists():
        half = folder / "meshes.part"
        shutil.rmtree(half, ignore_errors=True)
        fetch(folder / "packages")
        unpack(folder / "packages", half)
        half.rename(meshes)
    run("spheroseg", "batch", meshes, "-o", results, "-k", SUBMESH_COUNT, "--resume")
    link_large_ones(results / "manifest.csv", large)
    bench = ["spheroseg.bench", "--samples", "none", "--more-meshes", large, "--repeats", "1"]
    bench += ["--meshes", f"{PREFIX}*", "--output", folder / "bench"]
    run(*bench, "--methods", METHODS)
    run(*bench, "--validity-sweep")
    return 0


if __name__ == "__main__":
    sys.exit(main())
