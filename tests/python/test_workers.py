# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent import futures
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


@pytest.fixture
def nursery():
    with contextlib.closing(workers.Nursery("odd_nursery")) as found:
        yield found


def run(nursery, **job):
    """Exit code, reason, and the processes of the job and of its nursery."""
    done = nursery.run(json.dumps(job))
    process, parent = map(int, done.stderr.split()[:2])
    return done.returncode, workers.failure_reason(done.returncode, done.stderr), process, parent


def test_each_job_of_a_nursery_has_a_process_of_its_own(nursery):
    endings = [
        ({}, 0, None),
        ({"code": 4}, 4, None),
        ({"raise": "key"}, 1, "KeyError: 'k'"),
        ({"exit": 3}, 3, "the last line"),
        ({"signal": signal.SIGKILL}, -signal.SIGKILL, "the process was ended by signal 9"),
        ({"print": "of a library"}, 0, "of a library"),
        ({}, 0, None),
    ]
    found = [run(nursery, **job) for job, _, _ in endings]
    for (code, reason, _, _), (_, expected, expected_reason) in zip(found, endings, strict=True):
        assert code == expected
        assert expected_reason is None or reason.startswith(expected_reason)
    processes, parents = ({one[i] for one in found} for i in (2, 3))
    assert len(processes) == len(endings)
    assert len(parents) == 1
    assert not any(map(is_running, processes))
    assert all(map(is_running, parents))
    nursery.close()
    assert not any(map(is_running, parents))


def test_a_job_of_a_nursery_has_an_empty_stdin_and_may_say_much(nursery):
    done = nursery.run(json.dumps({"length": 1_000_000}))
    assert done.stderr.split()[2] == "''"
    assert len(done.stderr) > 1_000_000


def test_what_a_nursery_prepares_is_there_for_all_jobs(nursery):
    assert [run(nursery, **job)[0] for job in ({}, {"prepare": 3}, {})] == [0, 3, 3]


def test_a_nursery_that_was_ended_is_replaced(nursery):
    process = run(nursery)[3]
    os.kill(process, signal.SIGKILL)
    wait_until(lambda: not is_running(process))
    done = nursery.run("{}")
    assert (done.returncode, done.stderr) == (-signal.SIGKILL, "")
    code, _, _, another = run(nursery)
    assert (code, another != process) == (0, True)


def test_a_nursery_without_jobs_ends_and_is_replaced(nursery, monkeypatch):
    first = run(nursery)[3]
    monkeypatch.setattr(workers, "_IDLE_SECONDS", 0.2)
    assert run(nursery)[3] == first
    wait_until(lambda: not is_running(first))
    code, _, _, another = run(nursery)
    assert (code, another != first) == (0, True)


def test_a_nursery_needs_no_thread(nursery, monkeypatch):
    def refuse(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", refuse)
    first, second = run(nursery), run(nursery)
    assert (first[0], first[3]) == (0, second[3])


def test_a_nursery_that_is_closed_does_its_job_and_leaves_nothing(nursery, tmp_path):
    mark = tmp_path / "mark"
    with futures.ThreadPoolExecutor() as pool:
        job = pool.submit(run, nursery, sleep=1, mark=str(mark))
        wait_until(lambda: mark.exists() and mark.read_text())
        nursery.close()
        code, _, _, process = job.result()
    assert (code, is_running(process)) == (0, False)
    wait_until(lambda: not any(isinstance(one, threading.Timer) for one in threading.enumerate()))


def test_a_nursery_that_can_not_begin_says_why():
    with contextlib.closing(workers.Nursery("no_such_module")) as nursery:
        for _ in range(2):
            done = nursery.run("{}")
            assert done.returncode == 1
            assert done.stderr.endswith("No module named no_such_module\n")


@pytest.mark.parametrize("greeting", ["welcome\n", "{}", "{}\n", "7\n"])
def test_what_a_library_prints_is_no_answer_of_a_nursery(nursery, monkeypatch, greeting):
    monkeypatch.setenv("GREETING", greeting)
    done = nursery.run("{}")
    assert (done.returncode, done.stderr) == (-signal.SIGKILL, "")
    monkeypatch.delenv("GREETING")
    assert run(nursery)[0] == 0


@pytest.mark.parametrize(
    ("send", "code"),
    [("interrupt", workers.INTERRUPTED_EXIT), ("kill", -signal.SIGKILL)],
)
def test_a_signal_for_a_nursery_is_one_for_its_job(nursery, tmp_path, monkeypatch, send, code):
    monkeypatch.setenv("SLOW_FORK", "1")
    mark = tmp_path / "mark"
    first = run(nursery)[3]
    with futures.ThreadPoolExecutor() as pool:
        job = pool.submit(nursery.run, json.dumps({"sleep": 60, "mark": str(mark)}))
        wait_until(lambda: mark.exists() and mark.read_text())
        getattr(nursery, send)()
        done = job.result()
    assert done.returncode == code
    assert not is_running(int(mark.read_text()))
    for send_to_none in (nursery.interrupt, nursery.kill):
        send_to_none()
    assert run(nursery)[::3] == (0, first)


def test_a_job_that_is_interrupted_before_it_begins_says_so(nursery, monkeypatch):
    monkeypatch.setenv("EARLY_INTERRUPT", "1")
    done = nursery.run("{}")
    assert (done.returncode, done.stderr) == (workers.INTERRUPTED_EXIT, "interrupted\n")


def test_a_job_ends_with_a_nursery_that_is_killed(nursery, tmp_path):
    mark = tmp_path / "mark"
    process = run(nursery)[3]
    with futures.ThreadPoolExecutor() as pool:
        job = pool.submit(nursery.run, json.dumps({"sleep": 60, "mark": str(mark)}))
        wait_until(lambda: mark.exists() and mark.read_text())
        os.kill(process, signal.SIGKILL)
        assert job.result().returncode == -signal.SIGKILL
    wait_until(lambda: not is_running(int(mark.read_text())), seconds=5)


def test_a_job_of_a_nursery_ends_when_it_gets_a_sigterm(nursery):
    assert run(nursery, signal=signal.SIGTERM)[0] == -signal.SIGTERM


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
