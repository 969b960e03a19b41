#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares balance by weight with METIS given the same weights, and starts from the labels of
others: the tables of docs/weights.md.

Usage: .venv/bin/python scripts/weights.py

PyMeshLab's samples cow and bunny, k = 200 and F/64, medians of seeds 1 to 5: areas, and random
whole weights from 1 to 10. METIS: k-way, contiguous, vertex weights (areas as multiples of 1e-6 of
their sum), other options default. Starts: displaced_sphere of sample_meshes, k = 60, seeds 1 and 2.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pymetis

REPOSITORY = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "python"))

import spheroseg  # noqa: E402
from spheroseg import mesh_files  # noqa: E402
from spheroseg.baselines import load  # noqa: E402
from spheroseg.dual_graph import build_dual_graph  # noqa: E402

SEEDS = range(1, 6)


def read(path: Path) -> tuple[np.ndarray, np.ndarray]:
    mesh_set = mesh_files.read_mesh(path)
    mesh = mesh_set.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix()


def face_areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def metis_labels(faces: np.ndarray, weights: np.ndarray, k: int, seed: int) -> np.ndarray:
    graph = build_dual_graph(faces)
    whole = weights
    if not np.array_equal(weights, weights.astype(int)):
        whole = np.maximum(1, np.round(weights / weights.sum() * 1e6))
    result = pymetis.part_graph(
        k,
        pymetis.CSRAdjacency(graph.starts, graph.adjacent),
        vweights=whole.astype(int).tolist(),
        recursive=False,
        options=pymetis.Options(contig=True, seed=seed),
    )
    return np.asarray(result.vertex_part)


def row(name: str, kind: str, vertices, faces, weights, k: int) -> str:
    cells = [name, f"{len(faces):,}", str(k), kind]
    lightest_possible = max(1.0, weights.max() / (weights.sum() / k))

    def ours(seed: int) -> np.ndarray:
        return spheroseg.segment(
            vertices, faces, k, balance="weight", face_weights=weights, seed=seed
        ).labels

    for labels_of in (ours, lambda seed: metis_labels(faces, weights, k, seed)):
        ratios, edges = [], []
        for seed in SEEDS:
            labels = labels_of(seed)
            loads = np.bincount(labels, weights, minlength=k)
            ratios.append(loads.max() / loads.mean())
            edges.append(spheroseg.measure(vertices, faces, labels)["boundary_edge_count"])
        cells += [f"{np.median(ratios):.4f}", f"{np.median(edges):.0f}"]
    return "| " + " | ".join([*cells, f"{lightest_possible:.3f}"]) + " |"


def labels_of_high(vertices, faces, k: int, seed: int) -> np.ndarray:
    """Of `high`, then ten triangles at a boundary, one after the other, change sides."""
    labels = spheroseg.segment(vertices, faces, k, effort="high", seed=seed).labels
    graph = build_dual_graph(faces)
    random = np.random.default_rng(seed)
    changes = 0
    while changes < 10:
        face = random.integers(len(faces))
        neighbor = random.choice(graph.adjacent[graph.starts[face] : graph.starts[face + 1]])
        changes += labels[face] != labels[neighbor]
        labels[face] = labels[neighbor]
    return labels


def start_row(vertices, faces, name: str, labels_of: Callable[..., np.ndarray], k: int) -> str:
    cells = [[], [], [], []]
    for seed in (1, 2):
        given = labels_of(vertices, faces, k, seed)
        result = spheroseg.segment(vertices, faces, initial_labels=given, seed=seed)
        before = spheroseg.measure(vertices, faces, given)
        cells[0].append(f"{before['boundary_edge_count']:,}")
        cells[1].append(str(before["max_triangle_count_difference"]))
        cells[2].append(str(result.measures["boundary_edge_count"]))
        cells[3].append(f"{100 * np.mean(result.labels == given):.0f} %")
    return f"| {name} | " + " | ".join(", ".join(cell) for cell in cells) + " |"


def main() -> None:
    argparse.ArgumentParser(description=__doc__.split("\n\n")[0]).parse_args()
    print("| mesh | F | k | weights | ours: heaviest / mean | BE | METIS | BE | no less than |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in ("cow.obj", "bunny.obj"):
        vertices, faces = read(mesh_files.sample_mesh(name))
        random = np.random.default_rng(1).integers(1, 11, len(faces)).astype(float)
        for k in (200, -(-len(faces) // 64)):
            for kind, weights in (("area", face_areas(vertices, faces)), ("1 to 10", random)):
                print(row(name, kind, vertices, faces, weights, k), flush=True)
    print("\n| start | its BE | its difference of counts | BE | kept |")
    print("|---|---|---|---|---|")
    vertices, faces = read(REPOSITORY / "sample_meshes" / "displaced_sphere.ply")
    for method in ("metis_kway", "metis_recursive", "region_growing"):
        print(start_row(vertices, faces, method, load(method), 60), flush=True)
    print(start_row(vertices, faces, "`high`, 10 changed", labels_of_high, 60), flush=True)


if __name__ == "__main__":
    main()
