#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reproduces the paper's segmentations with `all_pairs` and writes the tables of
docs/reproduction.md.

Usage: .venv/bin/python scripts/reproduce.py [--meshes DIR] [--seeds N] [--threads N]

DIR holds human.ply and david.ply; the cow is PyMeshLab's own sample.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pymeshlab

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "build" / "tools"
DOCUMENT = ROOT / "docs" / "reproduction.md"
SUBMESH_COUNT = 200
# Boundary edges at the end, from the paper's Table 1; no bowtie on any model.
PAPER_BOUNDARY_EDGES = {"human": 3041, "david": 1963, "cow": 1580}
# Of one pair test: 6 subtractions, 6 multiplications, 4 additions, 2 roots; 2 sums, 1 comparison.
OPERATIONS_PER_PAIR = 21
ROOTS_PER_PAIR = 2


def build_tools() -> None:
    cmake = ["cmake", "-S", str(ROOT), "-B", str(BUILD), "-DCMAKE_BUILD_TYPE=Release"]
    cmake += ["-DSPHEROSEG_BUILD_PLUGIN=OFF", "-DSPHEROSEG_BUILD_TOOLS=ON"]
    subprocess.run(cmake, check=True, stdout=subprocess.DEVNULL)
    build = ["cmake", "--build", str(BUILD), "--parallel", "2"]
    subprocess.run(build, check=True, stdout=subprocess.DEVNULL)


def mesh_paths(directory: Path) -> dict[str, Path]:
    samples = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes"
    return {
        "human": directory / "human.ply",
        "david": directory / "david.ply",
        "cow": samples / "cow.obj",
    }


def write_raw(mesh_path: Path, raw_path: Path) -> None:
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(mesh_path))
    write_raw_mesh(mesh_set.current_mesh(), raw_path)


def write_raw_mesh(mesh: pymeshlab.Mesh, raw_path: Path) -> None:
    counts = np.array([mesh.vertex_number(), mesh.face_number()], dtype=np.int32)
    vertices = mesh.vertex_matrix().astype(np.float64)
    faces = mesh.face_matrix().astype(np.int32)
    raw_path.write_bytes(counts.tobytes() + vertices.tobytes() + faces.tobytes())


def segment_all(meshes: dict[str, Path], seed_count: int, thread_count: int) -> dict:
    results = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, path in meshes.items():
            raw_path = Path(folder) / f"{name}.raw"
            write_raw(path, raw_path)
            arguments = [raw_path, SUBMESH_COUNT, seed_count, thread_count]
            output = subprocess.run(
                [str(BUILD / "tools" / "reproduce"), *map(str, arguments)],
                check=True,
                capture_output=True,
                text=True,
            ).stdout
            results[name] = [json.loads(line) for line in output.splitlines()]
    return results


def table(header: list[str], rows: list[list[object]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def result_table(results: dict) -> str:
    rows = []
    for name, runs in results.items():
        paper = PAPER_BOUNDARY_EDGES[name]
        run = runs[0]
        before, after = run["after_cohesion"], run["after_refinement"]
        edges = after["boundary_edge_count"]
        rows.append(
            [
                f"{name} ({run['triangle_count']:,})",
                f"{run['cohesion_iterations']} + {run['refinement_iterations']}",
                f"{run['energy_by_iteration'][run['cohesion_iterations'] - 1]:.1f}",
                f"{before['boundary_edge_count']:,}",
                f"{before['bowtie_count']} / {before['disconnected_submesh_count']}",
                f"**{edges:,}**",
                f"{paper:,}",
                f"{100 * (edges / paper - 1):+.1f} %",
                f"{after['bowtie_count']} / {after['disconnected_submesh_count']}",
                after["max_triangle_count_difference"],
                f"{run['cohesion_seconds']:.2f} + {run['refinement_seconds']:.2f}",
            ]
        )
    header = ["mesh (triangles)", "iterations", "energy", "BE after cohesion"]
    header += ["bowties / disconnected", "BE at the end", "paper's BE", "difference"]
    header += ["bowties / disconnected", "MTCD", "seconds"]
    return table(header, rows)


def seed_table(results: dict) -> str:
    rows = []
    for name, runs in results.items():
        ends = [run["after_refinement"] for run in runs]
        edges = [end["boundary_edge_count"] for end in ends]
        rows.append(
            [
                name,
                f"{min(edges):,} to {max(edges):,}, mean {np.mean(edges):,.0f}",
                f"{100 * (np.mean(edges) / PAPER_BOUNDARY_EDGES[name] - 1):+.1f} %",
                ", ".join(str(end["bowtie_count"]) for end in ends),
                ", ".join(str(end["disconnected_submesh_count"]) for end in ends),
            ]
        )
    header = ["mesh", "BE at the end", "mean against the paper", "bowties per seed"]
    return table([*header, "disconnected sub-meshes per seed"], rows)


def iteration_table(run: dict) -> str:
    edges = run["boundary_edges_by_iteration"]
    energy = run["energy_by_iteration"]
    cohesion = run["cohesion_iterations"]
    rows = []
    for i, (edge_count, sum_of_costs) in enumerate(zip(edges, energy, strict=True)):
        step = f"cohesion {i + 1}" if i < cohesion else f"refinement {i + 1 - cohesion}"
        shown = i < 6 or i >= cohesion - 1 or (i + 1) % 5 == 0
        if shown:
            rows.append([step, f"{edge_count:,.0f}", f"{sum_of_costs:,.1f}"])
    return table(["iteration", "BE", "energy"], rows)


def processor_name() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


def throughput_section() -> str:
    command = [str(BUILD / "tools" / "pair_throughput"), "5804", "20096", "48904"]
    output = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    measured = json.loads(output)
    peak = measured["multiplications_and_additions_per_second"]
    roots = measured["square_roots_per_second"]
    rows = []
    for run in measured["runs"]:
        threads = run["thread_count"]
        rate = run["pairs_per_processor_second"]
        rows.append(
            [
                f"{run['face_count']:,}",
                threads,
                f"{run['pairs_per_second'] / 1e9:.2f}",
                f"{rate / 1e9:.2f}",
                f"{rate * OPERATIONS_PER_PAIR / 1e9:.0f}",
                f"{100 * rate * OPERATIONS_PER_PAIR / peak:.0f} %",
                f"{100 * rate * ROOTS_PER_PAIR / roots:.0f} %",
            ]
        )
    header = ["faces", "threads", "10^9 pairs/s (wall clock)", "10^9 pairs per processor second"]
    header += ["GFLOP/s per processor second", "of the add-and-multiply limit"]
    header += ["of the square-root limit"]
    load = ", ".join(f"{value:.1f}" for value in os.getloadavg())
    return (
        f"{processor_name()}, {measured['cores']} cores; load averages during the run: {load}. "
        f"One core's limits, measured by the same program: {peak / 1e9:.0f} * 10^9 additions and "
        f"multiplications and {roots / 1e9:.1f} * 10^9 square roots per second.\n\n"
        + table(header, rows)
    )


def replace_section(text: str, name: str, content: str) -> str:
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    head, rest = text.split(begin, 1)
    tail = rest.split(end, 1)[1]
    return f"{head}{begin}\n{content}\n{end}{tail}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--meshes", type=Path, default=ROOT.parent / "shared" / "meshes")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    meshes = mesh_paths(arguments.meshes)
    missing = [str(path) for path in meshes.values() if not path.exists()]
    if missing:
        print(f"Expected meshes that are not there: {', '.join(missing)}. Use --meshes DIR.")
        return 2
    build_tools()
    results = segment_all(meshes, arguments.seeds, arguments.threads)
    text = DOCUMENT.read_text()
    text = replace_section(text, "results", result_table(results))
    text = replace_section(text, "seeds", seed_table(results))
    text = replace_section(text, "iterations", iteration_table(results["human"][0]))
    text = replace_section(text, "throughput", throughput_section())
    DOCUMENT.write_text(text)
    print(result_table(results), seed_table(results), sep="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
