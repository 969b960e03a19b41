# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from processes import is_running, wait_until

from spheroseg import workers
from spheroseg.bench.meshes import BenchMesh
from spheroseg.bench.plan import Run
from spheroseg.bench.records import Records
from spheroseg.bench.runner import run_mesh


@pytest.fixture(autouse=True)
def workers_of_the_tests(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))


def outcomes(tasks, **job) -> list[tuple[str, str | None]]:
    found = list(workers.results("odd_worker", {"fact": 7} | job, tasks))
    assert [task for task, _ in found] == tasks
    assert {result["fact"] for _, result in found} <= {7}
    return [(result["status"], result.get("error")) for _, result in found]


def test_a_task_that_ends_its_process_costs_no_other_result():
    tasks = [{}, {"signal": signal.SIGKILL}, {}, {"exit": 3}, {"exit": 0}, {}]
    assert outcomes(tasks) == [
        ("done", None),
        ("failed", "the process was ended by signal 9"),
        ("done", None),
        ("failed", "the last line"),
        ("failed", "the last line"),
        ("done", None),
    ]


def test_what_a_task_throws_is_its_failure_and_the_process_goes_on():
    tasks = [{}, {"raise": "memory"}, {"raise": "key"}, {"raise": "input"}, {}]
    assert outcomes(tasks)[1:4] == [
        ("failed", "MemoryError"),
        ("failed", "KeyError: 'k'"),
        ("failed", "no"),
    ]
    processes = [result.get("process") for _, result in workers.results("odd_worker", {}, tasks)]
    assert processes[0] == processes[-1]


def test_what_libraries_print_is_no_result():
    assert outcomes([{"print": "METIS says"}, {"print": "{}"}]) == [("done", None)] * 2


def test_half_a_line_of_a_process_that_has_ended_is_no_result(monkeypatch):
    def start(module, stderr):
        program = "print('{}'); print('{\"status\": \"do', end='')"
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": stderr}
        return subprocess.Popen([sys.executable, "-c", program], **pipes, text=True)

    monkeypatch.setattr(workers, "start", start)
    ((_, result),) = workers.results("odd_worker", {}, [{}])
    assert result == {"status": "failed", "error": "the process ended with exit code 0"}


@pytest.mark.parametrize("said", ["Licence expired", "5", "[]"])
def test_a_result_that_is_no_json_costs_no_other_result(said, monkeypatch):
    def start(module, stderr):
        program = (
            "import json, sys\nprint('{}')\nfor task in json.load(sys.stdin)['tasks']:"
            "\n print(task.get('say', '{\"status\": \"done\"}'), flush=True)"
        )
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": stderr}
        return subprocess.Popen([sys.executable, "-c", program], **pipes, text=True)

    monkeypatch.setattr(workers, "start", start)
    found = [result for _, result in workers.results("odd_worker", {}, [{}, {"say": said}, {}])]
    refused = {"status": "failed", "error": f"the process said '{said}' instead of a result"}
    assert found == [{"status": "done"}, refused, {"status": "done"}]


def test_a_job_that_can_not_be_prepared_is_an_error_with_its_reason():
    with pytest.raises(workers.WorkerError, match="^no such mesh$"):
        outcomes([{}], refuse="no such mesh")


def test_no_task_needs_no_process():
    assert outcomes([], refuse="never started") == []


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux to end it")
def test_a_worker_ends_with_a_parent_that_is_killed(tmp_path):
    mark = tmp_path / "mark"
    tasks = [{"sleep": 60, "mark": str(mark)}]
    program = f"from spheroseg import workers; list(workers.results('odd_worker', {{}}, {tasks}))"
    parent = subprocess.Popen([sys.executable, "-c", program], env=workers.package_environment())
    wait_until(lambda: mark.exists() and mark.read_text())
    worker = int(mark.read_text())
    assert is_running(worker)
    parent.kill()
    parent.wait()
    wait_until(lambda: not is_running(worker), seconds=5)


def test_a_worker_whose_results_nobody_wants_any_more_is_ended(tmp_path):
    mark = tmp_path / "mark"
    found = workers.results("odd_worker", {}, [{}, {"sleep": 60, "mark": str(mark)}])
    next(found)
    wait_until(lambda: mark.exists() and mark.read_text())
    began = time.monotonic()
    found.close()
    assert time.monotonic() - began < 30
    assert not is_running(int(mark.read_text()))


@pytest.mark.parametrize("module", ["evaluate", "bench", "batch"])
def test_no_worker_loads_the_packages_of_the_terminal(module):
    program = f"import sys, spheroseg.{module}.worker; print('rich' in sys.modules)"
    said = subprocess.check_output(
        [sys.executable, "-c", program], env=workers.package_environment(), text=True
    )
    assert said.strip() == "False"


def test_bench_rows_tell_why_a_process_ended(tmp_path, monkeypatch):
    pytest.importorskip("pymetis")
    broken = tmp_path / "kaminpar.py"
    broken.write_text("import os, sys\nprint('no licence', file=sys.stderr)\nos._exit(1)\n")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    sphere = Path(__file__).resolve().parents[2] / "sample_meshes" / "displaced_sphere.ply"
    methods = ("metis_kway", "kaminpar_exact", "metis_recursive")
    runs = [Run(method, 20, "first", 1) for method in methods]
    rows = bench_rows(tmp_path, BenchMesh("sphere", str(sphere)), runs)
    assert [(row["status"], row["error"]) for row in rows] == [
        ("done", ""),
        ("failed", "no licence"),
        ("done", ""),
    ]
    missing = bench_rows(tmp_path, BenchMesh("none", __file__), runs)
    assert [row["status"] for row in missing] == ["failed"] * 3
    assert {row["error"] for row in missing} == {missing[0]["error"]}
    assert "test_workers.py" in missing[0]["error"]


def bench_rows(folder: Path, mesh: BenchMesh, runs: list[Run]) -> list[dict]:
    records = Records(folder / f"{mesh.name}.csv", [])
    run_mesh(mesh, runs, records, {"commit": "c", "plugin": "p"}, 1, lambda row: None)
    records.close()
    return records.rows
