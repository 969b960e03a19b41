# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import errno
import math
import os
import shutil
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import recount
from processes import run_python
from shapes import octahedron, subdivided_sphere

pytest.importorskip("matplotlib")
pytest.importorskip("pymetis")
pytest.importorskip("kaminpar")
pytest.importorskip("mtkahypar")

import spheroseg
from spheroseg import api
from spheroseg.bench import __main__ as program
from spheroseg.bench import document, meshes, methods, records
from spheroseg.bench.meshes import subdivided
from spheroseg.bench.methods import MeshRuns
from spheroseg.bench.plan import SLOW_RIVALS, Plan, Run, sweep_counts
from spheroseg.bench.runner import row_of
from spheroseg.bench.statistics import (
    STAGES,
    Bar,
    Table,
    bars,
    fitted_exponent,
    submesh_count,
)
from spheroseg.bench.worker import perform
from spheroseg.evaluate import environment
from spheroseg.evaluate.judging import geometric_mean, is_valid
from spheroseg.ply import ply_bytes


def row(method: str, edges: int, seconds: float, **changes) -> dict:
    """A valid first call on a mesh of 12,800 triangles with k = 200."""
    return {
        "mesh": "ball",
        "triangle_count": 12_800,
        "submesh_count": 200,
        "method": method,
        "measurement": "first",
        "status": "done",
        "seconds": seconds,
        "boundary_edge_count": edges,
        "max_triangle_count_difference": 1,
        "min_submesh_triangles": 64,
        "found_submesh_count": 200,
        "bowtie_count": 0,
        "disconnected_submesh_count": 0,
    } | changes


def bar_of(found: list[Bar], *words: str) -> Bar:
    (one,) = [bar for bar in found if all(word in bar.title for word in words)]
    return one


def test_geometric_mean_of_two_and_eight_is_four():
    assert geometric_mean([2, 8]) == pytest.approx(4)
    assert math.isnan(geometric_mean([]))


@pytest.mark.parametrize("count", [1, 3])
def test_geometric_mean_of_equal_numbers_is_that_number(count):
    numbers = np.random.default_rng(0).uniform(1e-6, 1e6, 1000)
    assert [geometric_mean([number] * count) for number in numbers] == list(numbers)


def test_exponent_of_a_power_law_is_its_power():
    sizes = [5_000, 20_000, 80_000, 1_300_000]
    assert fitted_exponent(sizes, [3e-6 * size**1.1 for size in sizes]) == pytest.approx(1.1)
    assert math.isnan(fitted_exponent([5_000, 5_000], [1.0, 2.0]))


@pytest.mark.parametrize(
    ("kind", "face_count", "k"), [("20", 999, 20), ("F/256", 512, 2), ("F/256", 513, 3)]
)
def test_submesh_count_rounds_up(kind, face_count, k):
    assert submesh_count(kind, face_count) == k


@pytest.mark.parametrize(
    "fault",
    [
        {"max_triangle_count_difference": 2},
        {"bowtie_count": 1},
        {"disconnected_submesh_count": 1},
        {"min_submesh_triangles": 0},
        {"found_submesh_count": 199},
        {"status": "failed"},
    ],
)
def test_one_fault_makes_a_result_invalid(fault):
    assert is_valid(row("fast_standard", 100, 1.0))
    assert not is_valid(row("fast_standard", 100, 1.0, **fault))


def test_subdivision_keeps_a_closed_surface_and_its_volume():
    vertices, faces = octahedron()
    fine_vertices, fine_faces = subdivided(vertices, faces)
    assert fine_vertices.shape == (6 + 12, 3)
    assert fine_faces.shape == (32, 3)
    assert recount.surface_faults(fine_vertices, fine_faces) == []
    assert recount.volume(fine_vertices, fine_faces) == pytest.approx(
        recount.volume(vertices, faces)
    )
    areas = np.linalg.norm(recount.area_vectors(fine_vertices, fine_faces), axis=1)
    assert areas == pytest.approx(np.full(32, areas[0]))


def comes_from_a_split(faces: np.ndarray) -> bool:
    """Is a closed mesh another one with each triangle split in four? Then each of its triangles has
    one corner of the other mesh, or none and beside it three that have one, across from it; and
    six of them meet wherever that mesh has no corner."""
    corners = [set(face) for face in faces.tolist()]
    neighbours = [[] for _ in corners]
    for one, other in recount.linked_faces(recount.edge_faces(faces).values()):
        neighbours[one].append(other)
        neighbours[other].append(one)

    def is_split(first_old: int | None) -> bool:
        is_old = {vertex: vertex == first_old for vertex in corners[0]}
        reached, seen = [0], {0}
        for face in reached:
            is_middle = not any(is_old[vertex] for vertex in corners[face])
            for other in neighbours[face]:
                (across,) = corners[other] - corners[face]
                if other not in seen:
                    seen.add(other)
                    reached.append(other)
                if is_old.setdefault(across, is_middle) != is_middle:
                    return False
        degrees = np.bincount(faces.ravel())
        return all(is_old[vertex] or degrees[vertex] == 6 for vertex in is_old)

    return any(is_split(first_old) for first_old in (None, *corners[0]))


def test_bars_compare_medians_with_the_better_metis_mode():
    found = bars(
        Table(
            [
                row("fast_standard", 95, 1.0),
                row("fast_standard", 90, 3.0),
                row("fast_standard", 70, 2.0),
                row("metis_kway", 120, 1.0),
                row("metis_recursive", 100, 0.5),
                row("fast_standard", 90, 0.5, measurement="again"),
            ]
        )
    )
    edges = bar_of(found, "better METIS", "k = 200", "`standard`")
    assert edges.value == pytest.approx(0.90)  # median 90 over recursive's 100
    assert edges.verdict == "aim reached"
    time = bar_of(found, "total time", "60,000")
    assert (time.value, time.verdict) == (pytest.approx(2.0), "bar reached")
    again = bar_of(found, "second call")
    assert (again.value, again.verdict) == (pytest.approx(0.25), "bar reached")
    assert bar_of(found, "better METIS", "`high`").verdict == "not measured"


def test_bars_count_failed_and_swept_runs_as_results():
    rows = [row("fast_standard", 95, 1.0), row("fast_draft", 0, 0, status="failed")]
    sweep = [row("fast_draft", 9, 1.0), row("fast_draft", 9, 1.0, bowtie_count=2)]
    valid = bar_of(bars(Table(rows), sweep), "valid results")
    assert (valid.value, valid.case_count, valid.verdict) == (50, 4, "not reached")


def test_bars_and_aims_are_those_that_were_set():
    assert [(bar.bar, bar.aim, bar.more_is_better) for bar in bars(Table([]))] == [
        (0.95, 0.90, False),  # boundaries
        (0.90, 0.87, False),
        (1.00, 0.96, False),
        (0.96, 0.93, False),
        (0.97, 0.93, False),
        (1.05, 0.97, False),
        (2.0, 1.0, False),  # times
        (3.0, 1.0, False),
        (0.6, 0.3, False),
        (0.5, 0.2, False),
        (1.15, 1.05, False),
        (100, 100, True),  # valid results
        (1.5, 1.8, True),  # threads
        (400, 200, False),  # memory
    ]


def of_size(face_count: int, method: str, seconds: float, **changes) -> dict:
    size = {"mesh": f"of {face_count}", "triangle_count": face_count}
    return row(method, 100, seconds, **size, **changes)


def test_bars_of_times_take_meshes_up_to_their_limit():
    rows = []
    for ratio, face_count in enumerate([60_000, 60_001, 100_000, 100_001], start=1):
        rows.append(of_size(face_count, "metis_kway", 1.0))
        rows.append(of_size(face_count, "fast_standard", ratio))
    found = bars(Table(rows))
    small, large = (bar_of(found, "k = 200, `standard`, F", size) for size in ("60,000", "100,000"))
    assert (small.case_count, small.value) == (1, pytest.approx(1.0))
    assert (large.case_count, large.value) == (1, pytest.approx(4.0))


@pytest.mark.parametrize(("most", "exponent"), [(49_999, math.nan), (50_000, 1.1)])
def test_growth_is_that_over_a_decade_of_sizes(most, exponent):
    rows = [
        of_size(f, "fast_standard", 3e-6 * f**1.1, submesh_count=submesh_count("F/256", f))
        for f in (4_000, 5_000, 20_000, most, 1_500_000)  # the first and last are out of range
    ]
    growth = bar_of(bars(Table(rows)), "exponent")
    assert growth.case_count == 3
    assert growth.value == pytest.approx(exponent, nan_ok=True)


def test_memory_is_the_worst_of_large_meshes():
    def peak(face_count: int, size: float, measurement: str = "memory") -> dict:
        changes = {"measurement": measurement, "peak_bytes": size * face_count}
        return of_size(face_count, "fast_standard", 1.0, **changes)

    rows = [peak(100_000, 500), peak(200_000, 150), peak(300_000, 190), peak(200_000, 900, "first")]
    memory = bar_of(bars(Table(rows)), "memory")
    assert (memory.value, memory.case_count) == (190, 2)


def test_a_rising_bar_is_reached_from_below():
    assert Bar("speed-up", 1.5, 1.8, 1.6, 1, more_is_better=True).verdict == "bar reached"
    assert Bar("speed-up", 1.5, 1.8, 1.4, 1, more_is_better=True).verdict == "not reached"


def test_sweep_covers_at_least_thirty_values_from_two_to_all():
    for face_count in (40, 1_000, 558_976):
        counts = sweep_counts(face_count)
        assert len(counts) >= 30
        assert (counts[0], counts[-1]) == (2, face_count)
    assert sweep_counts(4) == [2, 3, 4]


def test_plan_spares_large_meshes_the_slow_rivals():
    plan = Plan(repeats=3, rival_limit=10_000, once_limit=1_000)
    small = [run.method for run in plan.runs(5_120) if run.measurement == "first"]
    large = [run.method for run in plan.runs(20_480) if run.measurement == "first"]
    # k = 20 is F/256 there: three values of k.
    assert small.count("mtkahypar_quality") == 3
    assert small.count("fast_standard") == 9
    assert "mtkahypar_quality" not in large
    assert large.count("metis_kway") == 12


def test_plan_spares_high_on_large_meshes():
    plan = Plan(high_limit=10_000, huge_limit=40_000)

    def counts(face_count: int) -> list[int]:
        runs = plan.runs(face_count)
        return sorted({run.submesh_count for run in runs if run.method == "fast_high"})

    assert counts(10_000) == [20, 40, 157, 200]  # 40 is F/256, 157 F/64
    assert counts(10_001) == [200]
    assert counts(40_000) == [200]
    assert counts(40_001) == []


@pytest.mark.parametrize(
    ("face_count", "expected"),
    [
        (2, {}),
        (
            50_000,
            {
                ("fast_draft", "first"): 12,  # four values of k, three times
                ("fast_standard", "first"): 12,
                ("fast_standard", "one_thread"): 6,  # k = 200 and F/256
                ("fast_standard", "again"): 3,
                ("fast_standard", "memory"): 1,
                ("metis_kway", "first"): 12,
                ("metis_recursive", "first"): 12,
                **{(name, "first"): 4 for name in ("fast_high", *SLOW_RIVALS)},
            },
        ),
        (
            300_000,
            {
                ("fast_draft", "first"): 4,
                ("fast_standard", "first"): 12,
                ("fast_standard", "one_thread"): 2,
                ("fast_standard", "again"): 1,
                ("fast_standard", "memory"): 1,
                ("metis_kway", "first"): 12,
                ("metis_recursive", "first"): 12,
                ("fast_high", "first"): 1,
            },
        ),
    ],
)
def test_plan_runs_each_method_so_often(face_count, expected):
    runs = Plan().runs(face_count)
    assert Counter((run.method, run.measurement) for run in runs) == expected
    assert {run.before for run in runs if run.measurement == "again"} <= {20}
    assert {run.seed for run in runs if run.measurement != "memory"} <= {1, 2, 3}


@pytest.fixture
def events(monkeypatch):
    """What a run does, in order; of a call of the filter the mesh set and the options."""
    events = []
    clock, run_filter, memory = time.perf_counter, api.run_filter, {"VmRSS": 500, "VmHWM": 1_200}

    def noted(name: str, result=None):
        events.append(name)
        return result

    def noted_call(mesh_set, name, **options):
        events.append((mesh_set, options))
        return run_filter(mesh_set, name, **options)

    monkeypatch.setattr(time, "perf_counter", lambda: noted("clock", clock()))
    monkeypatch.setattr(api, "forget_prepared_mesh", lambda: noted("forget"))
    monkeypatch.setattr(api, "run_filter", noted_call)
    monkeypatch.setattr(methods, "_memory", lambda name: noted(name, memory[name]))
    return events


def options_of(call: tuple) -> tuple:
    return tuple(call[1][name] for name in ("method", "effort", "submesh_count", "thread_count"))


def test_a_first_call_is_of_a_new_mesh_that_is_forgotten_before_the_clock_starts(events):
    mesh_runs = MeshRuns(*octahedron())
    for _ in range(2):
        perform(mesh_runs, Run("fast_high", 3, "first", 1).as_job(), 2)
    first, second = events[2], events[6]
    assert events == [*("forget", "clock", first, "clock"), *("forget", "clock", second, "clock")]
    assert options_of(first) == options_of(second) == ("fast", "high", 3, 2)
    assert first[0] is not second[0]


def test_a_second_call_is_of_the_mesh_of_the_call_before(events):
    timed = perform(MeshRuns(*octahedron()), Run("fast_standard", 4, "again", 1, 2).as_job(), 2)
    first, second = events[2], events[5]
    assert events == ["forget", *("clock", first, "clock"), *("clock", second, "clock")]
    assert options_of(first) == ("fast", "draft", 2, 2)
    assert options_of(second) == ("fast", "standard", 4, 2)
    assert first[0] is second[0]
    assert set(timed.labels) == set(range(4))


def test_on_one_thread_is_a_first_call_with_one_thread(events):
    perform(MeshRuns(*octahedron()), Run("fast_standard", 3, "one_thread", 1).as_job(), 2)
    assert events == ["forget", "clock", events[2], "clock"]
    assert options_of(events[2]) == ("fast", "standard", 3, 1)


def test_peak_memory_is_what_the_call_adds(events):
    timed = perform(MeshRuns(*octahedron()), Run("fast_standard", 3, "memory", 0).as_job(), 2)
    assert events == ["forget", "VmRSS", "clock", events[3], "clock", "VmHWM"]
    assert timed.details == {"peak_bytes": 700}


def test_results_that_are_not_valid_are_counted_and_marked(tmp_path):
    place = {"commit": "c", "machine": "m"}
    table = Table(
        [
            row("fast_standard", 93, 1.0, **place),
            row("fast_standard", 93, 1.0, bowtie_count=1, **place),
            row("metis_kway", 186, 1.0, **place),
        ]
    )
    assert table.get("ball", 200, "fast_standard").invalid_count == 1
    assert table.get("ball", 200, "metis_kway").invalid_count == 0
    facts = environment.surroundings() | {"threads": "2"}
    document.write(tmp_path, table, [], facts, Plan(), [])
    text = (tmp_path / "benchmarks.md").read_text()
    # The hexagonal bound is sqrt(6 * 12,800 * 200) / 2 = 1,959.6.
    assert "| ball | 12,800 | 200 | 0.047* | 0.095 |" in text


def test_the_documents_tables_are_those_of_the_rows(tmp_path):
    place = {"commit": "c", "machine": "m"}

    def timed(face_count: int, seconds: float, *parts: float, **changes) -> dict:
        k = submesh_count("F/256", face_count)
        counts = {"submesh_count": k, "found_submesh_count": k}
        found = of_size(face_count, "fast_standard", seconds, **counts, **place)
        return found | dict(zip(STAGES, parts, strict=False)) | changes

    rows = [
        timed(5_120, 0.8),
        timed(12_800, 1.0, 0.1, 0.2, 0.3, 0.9),
        timed(12_800, 2.0, 0.5, 0.9, 0.4, 1.9),  # the median of each number
        timed(12_800, 4.0, 1.0, 1.2, 0.5, 3.0),
        timed(12_800, 3.0, measurement="one_thread"),
        timed(12_800, 0.5, measurement="again"),
        timed(12_800, 0.0, measurement="memory", peak_bytes=150 * 12_800),
        timed(51_200, 8.0),
        timed(12_800, 2.0, method="metis_kway", boundary_edge_count=200),
        timed(12_800, 2.0, method="metis_recursive", boundary_edge_count=125),
    ]
    sweep = [
        timed(12_800, 1.0),
        timed(12_800, 1.0, bowtie_count=2, max_triangle_count_difference=3),
    ]
    facts = environment.surroundings() | {"threads": "2"}
    document.write(tmp_path, Table(rows), sweep, facts, Plan(), [])
    text = (tmp_path / "benchmarks.md").read_text()
    sections = {part.partition("\n")[0]: part for part in text.split("\n## ")}

    quality, seconds = sections["Quality at k = F/256"], sections["Seconds at k = F/256"]
    # The hexagonal bound is sqrt(6 * 12,800 * 50) / 2 = 979.8.
    assert "| of 12800 | 12,800 | 50 | 0.102 | 0.204 | 0.128 | 0.800 |" in quality
    assert "geometric mean 0.800" in quality
    assert "| standard, 1 thread | standard, second call |" in seconds
    assert "| of 12800 | 12,800 | 2 | 2 | 2 | 3 | 0.5 |" in seconds
    assert "| of 51200 | 51,200 | 8 | – | – | – | – |" in seconds
    measured = "| of 12800 | 12,800 | 2 | 156.25 | 25 % | 45 % | 20 % | 10 % | 1.500 | 150 |"
    assert measured in sections["Stages, threads and memory, `standard`, k = F/256"]
    # Each triangle takes as long as any other.
    assert "| all | 3 | 5,120 to 51,200 | 1.000 |" in sections["Growth of time"]
    assert "standard, sweep over k | 2 | 1 | 0 | 1 | 0 | 1 |" in sections["Validity"]
    assert "The sweep covers 1 meshes of 12,800 to 12,800 triangles" in sections["Validity"]
    lines = (tmp_path / "benchmarks.csv").read_text().splitlines()
    assert lines[0].startswith("mesh,triangle_count,submesh_count,method,")
    assert lines[0].endswith("seconds,measurement")
    assert "of 12800,12800,50,fast_standard,0,100,0.102062,1,0,0,3,one_thread" in lines
    assert "Quality at k = F/64" not in sections


def test_meshes_that_are_subdivisions_are_named_so():
    samples = Path(program.REPOSITORY / "sample_meshes")
    found, _ = meshes.available(samples, samples / "none")
    small = [mesh for mesh in found if mesh.triangle_count <= 25_000]
    assert len(small) >= 10
    assert {mesh.name: meshes.is_subdivision(mesh.name) for mesh in small} == {
        mesh.name: comes_from_a_split(meshes.read(mesh)[1]) for mesh in small
    }


def test_the_bars_stand_there_once_more_without_subdivisions(tmp_path):
    place = {"commit": "c", "machine": "m"}
    rows = [
        row("fast_standard", edges, 1.0, mesh=mesh, **place)
        for mesh, edges in (("ball", 90), ("displaced_sphere_x4", 40))
    ]
    rows += [
        row(method, 100, 1.0, mesh=mesh, **place)
        for mesh in ("ball", "displaced_sphere_x4")
        for method in ("metis_kway", "metis_recursive")
    ]
    facts = environment.surroundings() | {"threads": "2"}
    title = "| BE over the better METIS mode, k = 200, `standard` | 0.95 | 0.9 |"

    def text_of(rows: list[dict]) -> str:
        document.write(tmp_path, Table(rows), [], facts, Plan(), [])
        return (tmp_path / "benchmarks.md").read_text()

    all_meshes, others = text_of(rows).split("### Without subdivisions")
    assert f"{title} 0.600 | 2 | aim reached |" in all_meshes  # the root of 0.9 * 0.4
    assert "1 of the 2 meshes" in others
    assert f"{title} 0.900 | 1 | aim reached |" in others
    assert "Without subdivisions" not in text_of([r for r in rows if r["mesh"] == "ball"])


def test_program_writes_the_document_and_resumes(tmp_path, capsys):
    arguments = ["--meshes", "bone", "--k", "20", "--methods", "fast_standard,metis_kway"]
    arguments += ["--repeats", "1", "--output", str(tmp_path)]
    assert program.main(arguments) == 0
    rows = records.load(tmp_path / "runs.csv")
    assert {(r["method"], r["status"]) for r in rows} == {
        ("fast_standard", "done"),
        ("metis_kway", "done"),
    }
    ours = next(r for r in rows if r["method"] == "fast_standard")
    assert is_valid(ours)
    assert ours["triangle_count"] == 3_022
    assert 0 < ours["total_seconds"] <= ours["seconds"]
    text = (tmp_path / "benchmarks.md").read_text()
    assert "| bone | 3,022 | 20 |" in text
    assert (tmp_path / "images" / "benchmarks.png").stat().st_size > 1_000

    first = (tmp_path / "runs.csv").read_text()
    assert program.main([*arguments, "--resume"]) == 0
    assert (tmp_path / "runs.csv").read_text() == first
    assert "  k " not in capsys.readouterr().out.split("written:")[1]


def case(**changes) -> dict:
    return row("fast_standard", 1, 1.0) | {"seed": 1, "threads": 2, "mesh_sha256": "a"} | changes


def test_rows_of_other_threads_another_mesh_or_another_plugin_are_measured_again():
    planned = [case(), case(seed=2, threads=4), case(seed=3, mesh_sha256="b")]
    stamp = {"commit": "c", "plugin": "p", "machine": "m"}
    mine, other_case = case(**stamp), case(**stamp, seed=9)
    rows = [
        mine,
        other_case,
        case(**stamp, seed=2),
        case(**stamp, seed=3),
        case(**stamp | {"plugin": "q"}),
        case(**stamp | {"machine": "n"}),
        case(**stamp, status="failed"),
    ]
    assert records.current(rows, planned, stamp) == [mine, other_case]


def test_the_document_names_the_machine_of_the_rows(tmp_path, monkeypatch):
    store = records.Records(tmp_path / "runs.csv", [])
    store.add(case(plugin="p", commit="c", machine="Elsewhere, 96 cores"))
    store.close()
    assert program.main(["--report-only", "--k", "200", "--output", str(tmp_path)]) == 0
    text = (tmp_path / "benchmarks.md").read_text()
    assert "| machine | Elsewhere, 96 cores |" in text
    assert environment.surroundings()["memory"] not in text
    monkeypatch.setattr(environment, "machine", lambda facts: "Elsewhere, 96 cores")
    assert program.main(["--report-only", "--k", "200", "--output", str(tmp_path)]) == 0
    assert environment.surroundings()["memory"] in (tmp_path / "benchmarks.md").read_text()


def test_an_installation_without_a_checkout_is_refused(tmp_path):
    installed = tmp_path / "site-packages"
    shutil.copytree(Path(spheroseg.__file__).parent, installed / "spheroseg")
    (installed / "matplotlib.py").write_text("raise ImportError('is not installed')")
    done = run_python(
        *("-P", "-m", "spheroseg.bench"),
        PYTHONPATH=str(installed),
        SPHEROSEG_PLUGIN=str(spheroseg.plugin_path()),
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert f"{installed / 'spheroseg' / 'bench'} is no part of a checkout" in done.stderr


def test_earlier_rows_are_there_until_the_kept_ones_are(tmp_path, monkeypatch):
    path = tmp_path / "runs.csv"
    records.Records(path, [case(plugin="p"), case(plugin="p", seed=2)]).close()
    before = path.read_text()
    assert before.count("\n") == 3

    def no_room(*_):
        raise OSError(errno.ENOSPC, "no room")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", no_room)
        with pytest.raises(OSError, match="no room"):
            records.Records(path, [case(plugin="p")])
    assert path.read_text() == before
    store = records.Records(path, records.load(path))
    store.add(case(plugin="p", seed=3))
    store.close()
    assert path.read_text().startswith(before)
    assert [row["seed"] for row in records.load(path)] == [1, 2, 3]


def test_sweep_counts_invalid_results(tmp_path):
    arguments = ["--meshes", "bone", "--output", str(tmp_path), "--validity-sweep"]
    assert program.main([*arguments, "--methods", "fast_draft", "--sweep-count", "3"]) == 0
    rows = records.load(tmp_path / "sweep.csv")
    assert {2, 1_511, 3_021, 3_022} <= {row["submesh_count"] for row in rows}
    assert "`fast` draft, sweep over k" in (tmp_path / "benchmarks.md").read_text()


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout with a mesh and docs of its own, in which runs and diagrams take no time."""
    monkeypatch.setattr(program, "REPOSITORY", tmp_path / "repo")
    monkeypatch.setattr(meshes, "PYMESHLAB_SAMPLES", ())
    monkeypatch.setattr(program, "run_mesh", add_valid_rows)
    monkeypatch.setattr(document.plot, "quality_and_time", lambda *_: None)
    samples, docs = tmp_path / "repo" / "sample_meshes", tmp_path / "repo" / "docs"
    samples.mkdir(parents=True)
    (samples / "ball.ply").write_bytes(ply_bytes(*subdivided_sphere(4)))
    docs.mkdir()
    (docs / "benchmarks.md").write_text("old")
    return tmp_path / "repo"


def add_valid_rows(mesh, runs, store, stamp, thread_count, on_row):
    for run in runs:
        known = row_of(mesh, run, thread_count) | stamp
        found = {"found_submesh_count": run.submesh_count, "min_submesh_triangles": 1, "error": ""}
        store.add(row(run.method, 100, 1.0) | known | found)


def docs_of(checkout) -> str:
    return (checkout / "docs" / "benchmarks.md").read_text()


def test_docs_are_written_once_both_runs_are_there(checkout, capsys):
    assert program.main([]) == 0
    assert docs_of(checkout) == "old"
    told = capsys.readouterr().out.splitlines()[-1]
    assert f"written: {checkout / 'out' / 'bench' / 'benchmarks.md'}; " in told
    count = 2 * len(sweep_counts(2_048))
    assert f"is left as it is: {count} of {count} runs are missing (run with --validity-" in told
    assert program.main(["--validity-sweep"]) == 0
    assert "sweep over k" in docs_of(checkout)
    assert (checkout / "docs" / "benchmarks.csv").read_text().count("\n") > 30
    assert capsys.readouterr().out.endswith(f"written: {checkout / 'docs' / 'benchmarks.md'}\n")


@pytest.mark.parametrize("first", [[], ["--validity-sweep"]])
def test_two_runs_with_the_same_folders_write_other_docs(checkout, tmp_path, first):
    (second,) = [run for run in ([], ["--validity-sweep"]) if run != first]
    folders = ["--output", str(tmp_path / "rows"), "--docs", str(tmp_path / "other")]
    assert program.main([*first, *folders]) == 0
    assert not (tmp_path / "other").exists()
    assert program.main([*second, *folders]) == 0
    text = (tmp_path / "other" / "benchmarks.md").read_text()
    assert "## Quality at k = 200" in text
    assert "sweep over k" in text
    assert docs_of(checkout) == "old"


def test_docs_are_left_where_an_option_changes_results(checkout, capsys):
    for arguments in ([], ["--validity-sweep"]):
        assert program.main(arguments) == 0
    (checkout / "docs" / "benchmarks.md").write_text("old")
    texts = ["--meshes=b*", "--k=20", "--methods=fast_draft", "--samples=.", "--more-meshes=."]
    names = ("repeats", "threads", "min-triangles", "max-triangles", "sweep-count")
    names += ("once-limit", "rival-limit", "high-limit", "few-limit")
    for option in (*texts, *(f"--{name}=9" for name in names)):
        assert program.main(["--report-only", option]) == 0
        told = capsys.readouterr().out
        assert told.endswith(f"is left as it is: {option.split('=')[0]} given\n")
        assert docs_of(checkout) == "old"
    assert program.main(["--report-only"]) == 0
    assert docs_of(checkout) != "old"


def test_docs_are_left_where_rows_are_missing(checkout, capsys):
    with pytest.raises(SystemExit, match="2"):
        program.main(["--report-only"])
    assert "there are no results in" in capsys.readouterr().err
    assert not (checkout / "out").exists()
    for arguments in ([], ["--validity-sweep"]):
        assert program.main(arguments) == 0
    (checkout / "docs" / "benchmarks.md").write_text("old")
    path = checkout / "out" / "bench" / "runs.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
    assert program.main(["--report-only"]) == 0
    assert docs_of(checkout) == "old"
    assert "is left as it is: 1 of " in capsys.readouterr().out
    assert program.main(["--resume"]) == 0
    assert docs_of(checkout) != "old"


@pytest.mark.parametrize(
    ("option", "message"),
    [
        ("--k=abc", "argument --k: expected numbers from 2 on or F/N, found 'abc'"),
        ("--k=20,1", "found '1'"),
        ("--k=F/0", "found 'F/0'"),
        ("--k=9000", "these options leave no run on any mesh"),
        ("--methods=fast_draft,nosuch", "argument --methods: there is no method 'nosuch'"),
        ("--meshes=ball,nosuch", "argument --meshes: no mesh is named 'nosuch'"),
        ("--min-triangles=9000", "these options leave no run on any mesh"),
        ("--repeats=0", "argument --repeats: must be 1 or more, got 0"),
        ("--sweep-count=0", "argument --sweep-count: must be 1 or more, got 0"),
        ("--threads=-1", "argument --threads: must be 0 or more, got -1"),
    ],
)
def test_bad_options_are_refused_before_any_run(checkout, option, message, capsys):
    with pytest.raises(SystemExit, match="2"):
        program.main([option])
    assert message in capsys.readouterr().err
    assert not (checkout / "out").exists()
