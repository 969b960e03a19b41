# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import base64
import csv
import functools
import gzip
import html
import json
import math
import os
import re
import socket
import subprocess
import sys
import time
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import recount
from evaluations import COUNTS, RUN_METHODS, evaluate, write_inputs
from judge import Judge
from mesh_paths import PYMESHLAB_MESHES, REPOSITORY
from shapes import bumpy_sphere, octahedron
from surfaces import SURFACES

pytest.importorskip("jinja2")
pytest.importorskip("pyvista")
pytest.importorskip("matplotlib")

from matplotlib.transforms import Affine2D

from spheroseg import api, packages
from spheroseg.baselines import BASELINES
from spheroseg.batch import inputs
from spheroseg.cli import main
from spheroseg.dual_graph import build_dual_graph
from spheroseg.errors import InputError
from spheroseg.evaluate import (
    environment,
    judging,
    paper,
    pictures,
    plots,
    report,
    runner,
    summary,
    worker,
)
from spheroseg.evaluate import folder as report_folder
from spheroseg.evaluate.methods import (
    ALL_PAIRS_LIMIT,
    DEFAULT_METHODS,
    METHODS,
    Outcome,
    chosen,
)
from spheroseg.evaluate.runner import Plan
from spheroseg.evaluate.topology import TRIANGLE_BYTES, VERTEX_BYTES, anatomy
from spheroseg.ply import ply_bytes

TIMES = ("seconds", "details")


def results(output: Path) -> list[dict]:
    return json.loads((output / "results.json").read_text())["rows"]


@pytest.mark.parametrize("k", [1, 2, 7, 60])
def test_anatomy_equals_recount_on_random_labels(k):
    _, faces = bumpy_sphere(2, 0)
    labels = np.random.default_rng(k).integers(0, k, size=len(faces)).astype(np.int32)
    labels[:k] = np.arange(k)
    parts = anatomy(faces, build_dual_graph(faces), labels, k)
    expected = recount.measures(faces, labels)
    assert len(parts.bowtie_vertices) == expected["bowtie_count"] == parts.bowtie_counts.sum()
    assert parts.edge_counts.sum() == 2 * expected["boundary_edge_count"]
    cut = {edge for edge, users in recount.edge_faces(faces).items() if np.ptp(labels[users]) > 0}
    assert {tuple(sorted(edge)) for edge in parts.boundary_edges.tolist()} == cut
    assert len(parts.boundary_edges) == len(cut)
    assert parts.triangle_counts.tolist() == expected["submesh_triangles"].tolist()
    vertex_counts = [len(np.unique(faces[labels == label])) for label in range(k)]
    assert parts.vertex_counts.tolist() == vertex_counts
    assert parts.shared_memory_bytes == max(
        VERTEX_BYTES * v + TRIANGLE_BYTES * t
        for v, t in zip(vertex_counts, parts.triangle_counts, strict=True)
    )


def test_anatomy_of_two_triangles_that_touch_in_a_vertex():
    # Opposite triangles of an octahedron's upper half share the apex only: one bowtie there.
    _, faces = octahedron()
    labels = np.array([0, 1, 0, 1, 1, 1, 1, 1], dtype=np.int32)
    parts = anatomy(faces, build_dual_graph(faces), labels, 2)
    assert parts.bowtie_vertices.tolist() == [4, 4]  # once for each of the two sub-meshes
    assert parts.bowtie_counts.tolist() == [1, 1]
    assert parts.edge_counts.tolist() == [6, 6]


@pytest.mark.parametrize("name", ["pinched spheres", "touching discs", "klein bottle", "soup"])
def test_anatomy_of_any_surface_equals_the_judges(name):
    _, faces = SURFACES[name].make()
    labels = np.random.default_rng(3).integers(0, 6, size=len(faces)).astype(np.int32)
    parts = anatomy(faces, build_dual_graph(faces), labels, 6)
    verdict = Judge(faces).judge(labels, 6)
    assert len(parts.bowtie_vertices) == verdict.bowtie_count == parts.bowtie_counts.sum()
    assert len(parts.boundary_edges) == verdict.boundary_edge_count
    assert parts.vertex_counts.tolist() == [len(np.unique(faces[labels == i])) for i in range(6)]


def test_every_row_equals_an_independent_recount(evaluation):
    rows = results(evaluation / "out")
    assert len(rows) == 2 * 2 * len(RUN_METHODS)
    for row in rows:
        assert row["status"] == "done"
        with np.load(evaluation / "out" / "labels" / f"{row['mesh']}.npz") as arrays:
            faces = arrays["faces"]
        labels = np.load(evaluation / "out" / "labels" / row["labels"])
        expected = recount.measures(faces, labels)
        for key in set(expected) & set(row):
            assert row[key] == pytest.approx(expected[key], rel=1e-12), key
        assert row["boundary_edges_over_hexagonal"] == pytest.approx(
            expected["boundary_edge_count"] / (math.sqrt(6 * 512 * row["submesh_count"]) / 2)
        )
        assert row["empty_submesh_count"] == 0


def test_each_run_of_ours_is_of_a_mesh_that_is_forgotten_before_the_clock_starts(monkeypatch):
    events = []
    for owner, function in (
        (time, "perf_counter"),
        (api, "forget_prepared_mesh"),
        (api, "segment"),
    ):
        original = getattr(owner, function)

        def recorded(*arguments, original=original, function=function, **options):
            events.append(function)
            return original(*arguments, **options)

        monkeypatch.setattr(owner, function, recorded)
    vertices, faces = octahedron()
    for k in (3, 4):
        METHODS["fast_draft"].run(vertices, faces, k, 0, None)
    assert events == ["forget_prepared_mesh", "perf_counter", "segment", "perf_counter"] * 2


def test_metis_rows_equal_a_direct_call(evaluation):
    pymetis = pytest.importorskip("pymetis")
    for row in results(evaluation / "out"):
        if row["method"] != "metis_kway":
            continue
        with np.load(evaluation / "out" / "labels" / f"{row['mesh']}.npz") as arrays:
            neighbours = build_dual_graph(arrays["faces"]).neighbours
        direct = pymetis.part_graph(
            row["submesh_count"],
            neighbours.tolist(),
            recursive=False,
            options=pymetis.Options(contig=1),
        )
        assert row["boundary_edge_count"] == direct.edge_cuts


def test_same_inputs_give_the_same_rows_except_times(evaluation, tmp_path):
    plan = Plan(COUNTS, RUN_METHODS, seed=0, seed_count=1, all_pairs_limit=ALL_PAIRS_LIMIT)
    sources = inputs.collect([str(evaluation / "in")])
    again, failures = runner.evaluate(sources, plan, tmp_path, lambda *_: None)
    assert failures == []
    without_times = [
        [{key: value for key, value in row.items() if key not in TIMES} for row in rows]
        for rows in (results(evaluation / "out"), again)
    ]
    assert without_times[0] == without_times[1]


@pytest.fixture(scope="module")
def grown(tmp_path_factory):
    """The row of region growing on one mesh, and its folder, by first seed and number of seeds."""
    folder = tmp_path_factory.mktemp("grown")
    write_inputs(folder / "in")
    sources = inputs.collect([str(folder / "in" / "first.ply")])

    @functools.cache
    def run(seed: int, seed_count: int) -> tuple[dict, Path]:
        output = folder / f"{seed_count} from {seed}"
        plan = Plan((16,), ("region_growing",), seed, seed_count, all_pairs_limit=0)
        ((row,), _) = runner.evaluate(sources, plan, output, lambda *_: None)
        return row, output

    return run


@pytest.mark.parametrize("seed_count", [2, 3])
def test_of_several_seeds_the_row_is_the_run_with_the_median_boundary(grown, seed_count):
    single = [grown(seed, 1)[0] for seed in range(4, 4 + seed_count)]
    single.sort(key=lambda row: row["boundary_edge_count"])
    assert single[0]["boundary_edge_count"] < single[1]["boundary_edge_count"]
    assert [row["valid_run_count"] for row in single] == [0] * seed_count
    several, output = grown(4, seed_count)
    assert several["run_count"] == seed_count
    # The second of three, the first of two.
    median = single[seed_count - 2]
    for key in set(median) - {*TIMES, "run_count"}:
        assert several[key] == median[key], key
    with np.load(output / "labels" / "first.npz") as arrays:
        labels = np.load(output / "labels" / several["labels"])
        expected = recount.measures(arrays["faces"], labels)
    assert several["boundary_edge_count"] == expected["boundary_edge_count"]


def test_of_several_seeds_the_time_is_the_median_of_all(tmp_path, monkeypatch):
    vertices, faces = octahedron()
    labels, times = np.repeat([0, 1], 4), {5: 3.0, 6: 1.0, 7: 2.0}
    fake = replace(
        METHODS["metis_kway"], run=lambda _, __, k, seed, graph: Outcome(labels, times[seed])
    )
    monkeypatch.setitem(METHODS, "metis_kway", fake)
    (tmp_path / "labels").mkdir()
    job = {"name": "m", "folder": tmp_path, "seed": 5, "seed_count": 3, "all_pairs_limit": 0}
    row = worker.result(vertices, faces, build_dual_graph(faces), job, 2, "metis_kway")
    assert (row["seconds"], row["run_count"]) == (2.0, 3)
    # All have the same boundary, so the run that is shown, the second one, took another time.
    assert row["seed"] == 6


def test_empty_submeshes_count_in_the_balance():
    vertices, faces = api.TETRAHEDRON
    outcome = Outcome(np.array([0, 0, 1, 1]), 0.0)
    row = worker.judged(vertices, faces, build_dual_graph(faces), outcome, 3)
    assert (row["min_submesh_triangles"], row["max_triangle_count_difference"]) == (0, 2)
    assert row["coefficient_of_variation"] == pytest.approx(np.sqrt(0.5))
    assert row["empty_submesh_count"] == 1


def test_csv_and_json_agree(evaluation):
    with (evaluation / "out" / "results.csv").open(newline="") as stream:
        table = list(csv.DictReader(stream))
    rows = results(evaluation / "out")
    assert len(table) == len(rows)
    for line, row in zip(table, rows, strict=True):
        assert line == {key: str(row[key]) for key in line}


def test_report_is_one_file_that_needs_nothing_else(evaluation):
    text = (evaluation / "out" / "report.html").read_text()
    assert_links_lead_somewhere(text)
    for link in ('src="http', 'href="http', 'src="/', "@import", "url(http"):
        assert link not in text
    rows = re.findall('<tr class="(.*?)" data-mesh="(.*?)" data-method=".*?" data-k="(.*?)"', text)
    assert len(rows) == text.count('<tr class="') == 2 * 2 * len(RUN_METHODS)
    cases = [row[1:] for row in rows]
    assert [row[1:] for row in rows if "first" in row[0].split()] == list(dict.fromkeys(cases))
    assert text.count('src="data:image/png;base64,') == 2 * 2 * len(RUN_METHODS)
    environment = json.loads((evaluation / "out" / "results.json").read_text())["environment"]
    assert {"command", "seed", "commit", "pymetis", "processor"} <= set(environment)
    folders = f"{evaluation / 'in'} -o {evaluation / 'out'}"
    command = f"spheroseg evaluate {folders} --methods {','.join(RUN_METHODS)} -k 5 16"
    assert environment["command"] == command
    assert command in text
    assert environment["seed"] == "0"
    threads = f"{len(os.sched_getaffinity(0))} for our methods, 1 for the others"
    assert environment["threads"] == threads
    assert f"Threads: {threads}." in text


def test_the_pictures_of_each_case_stand_below_its_name_with_their_numbers(evaluation):
    expected = {}
    for row in results(evaluation / "out"):
        assert row["bowtie_count"] == 0
        caption = f"{METHODS[row['method']].title}: {row['boundary_edge_count']} boundary edges"
        case = f"{row['mesh']}, k = {row['submesh_count']}"
        expected.setdefault(case, []).append(caption)
    text = html.unescape((evaluation / "out" / "report.html").read_text())
    galleries = re.findall('<h3>(.*?)</h3><div class="gallery">(.*?)</div>', text, re.DOTALL)
    assert [
        (case, re.findall("<figcaption>(.*?)</figcaption>", shown)) for case, shown in galleries
    ] == list(expected.items())


@pytest.mark.parametrize(
    ("bowties", "said"), [(0, ""), (1, ", 1 bowtie (red)"), (2, ", 2 bowties (red)")]
)
def test_a_caption_counts_the_bowties(bowties, said):
    row = {"method": "metis_kway", "boundary_edge_count": 1234, "bowtie_count": bowties}
    assert report._caption(row) == f"{METHODS['metis_kway'].title}: 1,234 boundary edges{said}"


def test_page_has_iterations_of_one_effort_per_mesh_and_the_folder_all(tmp_path):
    write_inputs(tmp_path / "in")
    methods = ("all_pairs", "fast_standard", "fast_high")
    first = tmp_path / "in" / "first.ply"
    assert evaluate(first, tmp_path / "out", methods=methods) == 0
    plots = list((tmp_path / "out" / "plots" / "iterations").glob("*.svg"))
    assert len(plots) == 2 * 3
    text = (tmp_path / "out" / "report.html").read_text()
    figures = text[text.index('id="iterations"') : text.index('id="memory"')]
    assert figures.count("<figure>") == 2
    assert "k = 16: Fast, standard" in figures
    assert "k = 16: Fast, high" not in figures
    assert "counts on a coarse version" in figures


def test_pictures_show_boundaries_and_red_bowties(tmp_path):
    image = pytest.importorskip("PIL.Image")
    vertices, faces = bumpy_sphere(2, 0)
    grey = np.full((len(faces), 3), 180, dtype=np.uint8)
    red = {}
    for k in (1, 12):
        labels = np.random.default_rng(0).integers(0, k, size=len(faces)).astype(np.int32)
        parts = anatomy(faces, build_dual_graph(faces), labels, k)
        pictures.draw(vertices, faces, grey, parts, tmp_path / "picture.png")
        pixels = np.asarray(image.open(tmp_path / "picture.png").convert("RGB")).astype(int)
        assert pixels.shape == (*pictures.SIZE[::-1], 3)
        red[k] = np.count_nonzero((pixels[..., 0] > 120) & (pixels[..., 1:].max(axis=2) < 60))
    assert red[1] == 0
    assert red[12] > 50
    assert [path.name for path in tmp_path.iterdir()] == ["picture.png"]


@pytest.mark.parametrize("size", [(1, 1, 1), (1, 6, 1), (5, 1, 1), (1, 1, 0), (0, 0, 0)])
def test_pictures_show_all_of_the_shape_and_little_else(tmp_path, size):
    image = pytest.importorskip("PIL.Image")

    vertices, faces = bumpy_sphere(2, 0)
    vertices = np.vstack((vertices * size + 3e5, [[1e9, 0, np.nan]]))
    labels = np.arange(len(faces), dtype=np.int32) % 2
    parts = anatomy(faces, build_dual_graph(faces), labels, 2)
    grey = np.full((len(faces), 3), 128, dtype=np.uint8)
    drawn = report._for_drawing(vertices, faces)
    pictures.draw(drawn, faces, grey, parts, tmp_path / "picture.png")

    pixels = np.asarray(image.open(tmp_path / "picture.png").convert("L"))
    rows, columns = np.nonzero(pixels < 250)
    if not any(size):
        assert len(rows) < 1000  # a point
        return
    first, last = (columns.min(), rows.min()), (columns.max(), rows.max())
    assert min(first) > 0
    assert all(end < whole - 1 for end, whole in zip(last, pictures.SIZE, strict=True))
    shares = [(b - a) / whole for a, b, whole in zip(first, last, pictures.SIZE, strict=True)]
    assert max(shares) > 0.8, shares


def test_meshes_of_like_names_keep_their_own_files(tmp_path):
    pytest.importorskip("pymetis")
    for name, seed in (("a/b.ply", 1), ("a_b.ply", 2)):
        (tmp_path / "in" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "in" / name).write_bytes(ply_bytes(*bumpy_sphere(2, seed)))
    output = tmp_path / "out"
    assert evaluate(tmp_path / "in", output, methods=("all_pairs", "metis_kway")) == 0
    assert {row["mesh"] for row in results(output)} == {"a/b", "a_b"}
    for row in results(output):
        with np.load(output / "labels" / f"{row['mesh']}.npz") as arrays:
            faces = arrays["faces"]
        labels = np.load(output / "labels" / row["labels"])
        edges = recount.measures(faces, labels)["boundary_edge_count"]
        assert edges == row["boundary_edge_count"]
    assert len(list((output / "pictures").rglob("*.png"))) == 8
    assert len(list((output / "plots" / "iterations").rglob("*.svg"))) == 4


def test_a_mesh_that_can_not_be_read_leaves_no_folder(tmp_path, capsys):
    path = tmp_path / "cut.ply"
    path.write_bytes(ply_bytes(*octahedron())[:-5])
    (tmp_path / "there").mkdir()
    for output in (tmp_path / "new" / "report", tmp_path / "there"):
        assert evaluate(path, output, methods=("all_pairs",)) == 2
        assert f"{path}: " in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == [path, tmp_path / "there"]


def test_meshes_of_any_size_are_shown_alike(tmp_path):
    vertices, faces = bumpy_sphere(1, 0)
    scales = {"one": 1.0, "large": 1e200, "small": 1e-310}
    for name, scale in scales.items():
        (tmp_path / f"{name}.ply").write_bytes(ply_bytes(vertices * scale, faces))
    meshes = [str(tmp_path / f"{name}.ply") for name in scales]
    arguments = ["evaluate", *meshes, "-o", str(tmp_path / "out"), "--methods", "all_pairs"]
    assert main([*arguments, "-k", *map(str, COUNTS)]) == 0
    page = (tmp_path / "out" / "report.html").read_text()
    shown = []
    for number, name in enumerate(scales):
        data = base64.b64decode(re.search(rf'id="positions-{number}"[^>]*>([^<]+)<', page)[1])
        positions = np.frombuffer(gzip.decompress(data), "<f4").reshape(-1, 3)
        picture = (tmp_path / "out" / "pictures" / f"{name}-k5-all_pairs.png").read_bytes()
        shown.append((positions, picture))
    one, *others = shown
    assert np.abs(one[0]).max() == 1
    for positions, picture in others:
        assert np.allclose(one[0], positions, rtol=0, atol=1e-6)
        assert picture == one[1]


def test_a_name_with_dollar_signs_is_no_formula():
    name = "price$_{1$"
    assert name in plots.iterations(ITERATIONS, name)
    assert name in plots.shared_memory(memory_rows(name, 1024), MEMORY_TITLES)


ITERATIONS = {
    "method": "fast_high",
    "details": {"boundary_edges_by_iteration": [9, 8], "seconds_by_iteration": [1.0, 1.0]},
}
MEMORY_TITLES = {"metis_kway": "METIS k-way", "fast_high": "Fast, high"}


def memory_rows(name: str, *sizes: int) -> list[dict]:
    return [
        {"mesh": name, "method": method, "shared_memory_bytes": size}
        for method, size in zip(MEMORY_TITLES, sizes, strict=False)
    ]


def test_long_names_leave_a_diagram_its_room():
    name = "scans/" + "2026/" * 40 + "head"
    # matplotlib warns where names take all the room, and a warning fails a test.
    svg = plots.shared_memory(memory_rows(name, 1024, 2048), MEMORY_TITLES)
    assert "head" in svg
    assert name not in svg
    svg = plots.iterations(ITERATIONS, f"{name}, k = 7: Fast, high")
    assert "head, k = 7: Fast, high" in svg
    assert name not in svg


def test_letters_that_matplotlib_has_no_font_for_are_left_to_the_browser():
    name = "größe 网格"
    assert name in plots.iterations(ITERATIONS, name)  # a warning fails a test
    assert name in plots.shared_memory(memory_rows(name, 1024), MEMORY_TITLES)


def test_bars_of_like_memory_are_alike(monkeypatch):
    figures = []
    monkeypatch.setattr(plots, "_svg", figures.append)
    plots.shared_memory(memory_rows("m", 5000, 5050), MEMORY_TITLES)
    axis = figures[0].axes[0]
    figures[0].draw_without_rendering()
    short, tall = (bar.get_window_extent().y1 - axis.bbox.y0 for bar in axis.patches)
    assert 0.95 * tall < short < tall < axis.bbox.height
    # Nothing lies on them.
    assert axis.get_legend().get_window_extent().x0 >= axis.bbox.x1


def test_commit_is_that_of_this_package_and_not_of_a_repository_around_it(tmp_path, monkeypatch):
    git = ["git", "-C", str(tmp_path), "-c", "user.name=a", "-c", "user.email=a@example.org"]
    for command in (["init", "-q"], ["commit", "-q", "--allow-empty", "-m", "other"]):
        subprocess.run([*git, *command], check=True)
    installed = tmp_path / "venv" / "environment.py"
    installed.parent.mkdir()
    installed.touch()
    monkeypatch.setattr(environment, "__file__", str(installed))
    assert environment.surroundings()["commit"] == "unknown (not a checkout)"
    subprocess.run([*git, "add", "."], check=True)
    subprocess.run([*git, "commit", "-q", "-m", "ours"], check=True)
    head = subprocess.check_output([*git, "rev-parse", "--short=12", "HEAD"], text=True).strip()
    assert environment.surroundings()["commit"] == head


def test_all_pairs_is_left_out_above_its_limit_and_says_so(tmp_path):
    write_inputs(tmp_path / "in")
    options = ("--all-pairs-limit", "511")
    two = ("all_pairs", "metis_kway")
    assert evaluate(tmp_path / "in", tmp_path / "out", *options, methods=two) == 0
    left_out = [row for row in results(tmp_path / "out") if row["status"] == "left out"]
    assert {row["method"] for row in left_out} == {"all_pairs"}
    assert len(left_out) == 4
    text = (tmp_path / "out" / "report.html").read_text()
    assert "<summary>Left out: 4 cases</summary>" in text
    assert "<li>first, k = 5, 16: All pairs (above 511 triangles)</li>" in text
    # The table holds what was done, here METIS alone.
    assert text.count('<tr class="') == 4
    assert 'data-method="all_pairs"' not in text


def test_more_submeshes_than_triangles_are_left_out(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "small.ply").write_bytes(ply_bytes(*octahedron()))
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=("region_growing",)) == 0
    status = {(row["submesh_count"], row["status"]) for row in results(tmp_path / "out")}
    assert status == {(5, "done"), (16, "left out")}
    text = (tmp_path / "out" / "report.html").read_text()
    assert "1 mesh, 1 method, k = 5, 16" in text
    assert "<summary>Left out: 1 case</summary>" in text
    assert "k = 16: Region growing (only 8 triangles)" in text


def test_k_is_200_by_default_and_the_page_is_named_at_the_end(tmp_path, capsys):
    write_inputs(tmp_path / "in")
    arguments = ["evaluate", str(tmp_path / "in" / "first.ply"), "-o", str(tmp_path / "out")]
    assert main([*arguments, "--methods", "fast_draft"]) == 0
    assert {row["submesh_count"] for row in results(tmp_path / "out")} == {200}
    assert capsys.readouterr().out == f"{tmp_path / 'out' / 'report.html'}\n"


def test_one_triangle_is_one_triangle(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "one.ply").write_bytes(ply_bytes(np.eye(3), np.array([[0, 1, 2]])))
    methods = ("fast_draft", "region_growing")
    arguments = ["evaluate", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "-k", "1", "2"]
    assert main([*arguments, "--methods", ",".join(methods)]) == 0
    text = (tmp_path / "out" / "report.html").read_text()
    # A comma is in the title of a method already.
    assert "<li>one, k = 2: Fast, draft; Region growing (only 1 triangle)</li>" in text


def test_there_is_no_view_where_every_mesh_is_too_large_for_it(tmp_path):
    write_inputs(tmp_path / "in")
    first = tmp_path / "in" / "first.ply"
    for limit, is_there in (("511", False), ("512", True)):
        options = ("--viewer-limit", limit)
        assert evaluate(first, tmp_path / "out", *options, methods=("all_pairs",)) == 0
        text = (tmp_path / "out" / "report.html").read_text()
        assert_links_lead_somewhere(text)
        assert ("<canvas" in text) == is_there
        assert ("Too large for this page: first (pictures below)." in text) != is_there


def test_diagrams_are_of_the_largest_k_that_was_done(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "small.ply").write_bytes(ply_bytes(*octahedron()))
    methods = ("all_pairs", "region_growing")
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=methods) == 0
    text = (tmp_path / "out" / "report.html").read_text()
    for diagram in (tmp_path / "out" / "plots").rglob("*.svg"):
        assert diagram.read_text().startswith("<svg")
        assert diagram.read_text() in text
    assert "At k = 5, of all pairs" in text
    assert "needs most, at k = 5." in text
    assert "small, k = 5: All pairs" in text[text.index('id="iterations"') :]


def test_sections_without_data_are_not_on_the_page(tmp_path):
    write_inputs(tmp_path / "in")
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=("metis_kway",)) == 0
    text = (tmp_path / "out" / "report.html").read_text()
    assert "iterations" not in re.findall('id="(.*?)"', text)
    assert_links_lead_somewhere(text)
    failed = {"mesh": "m", "triangle_count": 8, "submesh_count": 2, "method": "metis_kway"}
    failed |= {"mesh_file": "m.ply", "status": "failed", "error": "broken"}
    folder = tmp_path / "failed"
    folder.mkdir()
    facts = {"threads": "1"}
    text = report.write_report(folder, [failed], [], facts, 1000).read_text()
    assert_links_lead_somewhere(text)
    assert re.findall('<h2 id="(.*?)"', text) == ["balance", "methods", "made"]
    assert not (folder / "plots").exists()


def assert_links_lead_somewhere(page: str) -> None:
    targets = re.findall('<a href="#(.*?)"', page)
    assert len(targets) == page.count("<h2")
    for target in targets:
        assert f'id="{target}"' in page


def files_below(folder: Path) -> set[str]:
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_a_second_report_takes_the_place_of_the_first(tmp_path, capsys):
    (tmp_path / "in" / "sub").mkdir(parents=True)
    for name in ("one.ply", "sub/two.ply"):
        (tmp_path / "in" / name).write_bytes(ply_bytes(*octahedron()))
    output = tmp_path / "out"
    assert evaluate(tmp_path / "in", output, methods=("all_pairs", "region_growing")) == 0
    first = files_below(output)
    assert {"labels/sub/two-k5-all_pairs.npy", "pictures/one-k5-region_growing.png"} < first
    assert {"plots/iterations/one-k5-all_pairs.svg", "results.json", "report.html"} < first
    assert set(json.loads((output / ".report").read_text())) > first - {".report", ".report.lock"}
    page = (output / "report.html").read_bytes()
    (output / "labels" / "notes.txt").write_text("mine")

    # A command that can run nothing leaves the report as it is.
    again = tmp_path / "in" / "one.ply"
    nothing = ["evaluate", str(again), "-o", str(output), "-k", "16", "--methods", "region_growing"]
    assert main(nothing) == 2
    assert "no method could run" in capsys.readouterr().err
    assert files_below(output) == first | {"labels/notes.txt"}
    assert (output / "report.html").read_bytes() == page

    assert evaluate(again, output, methods=("region_growing",)) == 0
    assert files_below(output) == {
        ".report",
        ".report.lock",
        "labels/notes.txt",
        "labels/one-k5-region_growing.npy",
        "labels/one.npz",
        "pictures/one-k5-region_growing.png",
        "plots/quality-and-time.svg",
        "plots/shared-memory.svg",
        "report.html",
        "results.csv",
        "results.json",
    }
    assert not (output / "labels" / "sub").exists()


def test_a_report_replaces_no_file_of_others(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "one.ply").write_bytes(ply_bytes(*octahedron()))
    (tmp_path / "results.csv").write_text("mine")
    assert evaluate(tmp_path / "in", tmp_path, methods=("region_growing",)) == 2
    assert f"{tmp_path / 'results.csv'}: is there already" in capsys.readouterr().err
    assert files_below(tmp_path) == {"in/one.ply", "results.csv"}


def test_a_second_evaluation_in_a_folder_is_refused_while_the_first_one_runs(tmp_path, capsys):
    write_inputs(tmp_path / "in")
    output = tmp_path / "out"
    with report_folder.prepared(output, ["report.html"]):
        (output / "report.html").write_text("of the first")
        assert evaluate(tmp_path / "in", output, methods=("region_growing",)) == 2
        assert capsys.readouterr().err == (
            f"spheroseg evaluate: {output}: another evaluation writes there; wait until it is "
            f"done, or name another folder (process {os.getpid()} on {socket.gethostname()})\n"
        )
        assert files_below(output) == {".report", ".report.lock", "report.html"}
        assert json.loads((output / ".report").read_text()) == ["report.html"]
    assert evaluate(tmp_path / "in", output, methods=("region_growing",)) == 0
    assert "region_growing" in (output / "report.html").read_text()


def test_a_list_of_files_outside_the_folder_removes_none(tmp_path):
    (tmp_path / "mine").touch()
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / ".report").write_text(json.dumps(["../mine", str(tmp_path / "mine"), "gone"]))
    (folder / ".report.lock").touch()
    report_folder.keep_only(folder, [])
    assert (tmp_path / "mine").exists()
    assert files_below(folder) == set()


def test_where_nothing_can_run_no_report_is_written(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "small.ply").write_bytes(ply_bytes(*octahedron()))
    command = ["evaluate", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "-k", "16", "32"]
    assert main([*command, "--methods", "region_growing"]) == 2
    assert "small, k = 16, region_growing: only 8 triangles" in capsys.readouterr().err
    assert not files_below(tmp_path / "out")


def test_method_that_fails_costs_a_line_and_exit_code_one(tmp_path, capsys, monkeypatch):
    write_inputs(tmp_path / "in")
    # Found before the installed package, also in the process of each mesh.
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "pymetis.py").write_text("raise ImportError('not there')\n")
    monkeypatch.setenv("PYTHONPATH", str(broken))
    methods = ("metis_kway", "region_growing")
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=methods) == 1
    assert "failed: first, k = 5, metis_kway: this baseline needs" in capsys.readouterr().err
    status = {(row["method"], row["status"]) for row in results(tmp_path / "out")}
    assert status == {("metis_kway", "failed"), ("region_growing", "done")}
    assert "failed: this baseline needs" in (tmp_path / "out" / "report.html").read_text()


# Before it fails, each of them works on the mesh of the warm-up.
BROKEN_CALLS = {
    "abort": ("import os; os.abort()", "the process was ended by signal 6"),
    "memory": ("raise MemoryError", "MemoryError"),
    "labels": ("return GraphPartition([-1] * (len(graph.starts) - 1))", "labels"),
}


@pytest.mark.parametrize("kind", BROKEN_CALLS)
def test_method_that_breaks_down_costs_only_its_own_rows(kind, tmp_path, capsys, monkeypatch):
    failure, reason = BROKEN_CALLS[kind]
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "one.ply").write_bytes(ply_bytes(*bumpy_sphere(2, 1)))
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "pymetis.py").write_text(
        "from collections import namedtuple\n"
        "CSRAdjacency = namedtuple('CSRAdjacency', 'starts adjacent')\n"
        "GraphPartition = namedtuple('GraphPartition', 'vertex_part')\n"
        "def Options(**_): return None\n"
        "def part_graph(k, graph, **_):\n"
        "    if len(graph.starts) == 5: return GraphPartition([0, 1, 1, 1])\n"
        f"    {failure}\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path / "broken"))
    methods = ("region_growing", "metis_kway", "fast_draft")
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=methods) == 1
    rows = results(tmp_path / "out")
    assert [(row["submesh_count"], row["method"]) for row in rows] == [
        (k, method) for k in (5, 16) for method in methods
    ]
    failed = [row for row in rows if row["status"] == "failed"]
    assert [row["method"] for row in failed] == ["metis_kway"] * 2
    assert all(row["status"] == "done" for row in rows if row not in failed)
    said = capsys.readouterr().err
    for row in failed:
        assert reason in row["error"]
        assert f"failed: one, k = {row['submesh_count']}, metis_kway: {row['error']}" in said
        assert row["triangle_count"] == 128


def test_methods_that_do_not_take_a_mesh_are_left_out_with_the_reason(tmp_path, capsys):
    (tmp_path / "in").mkdir()
    for name in ("plane with holes", "50 spheres"):
        (tmp_path / "in" / f"{name}.ply").write_bytes(ply_bytes(*SURFACES[name].make()))
    methods = ("all_pairs", "fast_draft", "metis_kway", "metis_recursive")
    assert evaluate(tmp_path / "in", tmp_path / "out", "-k", "20", "60", methods=methods) == 0
    assert "failed" not in capsys.readouterr().err
    left_out = {
        (row["mesh"], row["submesh_count"], row["method"]): row["error"]
        for row in results(tmp_path / "out")
        if row["status"] != "done"
    }
    assert set(left_out) == {
        ("50 spheres", 20, "fast_draft"),
        *(("50 spheres", k, method) for k in (20, 60) for method in ("all_pairs", "metis_kway")),
        *(("plane with holes", k, "all_pairs") for k in (20, 60)),
    }
    assert "found 264 open border edges" in left_out["plane with holes", 20, "all_pairs"]
    assert "of one component only" in left_out["50 spheres", 60, "metis_kway"]
    assert "found 50 components" in left_out["50 spheres", 20, "fast_draft"]
    text = (tmp_path / "out" / "report.html").read_text()
    assert "<summary>Left out: 7 cases</summary>" in text


def test_too_little_memory_is_a_failure(monkeypatch):
    vertices, faces = octahedron()

    def refuse(*_):
        raise InputError("There is not enough memory for this mesh")

    monkeypatch.setitem(METHODS, "metis_kway", replace(METHODS["metis_kway"], run=refuse))
    job = {"name": "m", "folder": "unused", "seed": 0, "seed_count": 1, "all_pairs_limit": 99}
    with pytest.raises(InputError, match="not enough memory"):
        worker.result(vertices, faces, build_dual_graph(faces), job, 2, "metis_kway")


def test_broken_mesh_costs_a_line_and_exit_code_one(tmp_path, capsys):
    write_inputs(tmp_path / "in")
    (tmp_path / "in" / "broken.ply").write_text("no mesh")
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=("metis_kway",)) == 1
    assert "broken.ply: has no line 'end_header'" in capsys.readouterr().err
    assert {row["mesh"] for row in results(tmp_path / "out")} == {"first", "second"}


@pytest.mark.parametrize("names", [["x"], ["x", "y"]])
def test_one_mesh_that_can_not_be_read_is_one_line(names, tmp_path, capsys):
    (tmp_path / "in").mkdir()
    for name in names:
        (tmp_path / "in" / f"{name}.ply").write_text("no mesh")
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=("metis_kway",)) == 2
    lines = capsys.readouterr().err.splitlines()
    said = [line.partition("has no line 'end_header'")[0] for line in lines]
    of_mesh = [f"{tmp_path / 'in' / name}.ply: " for name in names]
    if len(names) == 1:
        assert said == [f"spheroseg evaluate: {of_mesh[0]}"]
    else:
        failed = [f"failed: {line}" for line in of_mesh]
        assert said == [*failed, "spheroseg evaluate: no mesh could be evaluated"]
    assert not files_below(tmp_path / "out")


def test_a_mesh_whose_name_has_two_lines_fails_in_one(tmp_path, capsys):
    mesh = tmp_path / "two\nlines.obj"
    mesh.write_text("no mesh")
    assert main(["evaluate", str(mesh), "-o", str(tmp_path / "out"), "-k", "2"]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert said.startswith(f"spheroseg evaluate: {tmp_path}/two lines.obj: ")
    assert said.count("lines.obj") == 1


def test_report_lists_the_meshes_that_failed_with_the_reason(tmp_path):
    write_inputs(tmp_path / "in")
    (tmp_path / "in" / "<b>.ply").write_text("no mesh")
    output = tmp_path / "out"
    assert evaluate(tmp_path / "in", output, methods=("metis_kway",)) == 1
    (failed,) = json.loads((output / "results.json").read_text())["failed_meshes"]
    path = str(tmp_path / "in" / "<b>.ply")
    assert [failed[name] for name in ("mesh", "mesh_file", "path")] == ["<b>", "<b>.ply", path]
    assert failed["error"].startswith("has no line 'end_header'")
    with (output / "results.csv").open(newline="") as stream:
        *others, line = csv.DictReader(stream)
    assert {row["status"] for row in others} == {"done"}
    assert {name: value for name, value in line.items() if value} == {
        "mesh": "<b>",
        "mesh_file": "<b>.ply",
        "status": "failed",
        "error": failed["error"],
    }
    page = (output / "report.html").read_text()
    listed = re.search('<details id="failed-meshes".*?</details>', page, re.DOTALL)[0]
    assert "Failed: 1 mesh<" in listed
    assert "<li>&lt;b&gt; (has no line &#39;end_header&#39;" in listed


def test_a_found_name_that_is_not_utf_8_costs_a_line_and_exit_code_one(tmp_path, capsys):
    write_inputs(tmp_path / "in")
    (tmp_path / "in" / os.fsdecode(b"bad\xff.ply")).touch()
    assert evaluate(tmp_path / "in", tmp_path / "out", methods=("metis_kway",)) == 1
    assert capsys.readouterr().err == (
        f"failed: {tmp_path}/in/bad\\xff.ply: the name is not UTF-8; rename the file or folder\n"
    )


def test_full_disk_is_one_line_that_names_the_file(tmp_path, small_disk, capsys):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "large.ply").write_bytes(ply_bytes(*bumpy_sphere(6, 0)))
    assert evaluate(tmp_path / "in", small_disk / "out", methods=("metis_kway",)) == 2
    said = capsys.readouterr().err
    assert f"no room left on the disk for '{small_disk / 'out' / 'labels' / 'large.npz'}'" in said
    assert not list((small_disk / "out").rglob("*.np?"))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-k", "0"], "-k must be 1 or more, got 0"),
        (["--seed", "-1"], "--seed must be 0 or more"),
        (["--seeds", "0"], "--seeds must be 1 or more"),
        (["--all-pairs-limit", "-1"], "--all-pairs-limit must be 0 or more, got -1"),
        (["--viewer-limit", "-1"], "--viewer-limit must be 0 or more, got -1"),
        (["--seed", "2147483647", "--seeds", "2"], "seed must fit into 32 bits, got 2147483648"),
        (["-k", "2147483648"], "submesh_count must fit into 32 bits, got 2147483648"),
        (["--methods", "magic"], "there is no method 'magic'"),
    ],
)
def test_bad_options_are_refused_before_any_work(options, message, tmp_path, capsys):
    write_inputs(tmp_path / "in")
    assert main(["evaluate", str(tmp_path / "in"), "-o", str(tmp_path / "out"), *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_paper_numbers_stand_beside_meshes_of_the_same_name_and_count():
    human = paper.lookup("human.ply", 20096, 200, "all_pairs")
    assert (human.boundary_edge_count, human.bowtie_count) == (3041, 0)
    assert paper.lookup("Cow.obj", 5804, 200, "metis_kway").bowtie_count == 19
    rock = paper.lookup("rock.off", 558976, 200, "region_growing")
    assert rock.max_triangle_count_difference == 7301
    assert paper.lookup("human.ply", 20098, 200, "all_pairs") is None
    assert paper.lookup("human.ply", 20096, 100, "all_pairs") is None
    assert paper.lookup("human.ply", 20096, 200, "fast_high") is None


def test_paper_numbers_stand_beside_meshes_of_folders_and_lists_and_no_others(tmp_path):
    cow = PYMESHLAB_MESHES[0]
    (tmp_path / "in" / "paper").mkdir(parents=True)
    (tmp_path / "in" / "paper" / "cow.obj").write_bytes(cow.read_bytes())
    (tmp_path / "list.csv").write_text("mesh,k\nin/paper/cow.obj,200\n")
    for source, k, name in (
        ("in", 200, "paper/cow"),
        ("list.csv", 200, "cow-k200"),
        ("in", 199, "paper/cow"),
    ):
        output = tmp_path / f"report of {source} for {k}"
        command = ["evaluate", str(tmp_path / source), "-o", str(output), "-k", str(k)]
        assert main([*command, "--methods", "metis_kway"]) == 0
        (row,) = results(output)
        assert (row["mesh"], row["mesh_file"]) == (name, "cow.obj")
        page = (output / "report.html").read_text()
        assert ('<td class="paper">1,631</td>' in page) == (k == 200)
        # Without numbers there are neither columns for them nor words about them.
        assert page.count('<th class="paper">') == (4 if k == 200 else 0)
        assert ("repeat the paper's Table 1" in page) == (k == 200)


def row(method: str, edges: int, **changes) -> dict:
    """A valid result of 6 * 16 triangles and k = 4, for which the bound is 24."""
    return {
        "mesh": "m",
        "triangle_count": 96,
        "submesh_count": 4,
        "method": method,
        "status": "done",
        "run_count": 1,
        "valid_run_count": 1,
        "seconds": 96e-6,
        "boundary_edge_count": edges,
        "boundary_edges_over_hexagonal": edges / 24,
        "max_triangle_count_difference": 1,
        "min_submesh_triangles": 1,
        "disconnected_submesh_count": 0,
        "bowtie_count": 0,
    } | changes


def test_summary_compares_with_the_better_metis_mode():
    numbers = summary.summary(
        [
            row("fast_high", 90),
            row("metis_kway", 100, valid_run_count=0),
            row("metis_recursive", 120, run_count=3, valid_run_count=2),
            row("metis_limit", 75),
        ]
    )
    assert numbers[0] == {
        "method": "fast_high",
        "result_count": 1,
        "valid_count": 1,
        "boundary_edges_over_hexagonal": pytest.approx(90 / 24),
        "microseconds_per_triangle": pytest.approx(1),
        "boundary_over_metis": pytest.approx(0.9),
        "boundary_over_metis_case_count": 1,
        "boundary_over_metis_limit": pytest.approx(1.2),
        "boundary_over_metis_limit_case_count": 1,
    }
    lines = summary.sentences(numbers)
    assert lines[0].startswith("Fast, high: 1 of 1 results")
    assert "on average 0.900 times that of METIS (the better of k-way and recursive" in lines[0]
    assert "1.200 times that of METIS with the limit" in lines[0]
    assert lines[1].startswith("METIS k-way: 0 of 1")
    assert lines[2].startswith("METIS recursive: 2 of 3")
    assert "times that" not in lines[1] + lines[2]


def test_one_result_is_plotted_whatever_its_time():
    # With these the logarithm's rounding made an axis of no length, and a division by it.
    row = {
        "method": "fast_high",
        "seconds": 5.1380740783157756e-05,
        "triangle_count": 8,
        "boundary_edges_over_hexagonal": 0.5,
        "run_count": 1,
        "valid_run_count": 1,
    }
    titles = {"fast_high": "Title of the method"}
    assert "Title of the method" in plots.quality_and_time([row], titles)


def test_what_has_no_boundary_counts_in_no_mean():
    both = [row(method, 50) for method in summary.METIS_MODES]
    whole = [row("fast_high", 0, mesh="n", seconds=1.0), row("fast_draft", 0)]
    draft, fast, *_ = summary.summary([row("fast_high", 25), *whole, *both])
    assert (fast["method"], fast["result_count"]) == ("fast_high", 2)
    assert fast["boundary_edges_over_hexagonal"] == pytest.approx(25 / 24)
    assert fast["microseconds_per_triangle"] == pytest.approx(1)
    assert fast["boundary_over_metis"] == pytest.approx(0.5)
    assert (draft["method"], draft["valid_count"]) == ("fast_draft", 1)
    assert draft["boundary_edges_over_hexagonal"] is None
    assert draft["microseconds_per_triangle"] is None
    assert draft["boundary_over_metis_case_count"] == 0


def test_without_any_boundary_there_is_no_diagram_of_quality(tmp_path):
    write_inputs(tmp_path / "in")
    arguments = ["evaluate", str(tmp_path / "in" / "first.ply"), "-o", str(tmp_path / "out")]
    assert main([*arguments, "-k", "1", "--methods", "region_growing"]) == 0
    text = (tmp_path / "out" / "report.html").read_text()
    assert_links_lead_somewhere(text)
    assert "needs most, at k = 1." in text
    assert 'id="time"' not in text
    plots_written = [path.name for path in (tmp_path / "out" / "plots").iterdir()]
    assert plots_written == ["shared-memory.svg"]


def test_marks_of_a_legend_lie_apart(monkeypatch):
    figures = []
    monkeypatch.setattr(plots, "_svg", figures.append)
    titles = {name: method.title for name, method in METHODS.items()}
    plots.quality_and_time([row(method, 50) for method in METHODS], titles)
    (figure,) = figures
    figure.draw_without_rendering()
    (axis,) = figure.axes
    places = [text.get_window_extent().y0 for text in axis.get_legend().get_texts()]
    heights = [
        mark.get_paths()[0].get_extents(Affine2D(mark.get_transforms()[0])).height
        for mark in axis.get_legend().legend_handles
    ]
    assert len(places) == len(heights) == len(METHODS)
    gaps = -np.diff(places) - (np.array(heights[1:]) + heights[:-1]) / 2
    assert gaps.min() > 1


def test_summary_is_of_geometric_means_over_cases_that_all_have_done():
    both = [row(method, 50) for method in summary.METIS_MODES]
    one = [row("metis_kway", 10, mesh="n"), row("metis_recursive", 0, mesh="n", status="failed")]
    mine = [row("fast_high", 25), row("fast_high", 100, mesh="n", seconds=4 * 96e-6)]
    numbers = summary.summary([*mine, *both, *one])[0]
    assert numbers["boundary_over_metis"] == pytest.approx(0.5)
    assert numbers["boundary_over_metis_case_count"] == 1
    assert numbers["boundary_edges_over_hexagonal"] == pytest.approx(50 / 24)
    assert numbers["microseconds_per_triangle"] == pytest.approx(2)
    assert (numbers["boundary_over_metis_limit"], numbers["result_count"]) == (None, 2)


def test_numbers_in_short_are_in_the_results(evaluation):
    document = json.loads((evaluation / "out" / "results.json").read_text())
    assert [one["method"] for one in document["summary"]] == list(RUN_METHODS)
    assert document["summary"] == summary.summary(document["rows"])
    page = (evaluation / "out" / "report.html").read_text()
    for line in summary.sentences(document["summary"]):
        assert f"<li>{line}</li>" in page
    told = (REPOSITORY / "docs" / "evaluation.md").read_text()
    for key in document["summary"][0]:
        assert f"`{key}`" in told


@pytest.mark.parametrize(
    "fault",
    [
        {"max_triangle_count_difference": 2},
        {"min_submesh_triangles": 0},
        {"disconnected_submesh_count": 1},
        {"bowtie_count": 1},
    ],
)
def test_a_result_with_any_fault_is_not_valid(fault):
    assert judging.is_valid(row("metis_kway", 1))
    assert not judging.is_valid(row("metis_kway", 1, **fault))


def test_a_result_is_valid_that_is_as_balanced_as_can_be():
    verdict = Judge(np.array([[0, 1, 2], [3, 4, 5], [3, 5, 6], [3, 6, 7]])).judge([0, 1, 1, 1], 2)
    assert not judging.is_valid(vars(verdict))
    assert judging.is_valid(vars(verdict), best_difference=2)


def test_hexagonal_bound_is_the_boundary_of_hexagons_on_the_regular_mesh():
    # A hexagon of side s has 6 s^2 triangles and 6 s edges, each shared with another one.
    for side, k in ((1, 10), (4, 50)):
        assert judging.hexagonal_bound(k * 6 * side**2, k) == pytest.approx(k * 6 * side / 2)


def test_default_methods_exist_and_others_are_named():
    assert set(DEFAULT_METHODS) <= set(METHODS)
    assert chosen("metis_kway,all_pairs") == ["metis_kway", "all_pairs"]
    assert chosen("metis_kway, all_pairs ") == ["metis_kway", "all_pairs"]  # as --help lists them
    with pytest.raises(InputError, match="there is no method 'x'; choose from all_pairs"):
        chosen("x")


def test_each_method_has_its_own_colour_and_marker():
    assert plots.LOOKS.keys() == METHODS.keys()
    for one in zip(*plots.LOOKS.values(), strict=True):
        assert len(set(one)) == len(METHODS)


def test_a_method_has_the_same_colour_whatever_it_is_compared_with(monkeypatch):
    figures = []
    monkeypatch.setattr(plots, "_svg", figures.append)
    for titles in (MEMORY_TITLES, {"all_pairs": "All pairs"} | MEMORY_TITLES):
        plots.shared_memory(memory_rows("m", 1024, 2048), titles)
    alone, beside = ([bar.get_facecolor() for bar in figure.axes[0].patches] for figure in figures)
    assert alone == beside


def test_missing_packages_are_named_with_the_remedy(tmp_path, monkeypatch, capsys):
    write_inputs(tmp_path / "in")
    names = ("jinja2", "pyvista", "pymetis")
    for package in (*names, "kaminpar"):
        monkeypatch.setitem(sys.modules, package, None)
    methods = ["--methods", "fast_draft,metis_kway,metis_recursive"]
    assert evaluate(tmp_path / "in", tmp_path / "out", *methods) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert [f"needs the package '{name}'" in said for name in names] == [True] * 3
    assert "the method metis_kway needs" in said
    assert "'pip install jinja2 pyvista pymetis'" in said
    assert not (tmp_path / "out").exists()
    assert "pip install 'spheroseg[evaluate]'" in said


def test_the_extra_holds_all_that_the_methods_need():
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    extra = set(project["optional-dependencies"]["evaluate"])
    assert {baseline.package for baseline in BASELINES.values()} <= extra


def test_each_optional_package_is_in_the_extra_that_an_error_names():
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    for package, extra in packages.EXTRAS.items():
        assert any(package in requirement for requirement in extras[extra]), package
    assert packages.EXTRAS.keys() >= {baseline.package for baseline in BASELINES.values()}
