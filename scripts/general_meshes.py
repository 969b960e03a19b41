#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares `fast` with METIS on surfaces of every kind; prints the tables of docs/input.md.

Usage: .venv/bin/python scripts/general_meshes.py [--seeds N] [--efforts NAME,...] [--only WORD]
       [--picture PNG]

The surfaces are those of tests/python/surfaces.py, at k = 2, 7, 50 and F/64 as far as a surface has
so many faces and no more components. METIS runs k-way (contiguous) and by recursive bisection,
other options default; each number is the median over the seeds 1 to N.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import statistics
import sys
from pathlib import Path

import numpy as np

REPOSITORY = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(REPOSITORY / "python"), str(REPOSITORY / "tests" / "python")]

from judge import Judge, best_difference  # noqa: E402 (after the folder of the tests)
from surfaces import SURFACES  # noqa: E402

import spheroseg  # noqa: E402
from spheroseg.baselines import build_dual_graph, load  # noqa: E402
from spheroseg.evaluate import environment  # noqa: E402
from spheroseg.evaluate.judging import METIS_MODES, geometric_mean, is_valid  # noqa: E402
from spheroseg.palette import colour_indices, palette  # noqa: E402
from spheroseg.render import render_labels, write_png  # noqa: E402
from spheroseg.submeshes import split_into_submeshes  # noqa: E402

# Surface, k, and where the eye is.
PICTURED = (
    ("torus", 50, (0.3, -1.0, 1.1)),
    ("plane with holes", 50, (0.2, -0.6, 1.0)),
    ("moebius band", 50, (0.5, -1.2, 0.9)),
    ("50 spheres", 140, (0.0, -0.25, 1.0)),
)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=3, help="runs per case")
    parser.add_argument("--efforts", default="draft,standard", help="efforts of fast")
    parser.add_argument("--only", default="", help="surfaces whose name has this in it")
    parser.add_argument("--picture", type=Path, help="write a picture of four results, and stop")
    options = parser.parse_args()
    if options.picture:
        write_png(options.picture, picture())
        return 0
    efforts = options.efforts.split(",")
    print_facts(options.seeds)
    print(f"| surface | F | k | {' | '.join(efforts)} | METIS k-way | METIS recursive | ratio |")
    print("|---" * (6 + len(efforts)) + "|", flush=True)
    ratios: dict[str, list[float]] = {effort: [] for effort in efforts}
    invalid = 0
    for name, surface in SURFACES.items():
        if options.only in name:
            invalid += compare(name, *surface.make(), efforts, options.seeds, ratios)
    print()
    for effort, found in ratios.items():
        if found:
            mean = geometric_mean(found)
            print(f"{effort} over the better METIS mode, {len(found)} cases: {mean:.3f}")
    print(f"results of fast that are not valid: {invalid}")
    return 0


def print_facts(seeds: int) -> None:
    facts = environment.surroundings()
    shown = ("commit", "pymetis", "processor", "cores", "system")
    print(", ".join(f"{name} {facts[name]}" for name in shown if name in facts), end="")
    print(f"; medians of seeds 1 to {seeds}\n")


def compare(name, vertices, faces, efforts, seeds, ratios) -> int:
    """Prints the rows of one surface, adds to the ratios; returns how many results of ours are not
    valid."""
    judge = Judge(faces)
    components = len(judge.component_sizes())
    graph = build_dual_graph(faces)
    invalid = 0
    for k in sorted({2, 7, 50, len(faces) // 64}):
        if not components <= k <= len(faces):
            continue
        ours = {}
        for effort in efforts:
            ours[effort], wrong = run_ours(vertices, faces, judge, k, effort, seeds)
            invalid += wrong
        metis = [run_metis(mode, vertices, faces, graph, judge, k, seeds) for mode in METIS_MODES]
        accepted = [edges for edges, _ in metis if edges]
        ratio = "–"
        if accepted and all(ours.values()):
            for effort in efforts:
                ratios[effort].append(ours[effort] / min(accepted))
            ratio = f"{ours[efforts[-1]] / min(accepted):.3f}"
        cells = [f"{ours[effort]:g}" for effort in efforts]
        cells += [f"{edges:g}{mark}" if edges else "refuses" for edges, mark in metis]
        print(f"| {name} | {len(faces):,} | {k} | {' | '.join(cells)} | {ratio} |", flush=True)
    return invalid


def run_ours(vertices, faces, judge, k, effort, seeds) -> tuple[float, int]:
    """Median of the boundary edges, and how many results are not valid."""
    best = best_difference(judge.component_sizes(), k)
    edges, wrong = [], 0
    for seed in range(1, seeds + 1):
        labels = spheroseg.segment(vertices, faces, k, effort=effort, seed=seed).labels
        verdict = judge.judge(labels, k)
        edges.append(verdict.boundary_edge_count)
        wrong += not is_valid(vars(verdict), best)
    return statistics.median(edges), wrong


def run_metis(mode, vertices, faces, graph, judge, k, seeds) -> tuple[float | None, str]:
    """Median of the boundary edges, None where METIS refuses, and * where a result is not valid."""
    best = best_difference(judge.component_sizes(), k)
    edges, mark = [], ""
    for seed in range(1, seeds + 1):
        try:
            with silence():
                labels = load(mode)(vertices, faces, k, seed, graph=graph)
        except Exception:
            return None, ""
        verdict = judge.judge(labels, k)
        edges.append(verdict.boundary_edge_count)
        mark = mark if is_valid(vars(verdict), best) else "*"
    return statistics.median(edges), mark


@contextlib.contextmanager
def silence():
    """METIS prints what it refuses to the process's own output."""
    sys.stdout.flush()
    kept = os.dup(1)
    with Path(os.devnull).open("w") as nothing:
        os.dup2(nothing.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(kept, 1)
            os.close(kept)


def picture() -> np.ndarray:
    """Four results in two rows."""
    images = []
    for name, k, view in PICTURED:
        vertices, faces = SURFACES[name].make()
        labels = spheroseg.segment(vertices, faces, k).labels
        blocks = split_into_submeshes(vertices, faces, labels)
        chosen = colour_indices(blocks.count, blocks.neighbour_starts, blocks.neighbours)
        colours = palette(int(chosen.max()) + 1)[chosen][labels] / 255.0
        images.append(
            render_labels(
                vertices, faces, labels, colours, size=(450, 300), view=view, up=(0, 1, 0)
            )
        )
    return np.concatenate([np.concatenate(images[i : i + 2], axis=1) for i in (0, 2)])


if __name__ == "__main__":
    raise SystemExit(main())
