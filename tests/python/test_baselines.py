# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import math
import os
import subprocess
import sys
import time

import numpy as np
import pytest
from judge import Judge
from shapes import bumpy_sphere, octahedron, subdivided_sphere
from surfaces import SURFACES

from spheroseg import baselines, dual_graph
from spheroseg.baselines import build_dual_graph, kaminpar_exact, load
from spheroseg.baselines.metis_limit import ufactor_for_limit
from spheroseg.bench.methods import MeshRuns
from spheroseg.errors import InputError
from spheroseg.evaluate.methods import METHODS

PACKAGES = {name: baseline.package for name, baseline in baselines.BASELINES.items()}


def method(name: str):
    pytest.importorskip(PACKAGES[name])
    return load(name)


def brute_force_neighbours(faces: np.ndarray) -> list[set[int]]:
    corners = [set(face) for face in faces.tolist()]
    return [
        {j for j, other in enumerate(corners) if j != i and len(face & other) == 2}
        for i, face in enumerate(corners)
    ]


def test_dual_graph_equals_brute_force():
    _, faces = subdivided_sphere(2)
    graph = build_dual_graph(faces)
    expected = brute_force_neighbours(faces)
    assert [set(row) for row in graph.neighbours.tolist()] == expected
    assert [
        set(graph.adjacent[graph.starts[f] : graph.starts[f + 1]].tolist())
        for f in range(len(faces))
    ] == expected
    assert {tuple(edge) for edge in graph.edges().tolist()} == {
        (i, j) for i, others in enumerate(expected) for j in others if i < j
    }


def test_dual_graph_neighbour_lies_across_its_own_edge():
    _, faces = octahedron()
    neighbours = build_dual_graph(faces).neighbours
    for face in range(8):
        for side in range(3):
            edge = {faces[face, side], faces[face, (side + 1) % 3]}
            assert edge <= set(faces[neighbours[face, side]].tolist())


def test_dual_graph_marks_open_border():
    neighbours = build_dual_graph(np.array([[0, 1, 2], [2, 1, 3]])).neighbours
    assert neighbours.tolist() == [[-1, 1, -1], [0, -1, -1]]


def test_dual_graph_counts_two_triangles_with_two_common_edges_once():
    # Two triangles glued along all edges: one pair in the graph, three sides.
    graph = build_dual_graph(np.array([[0, 1, 2], [2, 1, 0]]))
    assert graph.neighbours.tolist() == [[1, 1, 1], [0, 0, 0]]
    assert graph.edges().tolist() == [[0, 1]]


def test_dual_graph_refuses_faces_that_are_no_triangles():
    with pytest.raises(InputError, match=r"shape \(F, 3\), but the shape is \(2, 4\)"):
        build_dual_graph(np.array([[0, 1, 2, 3], [3, 2, 1, 0]]))


def test_dual_graph_refuses_edge_with_three_triangles():
    with pytest.raises(ValueError, match="edge between vertices 0 and 1 has more than two"):
        build_dual_graph(np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))


@pytest.mark.parametrize("name", baselines.BASELINES)
def test_labels_cover_all_faces_with_every_label(name):
    vertices, faces = bumpy_sphere(3, 1)
    labels = method(name)(vertices, faces, 12, 3)
    assert labels.shape == (len(faces),)
    assert labels.dtype == np.int32
    assert set(labels.tolist()) == set(range(12))


@pytest.mark.parametrize("name", sorted(set(PACKAGES) - {"mtkahypar_quality"}))
def test_same_seed_gives_same_labels(name):
    segment = method(name)
    vertices, faces = bumpy_sphere(3, 1)
    labels = segment(vertices, faces, 12, 3)
    assert np.array_equal(labels, segment(vertices, faces, 12, 3))
    assert np.array_equal(labels, segment(vertices, faces, 12, 3, graph=build_dual_graph(faces)))


def test_mtkahypar_repeats_in_a_fresh_process():
    method("mtkahypar_quality")
    program = (
        "from shapes import bumpy_sphere; from spheroseg.baselines import load;"
        "print(load('mtkahypar_quality')(*bumpy_sphere(3, 1), 12, 3).tolist())"
    )
    runs = [
        subprocess.run(
            [sys.executable, "-c", program],
            env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
            capture_output=True,
            check=True,
        ).stdout
        for _ in range(2)
    ]
    assert runs[0] == runs[1]


@pytest.mark.parametrize("name", baselines.BASELINES)
def test_one_part_takes_all(name):
    vertices, faces = octahedron()
    assert method(name)(vertices, faces, 1, 0).tolist() == [0] * 8


@pytest.mark.parametrize("name", baselines.BASELINES)
def test_prepared_baseline_gives_the_labels_of_the_plain_one(name):
    segment = method(name)
    vertices, faces = bumpy_sphere(2, 1)
    prepared = baselines.prepare(name, vertices, faces, build_dual_graph(faces))
    for k in (1, 5):
        labels = prepared(k, 3)
        assert labels.dtype == np.int32
        # Mt-KaHyPar's labels depend on the calls before.
        if name != "mtkahypar_quality":
            assert np.array_equal(labels, segment(vertices, faces, k, 3))


@pytest.mark.parametrize("name", sorted(set(PACKAGES) - {"region_growing"}))
@pytest.mark.parametrize("program", ["bench", "evaluate"])
def test_no_clock_of_a_partitioner_covers_what_only_the_mesh_decides(name, program, monkeypatch):
    method(name)
    vertices, faces = bumpy_sphere(2, 1)
    graph = build_dual_graph(faces)
    runs = MeshRuns(vertices, faces)
    events = []
    for owner, function in (
        (time, "perf_counter"),
        (dual_graph, "lowest_connected"),
        (dual_graph, "build_dual_graph"),
        (dual_graph.DualGraph, "edges"),
        (kaminpar_exact, "metis_text"),
    ):
        original = getattr(owner, function)

        def recorded(*arguments, original=original, function=function):
            events.append(function)
            return original(*arguments)

        monkeypatch.setattr(owner, function, recorded)
    if program == "bench":
        runs.rival(name, 5, 1)
    else:
        METHODS[name].run(vertices, faces, 5, 1, graph)
    assert events[-2:] == ["perf_counter", "perf_counter"]


@pytest.mark.parametrize("name", baselines.BASELINES)
@pytest.mark.parametrize("k", [0, 9])
def test_rejects_impossible_part_count(name, k):
    vertices, faces = octahedron()
    with pytest.raises(ValueError, match=rf"k must be in \[1, 8\].*but is {k}"):
        method(name)(vertices, faces, k, 0)


@pytest.mark.parametrize(
    ("name", "recursive", "options"),
    [
        ("metis_kway", False, {"contig": 1}),
        ("metis_recursive", True, {}),
        ("metis_tight", False, {"contig": 1, "ufactor": 1}),
    ],
)
@pytest.mark.parametrize("seed", [0, 1, 5])
def test_metis_equals_a_direct_call(name, recursive, options, seed):
    pymetis = pytest.importorskip("pymetis")
    vertices, faces = bumpy_sphere(4, 2)
    neighbours = build_dual_graph(faces).neighbours
    direct = pymetis.part_graph(
        40,
        neighbours.tolist(),
        recursive=recursive,
        options=pymetis.Options(**options, **({"seed": seed} if seed else {})),
    )
    labels = load(name)(vertices, faces, 40, seed)
    assert labels.tolist() == list(direct.vertex_part)
    cut = sum(labels[face] != labels[other] for face, row in enumerate(neighbours) for other in row)
    assert cut == 2 * direct.edge_cuts


@pytest.mark.parametrize(("face_count", "k"), [(5804, 200), (20096, 200), (2048, 2048), (7, 3)])
def test_ufactor_gives_one_triangle_of_room_and_no_less_would(face_count, k):
    ufactor = ufactor_for_limit(face_count, k)
    limit = math.ceil(face_count / k) + 1
    assert face_count * (1000 + ufactor) >= 1000 * limit * k
    assert face_count * (999 + ufactor) < 1000 * limit * k


def test_metis_limit_beats_the_default_at_few_triangles_per_part():
    # 2048 triangles in 71 parts: 3 % of 28.8 is less than one triangle of room.
    vertices, faces = bumpy_sphere(4, 7)
    graph = build_dual_graph(faces)
    cut = {
        name: np.count_nonzero(np.diff(method(name)(vertices, faces, 71, 0)[graph.edges()]))
        for name in ("metis_kway", "metis_limit")
    }
    assert cut["metis_limit"] < cut["metis_kway"]


def test_kaminpar_fills_every_part_exactly():
    vertices, faces = bumpy_sphere(3, 4)
    counts = np.bincount(method("kaminpar_exact")(vertices, faces, 30, 0))
    assert sorted(counts) == [17] * 28 + [18] * 2  # 512 = 28 * 17 + 2 * 18


def test_mtkahypar_keeps_its_slack():
    vertices, faces = bumpy_sphere(4, 4)
    counts = np.bincount(method("mtkahypar_quality")(vertices, faces, 16, 0), minlength=16)
    assert counts.max() <= 1.03 * 2048 / 16


@pytest.mark.parametrize("k", [2, 9, 40])
@pytest.mark.parametrize("seed", [0, 1])
def test_region_growing_is_connected_and_bowtie_free(k, seed):
    vertices, faces = bumpy_sphere(3, seed)
    labels = method("region_growing")(vertices, faces, k, seed)
    verdict = Judge(faces).judge(labels, k)
    assert (verdict.bowtie_count, verdict.disconnected_submesh_count) == (0, 0)


def grown_step_by_step(vertices, faces, k, seed):
    """Labels by region growing as it is described, and how often every region was blocked."""
    neighbours = brute_force_neighbours(faces)
    centroids = vertices[faces].mean(axis=1)
    labels = np.full(len(faces), -1)
    seeds = np.random.default_rng(seed).choice(len(faces), size=k, replace=False)
    labels[seeds] = range(k)
    sums = centroids[seeds]

    def bowties_made(face, region):
        members = set(np.flatnonzero(labels == region).tolist())
        return sum(
            any(corner in faces[other] for other in members)
            and not any(corner in faces[other] for other in neighbours[face] & members)
            for corner in faces[face]
        )

    def grow(region, bowties_allowed):
        distances = centroids - sums[region] / (labels == region).sum()
        squares = (distances * distances).sum(axis=1)
        for face in np.argsort(squares, kind="stable"):
            beside = any(labels[other] == region for other in neighbours[face])
            if labels[face] < 0 and beside and bowties_made(face, region) <= bowties_allowed:
                labels[face] = region
                sums[region] += centroids[face]
                return True
        return False

    blocked = 0
    while (labels < 0).any():
        if not any([grow(region, 0) for region in range(k)]):
            blocked += 1
            assert any(grow(region, fewest) for fewest in (1, 2, 3) for region in range(k))
    return labels, blocked


def test_region_growing_takes_what_a_plain_search_takes():
    # On a ring of triangles the last but one touches both ends of its region: a bowtie.
    corners = np.arange(24)
    angles = corners * np.pi / 12
    radii = 1 + corners % 2
    points = np.stack((radii * np.cos(angles), radii * np.sin(angles), 0 * angles), axis=1)
    ring = points, (corners[:, None] + np.arange(3)) % 24
    blocked = 0
    for vertices, faces in [subdivided_sphere(1), bumpy_sphere(2, 0), octahedron(), ring]:
        for k in (1, 2, 5, 8):
            for seed in range(8):
                expected, times = grown_step_by_step(vertices, faces, k, seed)
                found = method("region_growing")(vertices, faces, k, seed)
                assert found.tolist() == expected.tolist(), (len(faces), k, seed)
                blocked += times
    assert blocked > 0


def test_region_growing_from_every_triangle_keeps_the_seeds():
    vertices, faces = octahedron()
    labels = method("region_growing")(vertices, faces, 8, 0)
    assert sorted(labels.tolist()) == list(range(8))


def test_region_growing_reaches_a_component_without_seed():
    vertices, faces = octahedron()
    two = np.concatenate((faces, faces + 6))
    labels = method("region_growing")(np.concatenate((vertices, vertices + 5)), two, 1, 0)
    assert labels.tolist() == [0] * 16


def test_region_growing_step_by_step_on_a_strip():
    # Seeds at both ends of a strip of six triangles: each takes its neighbour in turn.
    points = np.array([[i / 2, i % 2, 0] for i in range(8)], dtype=float)
    strip = np.array([[i, i + 1, i + 2] for i in range(6)])
    growing = method("region_growing")
    found = set()
    for seed in range(30):
        seeds = np.random.default_rng(seed).choice(6, size=2, replace=False)
        if set(seeds.tolist()) == {0, 5}:
            found.add(tuple((growing(points, strip, 2, seed) == seeds.tolist().index(0)).tolist()))
    assert found == {(True, True, True, False, False, False)}


def test_unknown_baseline_names_the_known_ones():
    with pytest.raises(ValueError, match="no baseline is called 'magic'; known are metis_kway"):
        load("magic")


@pytest.mark.parametrize("name", ["metis_kway", "kaminpar_exact", "mtkahypar_quality"])
def test_absent_library_is_named_with_the_remedy(name, monkeypatch):
    monkeypatch.setitem(sys.modules, PACKAGES[name], None)
    vertices, faces = octahedron()
    with pytest.raises(ImportError, match=f"pip install {PACKAGES[name]}"):
        load(name)(vertices, faces, 2, 0)


@pytest.mark.parametrize("name", SURFACES)
def test_dual_graph_of_any_surface_has_the_judges_components_and_fans(name):
    _, faces = SURFACES[name].make()
    graph, judge = build_dual_graph(faces), Judge(faces)
    pairs = {tuple(sorted(pair)) for pair in judge.pairs.tolist()}
    assert {tuple(pair) for pair in graph.edges().tolist()} == pairs
    assert len(graph.edges()) == len(pairs)
    for found, expected in (
        (graph.component_of_triangle(), judge.component_of_face),
        (graph.fan_of_corner(faces).ravel(), judge.fan_of_corner),
    ):
        # The same partition: as many pairs as classes of either.
        classes = len(np.unique(found))
        assert classes == len(np.unique(expected))
        assert classes == len(np.unique(np.column_stack((found, expected)), axis=0))


def test_contiguous_metis_of_several_components_is_refused_and_not_garbage():
    vertices, faces = SURFACES["touching discs"].make()
    for name in ("metis_kway", "metis_tight", "metis_limit"):
        with pytest.raises(InputError, match="the mesh has 6"):
            method(name)(vertices, faces, 12, 0)
        with pytest.raises(InputError, match="the mesh has 6"):
            baselines.prepare(name, vertices, faces, build_dual_graph(faces))
    assert len(np.unique(method("metis_recursive")(vertices, faces, 12, 0))) == 12


@pytest.mark.parametrize("name", ["plane with holes", "klein bottle", "pinched ring", "50 spheres"])
def test_region_growing_covers_any_surface(name):
    vertices, faces = SURFACES[name].make()
    labels = method("region_growing")(vertices, faces, 60, 1)
    assert len(np.unique(labels)) == 60
    assert labels.min() == 0
