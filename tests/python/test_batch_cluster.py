# SPDX-License-Identifier: GPL-3.0-or-later
"""Batches on a Dask cluster of this machine."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import time
from concurrent import futures
from pathlib import Path

import pytest
from batches import (
    rows,
    run_batch,
    start_batch,
    wait_for_records,
    write_finned,
    write_mesh,
)
from processes import children, is_running, read_or_nothing, wait_until

import spheroseg
from spheroseg.batch import jobs, runner
from spheroseg.cli import main


@contextlib.contextmanager
def dask(*arguments, python_path=Path(spheroseg.__file__).parents[1]):
    process = subprocess.Popen(
        [sys.executable, "-m", "dask", *map(str, arguments)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=dict(os.environ, PYTHONPATH=str(python_path)),
        start_new_session=True,
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def test_dask_cluster_loses_a_worker_but_no_mesh(tmp_path):
    distributed = pytest.importorskip("distributed")
    address_file = tmp_path / "scheduler.json"
    output = tmp_path / "out"
    for seed, name in enumerate(("a", "b/c", "d")):
        write_mesh(tmp_path / "in" / f"{name}.ply", seed)
    write_finned(tmp_path / "in" / "fin.ply")
    arguments = [tmp_path / "in", "-k", 5, "-o"]
    assert run_batch(*arguments, tmp_path / "undisturbed")[0] == 1
    worker = ("worker", "--scheduler-file", address_file, "--nthreads", 1, "--no-dashboard")
    scheduler = ("scheduler", "--port", 0, "--scheduler-file", address_file, "--no-dashboard")
    without_us = tmp_path / "without_us"
    without_us.mkdir()
    (without_us / "spheroseg.py").write_text(
        "raise ImportError('the scheduler needs no spheroseg')"
    )
    with (
        dask(*scheduler, python_path=without_us),
        dask(*worker) as first,
        dask(*worker),
    ):
        wait_until(lambda: read_or_nothing(address_file))
        address = json.loads(address_file.read_text())["address"]
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(2, timeout=60)
        process = start_batch(*arguments, output, "--scheduler", address)
        wait_for_records(output, 1, process)
        os.killpg(first.pid, signal.SIGKILL)
        said, _ = process.communicate(timeout=120)
    assert "3 of 4 meshes done" in said
    assert rows(output) == rows(tmp_path / "undisturbed")


@contextlib.contextmanager
def dask_cluster(folder: Path, *worker_arguments):
    """The address of a scheduler, a function that starts its only worker, and its process."""
    file = folder / "scheduler.json"
    worker = ("worker", "--scheduler-file", file, "--nthreads", 1, "--no-dashboard")
    with contextlib.ExitStack() as running:
        scheduler = ("scheduler", "--port", 0, "--scheduler-file", file, "--no-dashboard")
        process = running.enter_context(dask(*scheduler))
        wait_until(lambda: read_or_nothing(file))

        def start_worker():
            return running.enter_context(dask(*worker, *worker_arguments))

        yield json.loads(file.read_text())["address"], start_worker, process


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_lost_scheduler_ends_the_run_with_what_is_done(number, tmp_path):
    pytest.importorskip("distributed")
    write_mesh(tmp_path / "in" / "a.ply")
    for name in ("b", "c"):
        write_mesh(tmp_path / "in" / f"{name}.ply", levels=7)
    output = tmp_path / "out"
    arguments = [tmp_path / "in", "-o", output, "-k", 20, "--effort", "high"]
    with dask_cluster(tmp_path) as (address, start_worker, scheduler):
        start_worker()
        process = start_batch(*arguments, "--scheduler", address)
        wait_for_records(output, 1, process)
        scheduler.send_signal(number)
        said, complained = process.communicate(timeout=120)
    assert process.returncode == 1, complained
    assert complained == (
        f"spheroseg batch: the Dask scheduler at {address} was lost, or has cancelled the work; go "
        "on with --resume\n"
    )
    assert "1 of 3 meshes done" in said
    assert [row["status"] for row in rows(output)] == ["done", "undone", "undone"]
    for name in ("b", "c"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    code, said, _ = run_batch(*arguments, "--resume")
    assert (code, "3 of 3 meshes done" in said) == (0, True)


def test_a_scheduler_without_workers_is_said_once_and_the_run_goes_on(
    tmp_path, monkeypatch, capsys
):
    pytest.importorskip("distributed")
    monkeypatch.setattr(runner, "_IDLE_SECONDS", 0.5)
    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "-k", "3"]
    said = []
    with (
        futures.ThreadPoolExecutor() as pool,
        dask_cluster(tmp_path) as (address, start_worker, _),
    ):
        code = pool.submit(main, [*arguments, "--scheduler", address])
        wait_until(lambda: said.append(capsys.readouterr().err) or any(said))
        start_worker()
        assert code.result(60) == 0
        assert main([*arguments, "--resume", "--scheduler", address]) == 0
    assert "".join(said) + capsys.readouterr().err == (
        f"spheroseg batch: the Dask scheduler at {address} has no worker; the run goes on when you "
        f"start one: dask worker {address}\n"
    )


def test_meshes_that_waited_for_a_worker_are_done_in_their_order(tmp_path):
    distributed = pytest.importorskip("distributed")
    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    output = tmp_path / "out"

    def set_status(name, dask_worker):  # a local function travels by value
        dask_worker.status = distributed.Status[name]

    # Without a limit nothing else changes the status of the worker.
    with dask_cluster(tmp_path, "--memory-limit", 0) as (address, start_worker, _):
        start_worker()
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
            client.run(set_status, "paused")
            process = start_batch(tmp_path / "in", "-o", output, "-k", 3, "--scheduler", address)
            wait_until(lambda: meshes_of(client) == {"a", "b"})
            client.run(set_status, "running")
            assert process.wait(60) == 0
    first, second = (output / jobs.RECORD_FOLDER / f"{name}.json" for name in ("a", "b"))
    assert first.stat().st_mtime_ns < second.stat().st_mtime_ns


def test_a_cluster_that_loses_all_workers_is_said_and_the_run_goes_on_with_another(
    tmp_path, monkeypatch, capsys
):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(runner, "_IDLE_SECONDS", 2)
    write_mesh(tmp_path / "in" / "a.ply")
    for name in ("b", "c"):
        write_mesh(tmp_path / "in" / f"{name}.ply", levels=7)
    output = tmp_path / "out"
    arguments = ["batch", str(tmp_path / "in"), "-o", str(output), "-k", "20", "--effort", "high"]
    complained = []
    with (
        futures.ThreadPoolExecutor() as pool,
        dask_cluster(tmp_path) as (address, start_worker, _),
    ):
        lost = start_worker()
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
            code = pool.submit(main, [*arguments, "--scheduler", address])
            wait_until(lambda: meshes_of(client) == {"b", "c"})
        record = output / jobs.RECORD_FOLDER / "a.json"
        before = record.stat().st_mtime_ns
        os.killpg(lost.pid, signal.SIGKILL)
        for name in ("b", "c"):
            write_mesh(tmp_path / "in" / f"{name}.ply")
        wait_until(lambda: complained.append(capsys.readouterr().err) or any(complained))
        start_worker()
        assert code.result(60) == 0
    assert "".join(complained) + capsys.readouterr().err == (
        f"spheroseg batch: the Dask scheduler at {address} has no worker; the run goes on when you "
        f"start one: dask worker {address}\n"
    )
    assert [row["status"] for row in rows(output)] == ["done"] * 3
    assert record.stat().st_mtime_ns == before, "the other worker did again what the lost one did"


def test_a_worker_that_takes_long_is_a_worker(tmp_path, monkeypatch, capsys):
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(runner, "_IDLE_SECONDS", 0.1)
    write_mesh(tmp_path / "a.ply", levels=5)
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out"), "-k", "20"]
    with dask_cluster(tmp_path) as (address, start_worker, _):
        start_worker()
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
        assert main([*arguments, "--scheduler", address]) == 0
    assert capsys.readouterr().err == ""


def meshes_of(client) -> set[str]:
    """What the scheduler still has to do, or to keep for somebody."""
    keys = client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.tasks))
    return {key.rpartition("-")[2] for key in keys}


def wait_for_batches(client, count: int) -> None:
    """Until as many have given all meshes to the scheduler."""
    waiting = lambda dask_scheduler: sum(  # noqa: E731 (travels by value)
        bool(state.wants_what) for state in dask_scheduler.clients.values()
    )
    wait_until(lambda: client.run_on_scheduler(waiting) == count)


def test_a_scheduler_that_is_lost_before_it_has_a_worker_ends_the_run(tmp_path):
    distributed = pytest.importorskip("distributed")
    write_mesh(tmp_path / "a.ply")
    with dask_cluster(tmp_path) as (address, _, scheduler):
        arguments = [tmp_path / "a.ply", "-o", tmp_path / "out", "--scheduler", address]
        process = start_batch(*arguments)
        with distributed.Client(address, set_as_default=False) as client:
            wait_for_batches(client, 1)
        scheduler.kill()
        _, complained = process.communicate(timeout=120)
    assert process.returncode == 1
    assert complained == (
        f"spheroseg batch: the Dask scheduler at {address} was lost, or has cancelled the work; go "
        "on with --resume\n"
    )


def test_batches_on_one_scheduler_get_their_own_results(tmp_path):
    distributed = pytest.importorskip("distributed")
    write_mesh(tmp_path / "in" / "a.ply")
    with (
        dask_cluster(tmp_path) as (address, start_worker, _),
        distributed.Client(address, set_as_default=False) as client,
    ):
        processes = [
            start_batch(
                tmp_path / "in", "-o", tmp_path / f"out{k}", "-k", k, "--scheduler", address
            )
            for k in (3, 8)
        ]
        wait_for_batches(client, 2)
        start_worker()
        said = [process.communicate(timeout=120) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], said
    for k in (3, 8):
        assert [row["submesh_count"] for row in rows(tmp_path / f"out{k}")] == [str(k)]
        assert (tmp_path / f"out{k}" / "a.ply").exists()


def test_a_result_of_other_settings_is_refused(tmp_path):
    job = jobs.Job("a.ply", "a", str(tmp_path), {"submesh_count": 3}, (".ply",), {})
    own, other = ({"settings": job.settings() | {"options": {"submesh_count": k}}} for k in (3, 8))
    own |= {"status": "failed", "input_sha256": None}
    results = runner._ResultsOfCluster()
    assert results.checked(job, own) is own
    refused = results.checked(job, other)
    assert (refused["status"], refused["settings"]) == ("failed", job.settings())
    assert "other settings" in refused["error"]


def test_results_that_stay_on_the_worker_are_failures(tmp_path, monkeypatch, capsys):
    pytest.importorskip("distributed")
    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    output = tmp_path / "out"
    arguments = ["batch", str(tmp_path / "in"), "-o", str(output)]
    assert main([*arguments, "-k", "3"]) == 0
    (tmp_path / "own_disk.py").write_text(
        "import dataclasses\nfrom spheroseg.batch import jobs\n"
        "def run_job(job, place, run=jobs.run_job):\n"
        f"    folder = {str(tmp_path / 'elsewhere')!r}\n"
        "    return run(dataclasses.replace(job, folder=folder), place)\n"
        "jobs.run_job = run_job\n"
    )
    monkeypatch.setattr(runner, "_ARRIVAL_SECONDS", 0.5, raising=False)
    own_disk = ("--preload", tmp_path / "own_disk.py")
    with dask_cluster(tmp_path, *own_disk) as (address, start_worker, _):
        start_worker()
        assert main([*arguments, "-k", "8", "--resume", "--scheduler", address]) == 1
    said = capsys.readouterr().err
    assert said.count("DIR must be a folder that all machines share") == 2
    assert f"done on {socket.gethostname()}, but the result is not in {output} here" in said
    assert [row["status"] for row in rows(output)] == ["failed", "failed"]
    assert (tmp_path / "elsewhere" / "a.ply").exists()


def test_a_worker_keeps_a_nursery_for_a_batch_and_ends_it(tmp_path):
    distributed = pytest.importorskip("distributed")
    write_mesh(tmp_path / "a.ply")
    arguments = ["batch", str(tmp_path / "a.ply"), "-k", "3", "-o"]
    with dask_cluster(tmp_path, "--no-nanny") as (address, start_worker, _):
        worker = start_worker()
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
        before = children(worker.pid)
        nurseries = []
        for name in ("first", "second"):
            assert main([*arguments, str(tmp_path / name), "--scheduler", address]) == 0
            (found,) = children(worker.pid) - before
            nurseries.append(found)
        worker.terminate()
        worker.wait()
        wait_until(lambda: not any(map(is_running, nurseries)))
    assert nurseries[0] != nurseries[1]


@pytest.mark.parametrize(
    ("preload", "error"),
    [
        (
            "import dataclasses\nfrom spheroseg.batch import jobs\n"
            "def run_job(job, place, run=jobs.run_job):\n"
            "    return run(dataclasses.replace(job, mesh='/nowhere/a.ply'), place)\n"
            "jobs.run_job = run_job\n",
            "no such file on {host}, but here: each worker must see it, too",
        ),
        (
            "import sys\nsys.modules['spheroseg.batch.jobs'] = None\n",
            "ImportError: on {host}: import of spheroseg.batch.jobs halted; None in sys.modules",
        ),
    ],
)
def test_a_worker_that_lacks_what_a_mesh_needs_is_named(preload, error, tmp_path):
    pytest.importorskip("distributed")
    write_mesh(tmp_path / "a.ply")
    (tmp_path / "lacking.py").write_text(preload)
    output = tmp_path / "out"
    with dask_cluster(tmp_path, "--preload", tmp_path / "lacking.py") as (address, start_worker, _):
        start_worker()
        arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(output)]
        assert main([*arguments, "--scheduler", address]) == 1
    assert [row["error"] for row in rows(output)] == [error.format(host=socket.gethostname())]


def test_a_mesh_that_is_done_stays_so_when_its_workers_die_with_others(tmp_path, monkeypatch):
    class Future:
        def exception(self):
            return RuntimeError("all those workers died")

        def release(self):
            pass

    class Client:
        def submit(self, *_, **__):
            return Future()

        def cancel(self, _):
            pass

    monkeypatch.setattr(runner, "_as_completed", lambda client, submitted, on_idle: submitted)
    write_mesh(tmp_path / "a.ply")
    settings = {}, (".npy",), jobs.versions()
    both = [
        jobs.Job(str(tmp_path / "a.ply"), name, str(tmp_path / "out"), *settings) for name in "ab"
    ]
    with jobs.nursery() as place:
        jobs.run_job(both[0], place)
    done, failed = runner._on_dask(both, Client(), "tcp://host:1", print)
    assert (done["name"], done["status"], done["error"]) == ("a", "done", "")
    assert (failed["name"], failed["status"]) == ("b", "failed")
    assert failed["error"] == "RuntimeError: all those workers died"


def test_a_result_that_a_network_shows_late_is_waited_for(tmp_path):
    job = jobs.Job("a.ply", "a", str(tmp_path), {}, (".ply",), {})
    record = {"status": "done", "settings": job.settings(), "outputs": {"a.ply": ""}}
    record |= {"input_sha256": ""}
    jobs.store(job, record | {"seconds": 1.0})
    with futures.ThreadPoolExecutor() as network:
        shown = network.submit(lambda: (time.sleep(0.4), (tmp_path / "a.ply").touch()))
        assert runner._ResultsOfCluster().checked(job, record) is record
        shown.result()


def test_absent_scheduler_is_said_in_one_line(tmp_path, capsys):
    pytest.importorskip("distributed")
    write_mesh(tmp_path / "a.ply")
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out")]
    assert main([*arguments, "--scheduler", "carrier-pigeon"]) == 2
    said = capsys.readouterr().err
    assert "no Dask scheduler answers at carrier-pigeon" in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == [tmp_path / "a.ply"]
    assert main([*arguments, "-k", "2"]) == 0, "nothing was done, so that nothing is to be resumed"


def test_an_address_that_is_none_is_said_soon_and_without_a_traceback(tmp_path):
    pytest.importorskip("distributed")
    write_mesh(tmp_path / "a.ply")
    for address in ("foo", "abc://host:1"):
        began = time.monotonic()
        code, _, said = run_batch(
            tmp_path / "a.ply", "-o", tmp_path / "out", "--scheduler", address
        )
        assert (code, said.count("\n")) == (2, 1)
        assert f"no Dask scheduler answers at {address}: " in said
        assert time.monotonic() - began < 10


def test_what_is_no_scheduler_is_said_in_one_line(tmp_path, monkeypatch, capsys):
    pytest.importorskip("distributed")
    dask_config = pytest.importorskip("dask.config")
    monkeypatch.setattr(runner, "_ANSWER_SECONDS", 1, raising=False)
    write_mesh(tmp_path / "a.ply")

    def said_of(address: str) -> str:
        arguments = ["-o", str(tmp_path / "out"), "--scheduler", address]
        began = time.monotonic()
        assert main(["batch", str(tmp_path / "a.ply"), *arguments]) == 2
        assert time.monotonic() - began < 10
        said = capsys.readouterr().err
        assert said.count("\n") == 1
        assert f"no Dask scheduler answers at {address}: " in said
        return said

    with socket.create_server(("127.0.0.1", 0)) as silent:  # accepts, and says nothing
        assert "speaks no Dask" in said_of(f"tcp://127.0.0.1:{silent.getsockname()[1]}")
    assert "TLS" in said_of("tls://127.0.0.1:1")
    with dask_config.set({"distributed.comm.require-encryption": True}):
        assert "encryption required" in said_of("tcp://127.0.0.1:1")


def test_the_address_of_a_worker_is_said_to_be_one(tmp_path, capsys):
    distributed = pytest.importorskip("distributed")
    write_mesh(tmp_path / "a.ply")
    with dask_cluster(tmp_path) as (address, start_worker, _):
        start_worker()
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(1, timeout=60)
            (worker,) = client.scheduler_info()["workers"]
        arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out")]
        assert main([*arguments, "--scheduler", worker]) == 2
    assert f"answers at {worker}: it is the address of a Worker\n" in capsys.readouterr().err
