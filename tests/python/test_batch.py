# SPDX-License-Identifier: GPL-3.0-or-later
from __future__ import annotations

import contextlib
import dataclasses
import errno
import fcntl
import hashlib
import json
import os
import shlex
import shutil
import signal
import socket
import subprocess
import sys
from concurrent import futures
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from batches import rows, run_batch, start_batch, wait_for_records, write_finned, write_mesh
from colours import bytes_of_linear
from processes import children, is_running, jobs_of, run_python, run_shell, wait_until
from shapes import bumpy_sphere, octahedron

import spheroseg
from spheroseg import atomic, cores, digests, workers
from spheroseg.batch import inputs, jobs, runner
from spheroseg.cli import main
from spheroseg.errors import InputError
from spheroseg.ply import ply_bytes

GOOD, BROKEN = 8, 3


@pytest.fixture(scope="module")
def folder_of_meshes(tmp_path_factory) -> Path:
    """Eight closed meshes and three broken ones: no mesh file, one with a fin, a truncated one."""
    folder = tmp_path_factory.mktemp("meshes")
    for index in range(GOOD):
        write_mesh(folder / f"part{index % 4}" / f"mesh{index:02d}.ply", seed=index)
    (folder / "part0" / "nonsense.ply").write_text("no mesh")
    write_finned(folder / "part1" / "fin.ply")
    whole = ply_bytes(*bumpy_sphere(2, 0))
    (folder / "part2" / "cut.ply").write_bytes(whole[: len(whole) // 2])
    return folder


@pytest.fixture(scope="module")
def undisturbed(folder_of_meshes, tmp_path_factory) -> tuple[Path, str]:
    output = tmp_path_factory.mktemp("undisturbed") / "out"
    code, said, complained = run_batch(folder_of_meshes, "-o", output, "-k", 5)
    assert code == 1
    assert f"{GOOD} of {GOOD + BROKEN} meshes done" in said
    return output, complained


def test_broken_meshes_cost_one_line_each_and_the_others_are_done(undisturbed):
    output, complained = undisturbed
    lines = complained.strip().splitlines()
    assert len(lines) == BROKEN
    assert [name in complained for name in ("nonsense.ply", "fin.ply", "cut.ply")] == [True] * 3
    status = [row["status"] for row in rows(output)]
    assert (status.count("done"), status.count("failed")) == (GOOD, BROKEN)
    for row in [row for row in rows(output) if row["status"] == "failed"]:
        assert row["error"]
        assert row["input_sha256"] == hashlib.sha256(Path(row["mesh"]).read_bytes()).hexdigest()


def test_manifest_tells_the_truth_about_each_result(undisturbed):
    output, _ = undisturbed
    for row in [row for row in rows(output) if row["status"] == "done"][::3]:
        result = output / row["outputs"]
        assert hashlib.sha256(result.read_bytes()).hexdigest() == row["output_sha256"]
        source = Path(row["mesh"]).read_bytes()
        assert hashlib.sha256(source).hexdigest() == row["input_sha256"]
        meshes = pymeshlab.MeshSet()
        meshes.load_new_mesh(str(result))
        labels = meshes.current_mesh().face_scalar_array().astype(int)
        counts = np.bincount(labels)
        assert len(counts) == int(row["submesh_count"]) == 5
        assert counts.max() - counts.min() == int(row["max_triangle_count_difference"]) == 1
        vertices, faces = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
        measures = spheroseg.measure(vertices, faces, labels)
        assert measures["boundary_edge_count"] == int(row["boundary_edge_count"])
        assert meshes.current_mesh().has_face_color()


@pytest.mark.parametrize("enough", [1, GOOD // 2])
def test_killed_and_resumed_run_gives_the_manifest_of_an_undisturbed_one(
    enough, folder_of_meshes, undisturbed, tmp_path
):
    output = tmp_path / "out"
    process = start_batch(folder_of_meshes, "-o", output, "-k", 5, "--workers", 2)
    wait_for_records(output, enough, process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    finished = {
        path: path.stat().st_mtime_ns
        for path in (output / jobs.RECORD_FOLDER).rglob("[!.]*.json")
        if json.loads(path.read_text())["status"] == "done"
    }
    assert len(finished) < GOOD
    assert not (output / "manifest.csv").exists()
    stale = f".0.{process.pid}@{socket.gethostname()}{atomic.TEMPORARY_SUFFIX}"
    (output / stale).write_text("half")

    code, _, _ = run_batch(folder_of_meshes, "-o", output, "-k", 5, "--resume")
    assert code == 1
    assert (output / "manifest.csv").read_bytes() == (undisturbed[0] / "manifest.csv").read_bytes()
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    assert not list(output.rglob("*.spheroseg-part"))


def test_no_process_outlives_a_killed_batch(tmp_path):
    write_mesh(tmp_path / "a.ply", levels=7)
    options = ["-k", 20, "--effort", "high", "--threads", 1]
    process = start_batch(tmp_path / "a.ply", "-o", tmp_path / "out", *options)
    workers = set()
    try:
        wait_until(lambda: jobs_of(process.pid))
        workers = children(process.pid) | jobs_of(process.pid)
        process.kill()
        process.communicate()
        wait_until(lambda: not any(map(is_running, workers)))
        assert not list(tmp_path.glob("out/*.ply"))  # they did not end by themselves
    finally:
        process.kill()
        for worker in filter(is_running, workers):
            os.kill(worker, signal.SIGKILL)


def test_resume_does_again_what_changed_and_nothing_else(tmp_path, monkeypatch):
    for index in range(5):
        write_mesh(tmp_path / "in" / f"mesh{index}.ply", seed=index)
    output = tmp_path / "out"
    records = output / jobs.RECORD_FOLDER
    arguments = ["batch", str(tmp_path / "in"), "-o", str(output), "--workers", "2"]
    assert main([*arguments, "-k", "4"]) == 0
    before = {path.name: path.stat().st_mtime_ns for path in records.glob("*.json")}
    write_mesh(tmp_path / "in" / "mesh1.ply", seed=99)
    (output / "mesh2.ply").unlink()
    (output / "mesh3.ply").write_bytes(b"damaged")
    assert main([*arguments, "-k", "4", "--resume"]) == 0
    after = {path.name: path.stat().st_mtime_ns for path in records.glob("*.json")}
    assert {name for name in before if before[name] != after[name]} == {
        "mesh1.json",
        "mesh2.json",
        "mesh3.json",
    }
    # Other settings make every result another one.
    assert main([*arguments, "-k", "6", "--resume"]) == 0
    assert {row["submesh_count"] for row in rows(output)} == {"6"}


def test_resume_does_again_what_failed(tmp_path):
    write_mesh(tmp_path / "a.ply", levels=6)
    arguments = [tmp_path / "a.ply", "-o", tmp_path / "out", "-k", 20, "--effort", "high"]
    process = start_batch(*arguments)
    wait_until(lambda: jobs_of(process.pid))
    for job in jobs_of(process.pid):
        os.kill(job, signal.SIGKILL)
    process.communicate()
    assert process.returncode == 1
    assert [row["status"] for row in rows(tmp_path / "out")] == ["failed"]
    assert run_batch(*arguments, "--resume")[0] == 0
    assert [row["status"] for row in rows(tmp_path / "out")] == ["done"]


def test_resume_with_other_formats_leaves_nothing_that_contradicts_it(tmp_path):
    output = tmp_path / "out"
    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(output)]
    assert main([*arguments, "-k", "4", "--formats", "ply,npy"]) == 0
    (tmp_path / "in" / "b.ply").unlink()
    (output / "a.txt").write_text("of somebody else")
    arguments += ["-k", "3", "--formats", "npy", "--manifest", "parquet", "--resume"]
    assert main(arguments) == 0
    assert {path.name for path in output.iterdir() if path.is_file()} == {
        "a.npy",
        "a.txt",
        "b.npy",
        "b.ply",
        "manifest.parquet",
        "timings.csv",
    }
    # A result that has become an input is kept.
    arguments = ["batch", str(output / "b.ply"), "-o", str(output), "--formats", "npy", "--resume"]
    assert main([*arguments, "-k", "5"]) == 0
    assert (output / "b.ply").is_file()


def test_the_same_settings_in_other_words_change_nothing(tmp_path):
    output = tmp_path / "out"
    write_mesh(tmp_path / "a.ply")
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(output), "-k", "4"]
    assert main([*arguments, "--formats", "ply,npy"]) == 0
    manifest = (output / "manifest.csv").read_bytes()
    before = (output / "a.ply").stat().st_mtime_ns
    said = ["--seed", "0", "--time-limit", "0", "--method", "fast", "--effort", "standard"]
    said += ["--device", "auto", "--max-refinement-iterations", "0"]
    assert main([*arguments, "--formats", "npy,ply,npy", *said, "--resume"]) == 0
    assert (output / "a.ply").stat().st_mtime_ns == before
    assert (output / "manifest.csv").read_bytes() == manifest


def test_what_is_wrong_for_every_mesh_is_said_once_and_costs_no_result(tmp_path, capsys):
    output = tmp_path / "out"
    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(output), "-k", "4"]
    assert main(arguments) == 0
    before = {path: path.read_bytes() for path in output.iterdir() if path.is_file()}
    capsys.readouterr()
    for wrong, words in (
        (["--method", "all_pairs", "--balance", "weight"], 'method "fast" with balance "weight"'),
        (["--time-limit", "-1"], "time_limit_seconds must be 0 or more"),
        (["--threads", "-1"], "thread_count must be 0 or more"),
        (["-k", "0"], "submesh_count must be 1 or more"),
        (["--workers", "0"], "--workers must be 1 or more, got 0"),
    ):
        assert main([*arguments, *wrong, "--resume"]) == 2
        said = capsys.readouterr().err
        assert words in said
        assert said.count("\n") == 1
        assert {path: path.read_bytes() for path in output.iterdir() if path.is_file()} == before


def test_no_run_replaces_or_removes_a_file_that_no_batch_has_written(tmp_path, capsys):
    output = tmp_path / "out"
    write_mesh(tmp_path / "in" / "a.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(output), "-k", "4", "--formats", "npy"]
    assert main(arguments) == 0
    (output / "b.npy").write_text("of somebody else")
    for content in ("a mesh that is none", None):
        write_mesh(tmp_path / "in" / "b.ply")
        if content:
            (tmp_path / "in" / "b.ply").write_text(content)
        capsys.readouterr()
        assert main([*arguments, "--resume"]) == 2
        assert "b.npy: is there already, and the result of" in capsys.readouterr().err
        assert (output / "b.npy").read_text() == "of somebody else"
    (output / "b.npy").unlink()
    assert main([*arguments, "--resume"]) == 0
    assert len(np.load(output / "b.npy")) == len(np.load(output / "a.npy"))


@pytest.mark.parametrize("stream", ["2>/dev/full", "2> >(true)"])
def test_failures_that_can_not_be_said_hold_nothing_up(stream, tmp_path):
    for index in range(3):
        write_mesh(tmp_path / "in" / f"good{index}.ply")
        (tmp_path / "in" / f"bad{index}.ply").write_text("no mesh")
    arguments = ["batch", tmp_path / "in", "-o", tmp_path / "out", "-k", 4, "--workers", 1]
    done = run_shell(f'"$@" {stream}', *arguments)
    assert done.returncode == 1
    assert "3 of 6 meshes done" in done.stdout
    assert [row["status"] for row in rows(tmp_path / "out")] == ["failed"] * 3 + ["done"] * 3


def test_a_mesh_whose_name_has_two_lines_fails_in_one(tmp_path):
    mesh = tmp_path / "in" / "two\nlines.ply"
    mesh.parent.mkdir()
    mesh.write_text("no mesh")
    write_mesh(tmp_path / "in" / "z.ply")
    code, _, complained = run_batch(tmp_path / "in", "-o", tmp_path / "out", "-k", 4)
    assert code == 1
    assert complained.count("\n") == 1
    assert complained.startswith(f"failed: {tmp_path}/in/two lines.ply: ")
    assert complained.count("lines.ply") == 1


@pytest.mark.parametrize("is_there", [True, False])
def test_a_mesh_that_is_there_and_fails_keeps_no_result_of_an_earlier_run(is_there, tmp_path):
    output = tmp_path / "out"
    meshes = [tmp_path / f"{name}.ply" for name in ("a", "b")]
    for mesh in meshes:
        write_mesh(mesh)
    arguments = ["batch", *map(str, meshes), "-o", str(output), "-k", "4", "--formats", "ply,npy"]
    assert main(arguments) == 0
    (output / "b.txt").write_text("of somebody else")
    if is_there:
        meshes[1].write_text("no mesh")
    else:
        meshes[1].unlink()
    assert main([*arguments, "--resume"]) == 1
    assert [row["status"] for row in rows(output)] == ["done", "failed"]
    kept = {"a.ply", "a.npy", "b.txt"} | (set() if is_there else {"b.ply", "b.npy"})
    assert {path.name for path in output.glob("[ab].*")} == kept
    write_mesh(meshes[1])
    assert main([*arguments, "--resume"]) == 0
    assert (output / "b.ply").is_file()


def test_a_result_that_can_not_be_removed_costs_only_its_mesh(tmp_path, monkeypatch, capsys):
    def refuse(job):
        raise PermissionError(errno.EACCES, "Permission denied", job.name)

    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "--workers", "1"]
    assert main([*arguments, "-k", "4"]) == 0
    (tmp_path / "in" / "a.ply").write_text("no mesh")
    monkeypatch.setattr(runner, "remove_results", refuse)  # root may remove all
    assert main([*arguments, "-k", "5", "--resume"]) == 1
    reason = "; an earlier result stays: [Errno 13] Permission denied: 'a'"
    assert capsys.readouterr().err.endswith(f"{reason}\n")
    assert [row["status"] for row in rows(tmp_path / "out")] == ["failed", "done"]
    assert rows(tmp_path / "out")[0]["error"].endswith(reason)


def test_records_that_can_not_be_written_are_said_first_and_cost_no_result(
    tmp_path, monkeypatch, capsys
):
    def guarded(path, check=atomic.check_place):
        if path.parent == output / jobs.RECORD_FOLDER:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        check(path)

    write_mesh(tmp_path / "a.ply")
    output = tmp_path / "out"
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(output)]
    assert main([*arguments, "-k", "4"]) == 0
    monkeypatch.setattr(atomic, "check_place", guarded)  # root may write all
    assert main([*arguments, "-k", "5", "--resume"]) == 2
    assert capsys.readouterr().err == f"spheroseg batch: {output}/.records: Permission denied\n"
    assert (output / "a.ply").exists()


def test_a_result_that_has_become_an_input_is_kept_when_it_fails(tmp_path):
    output = tmp_path / "out"
    write_mesh(tmp_path / "a.ply")
    assert main(["batch", str(tmp_path / "a.ply"), "-o", str(output), "-k", "4"]) == 0
    (output / "a.ply").write_text("no mesh")
    arguments = ["batch", str(output / "a.ply"), "-o", str(output), "--formats", "npy"]
    assert main([*arguments, "--resume"]) == 1
    assert (output / "a.ply").read_text() == "no mesh"


def test_a_resumed_run_names_the_meshes_where_they_are_now(tmp_path, monkeypatch):
    write_mesh(tmp_path / "old" / "a.ply")
    output = tmp_path / "out"
    arguments = ["-o", str(output), "-k", "4"]
    assert main(["batch", str(tmp_path / "old"), *arguments]) == 0
    (tmp_path / "old").rename(tmp_path / "new")
    monkeypatch.setattr(runner, "run_job", None)  # nothing is done again
    assert main(["batch", str(tmp_path / "new"), *arguments, "--resume"]) == 0
    assert [row["mesh"] for row in rows(output)] == [str(tmp_path / "new" / "a.ply")]
    timings = (output / "timings.csv").read_text()
    assert str(tmp_path / "new" / "a.ply") in timings
    assert "old" not in timings


def test_resume_does_again_what_another_plugin_did(tmp_path, monkeypatch):
    write_mesh(tmp_path / "a.ply")
    monkeypatch.setenv("SPHEROSEG_PLUGIN", shutil.copy(spheroseg.plugin_path(), tmp_path))
    output = tmp_path / "out"
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(output), "-k", "4"]
    assert main(arguments) == 0
    record = output / jobs.RECORD_FOLDER / "a.json"
    before = record.stat().st_mtime_ns
    assert main([*arguments, "--resume"]) == 0
    assert record.stat().st_mtime_ns == before
    plugin = spheroseg.plugin_path()
    assert rows(output)[0]["plugin"] == digests.sha256(plugin)[:12]
    # A byte after the end changes nothing that is loaded.
    (tmp_path / "other").write_bytes(plugin.read_bytes() + b"\0")
    monkeypatch.setenv("SPHEROSEG_PLUGIN", str(tmp_path / "other"))
    assert main([*arguments, "--resume"]) == 0
    assert record.stat().st_mtime_ns != before
    assert rows(output)[0]["plugin"] == digests.sha256(tmp_path / "other")[:12]


@pytest.mark.parametrize(
    ("meshes", "options", "workers", "threads"),
    [
        (1, [], 1, 8),
        (3, [], 3, 2),
        (9, [], 8, 1),
        (9, ["--workers", "2"], 2, 4),
        (1, ["--workers", "4"], 1, 8),
        (9, ["--workers", "20"], 9, 1),
        (1, ["--threads", "3"], 1, 3),
        (1, ["--scheduler", "tcp://127.0.0.1:1"], 1, 1),
    ],
)
def test_the_cores_of_this_process_are_shared_out_among_the_meshes(
    meshes, options, workers, threads, tmp_path, monkeypatch
):
    for index in range(meshes):
        (tmp_path / f"{index}.ply").touch()
    planned = []

    def plan(jobs, _, *, worker_count, **others):
        planned.append((len(jobs), worker_count, {job.thread_count for job in jobs}))
        raise InputError("that will do")

    monkeypatch.setattr(cores, "_GROUPS", tmp_path / "no limits")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    monkeypatch.setattr(runner, "run_all", plan)
    monkeypatch.setattr(runner, "cluster", contextlib.nullcontext)
    assert main(["batch", str(tmp_path), "-o", str(tmp_path / "out"), *options]) == 2
    assert planned == [(meshes, workers, {threads})]


@pytest.mark.parametrize(
    ("files", "count"),
    [
        ({}, 8),
        ({"cpu.max": "max 100000"}, 8),
        ({"cpu.max": "250000 100000"}, 3),
        ({"cpu.max": "10000 100000"}, 1),
        ({"cpu.max": "6400000 100000"}, 8),
        ({"cpu.max": "400000 100000", "pod/cpu.max": "max 100000"}, 4),
        ({"pod/job/cpu.max": "200000 100000", "pod/cpu.max": "300000 100000"}, 2),
        ({"pod/job/other/cpu.max": "100000 100000"}, 8),
        ({"cpu/cpu.cfs_quota_us": "200000", "cpu/cpu.cfs_period_us": "100000"}, 2),
        ({"cpu/cpu.cfs_quota_us": "-1", "cpu/cpu.cfs_period_us": "100000"}, 8),
    ],
)
def test_a_share_of_the_time_of_the_cores_counts_as_so_many(files, count, tmp_path, monkeypatch):
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(f"{text}\n")
    (tmp_path / "own").write_text("1:cpu:/\n0::/pod/job\n")
    monkeypatch.setattr(cores, "_GROUPS", tmp_path)
    monkeypatch.setattr(cores, "_OWN_GROUP", tmp_path / "own")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    assert (cores.busy_core_count(), cores.core_count()) == (count, 8)


@pytest.mark.parametrize("more", [[], ["--resume"]])
def test_a_second_batch_in_a_folder_is_refused_while_the_first_one_lives(more, tmp_path):
    write_mesh(tmp_path / "a.ply")
    write_mesh(tmp_path / "b.ply", levels=7)
    output = tmp_path / "out"
    effort = ["-k", 20, "--effort", "high", "--workers", 1]
    first = start_batch(tmp_path / "a.ply", tmp_path / "b.ply", "-o", output, *effort)
    try:
        wait_for_records(output, 1, first)
        second = [tmp_path / "a.ply", "-o", output, "-k", 3]
        code, _, complained = run_batch(*second, *more)
        assert code == 2
        assert complained == (
            f"spheroseg batch: {output}: another batch writes there; wait until it is done, or "
            f"name another folder (process {first.pid} on {socket.gethostname()})\n"
        )
    finally:
        first.kill()
        first.communicate()
    assert run_batch(*second, "--resume")[0] == 0
    assert [row["submesh_count"] for row in rows(output)] == ["3"]


def test_a_file_system_without_locks_is_no_obstacle(tmp_path, monkeypatch):
    def flock(*_):
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)
    write_mesh(tmp_path / "a.ply")
    assert main(["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out"), "-k", "3"]) == 0


def test_earlier_results_are_not_overwritten_unasked(tmp_path, capsys):
    write_mesh(tmp_path / "a.ply")
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out"), "-k", "3"]
    assert main(arguments) == 0
    assert main(arguments) == 2
    assert "add --resume" in capsys.readouterr().err


def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    write_mesh(tmp_path / "a.ply")
    pipe = tmp_path / "pipe.ply"
    os.mkfifo(pipe)
    for more in ([], ["--resume"]):
        process = start_batch(pipe, tmp_path / "a.ply", "-o", tmp_path / "out", "-k", 3, *more)
        try:
            _, complained = process.communicate(timeout=60)
        finally:
            process.kill()
        assert process.returncode == 1
        assert f"failed: {pipe}: is no ordinary file\n" in complained
    assert [row["status"] for row in rows(tmp_path / "out")] == ["failed", "done"]


def test_a_folder_that_can_not_be_read_is_an_error_and_not_left_out(tmp_path, monkeypatch):
    write_mesh(tmp_path / "a.ply")
    locked = tmp_path / "locked"
    locked.mkdir()
    scan = os.scandir

    def guarded(path):
        if Path(path) == locked:
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return scan(path)

    assert len(inputs.collect([str(tmp_path)])) == 1
    monkeypatch.setattr(os, "scandir", guarded)  # root may read all
    with pytest.raises(InputError, match="locked: the folder can not be read .Permission denied"):
        inputs.collect([str(tmp_path)])


def test_modules_of_the_current_folder_are_not_run(tmp_path):
    write_mesh(tmp_path / "a.ply")
    for name in ("numbers", "json", "numpy"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'ran')!r}, 'w')\n")
    command = [sys.executable, "-P", "-m", "spheroseg", "batch", "a.ply", "-o", "out", "-k", "3"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "ran").exists()


def test_a_mesh_that_is_absent_fails_beside_others_and_with_resume(tmp_path, capsys):
    write_mesh(tmp_path / "a.ply")
    gone = str(tmp_path / "gone.ply")
    output = ["-o", str(tmp_path / "out"), "-k", "3"]
    assert main(["batch", gone, str(tmp_path / "a.ply"), *output]) == 1
    assert f"failed: {gone}: no such file\n" in capsys.readouterr().err
    assert [row["status"] for row in rows(tmp_path / "out")] == ["failed", "done"]
    assert main(["batch", gone, *output, "--resume"]) == 1
    assert f"failed: {gone}: no such file\n" in capsys.readouterr().err


def test_a_mesh_that_can_not_be_asked_for_costs_one_row(tmp_path):
    write_mesh(tmp_path / "a.ply")
    (tmp_path / "list.csv").write_text(f"mesh\n{300 * 'x'}/b.ply\na.ply\n")
    assert main(["batch", str(tmp_path / "list.csv"), "-o", str(tmp_path / "out"), "-k", "3"]) == 1
    assert [row["status"] for row in rows(tmp_path / "out")] == ["failed", "done"]


def test_a_run_without_a_result_leaves_the_folder_free(tmp_path, capsys):
    output = ["-o", str(tmp_path / "out"), "-k", "3"]
    (tmp_path / "torn.ply").write_text("ply\n")
    assert main(["batch", str(tmp_path / "torn.ply"), *output]) == 1
    assert f"failed: {tmp_path / 'torn.ply'}: " in capsys.readouterr().err
    write_mesh(tmp_path / "a.ply")
    assert main(["batch", str(tmp_path / "a.ply"), *output]) == 0
    assert [row["status"] for row in rows(tmp_path / "out")] == ["done"]


def test_a_folder_may_be_called_like_a_record(tmp_path, capsys):
    write_mesh(tmp_path / "in" / "scans.json" / "a.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "-k", "3"]
    assert main(arguments) == 0
    assert main(arguments) == 2
    assert "add --resume" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("names", "place", "needs", "other"),
    [
        ([".lock/a.ply", "a.ply"], ".records/.lock", "record", "the lock"),
        ([".results/a.ply", "a.ply"], ".records/.results", "record", "the list of results"),
        (["a.json/a.ply", "a.ply"], ".records/a.json", "record", "the record of {in}/a.ply"),
        (["a.obj", "a.ply/a.obj"], "a.ply", "result", "the result of {in}/a.obj"),
        (["manifest.csv/a.ply", "a.ply"], "manifest.csv", "result", "the manifest"),
    ],
)
def test_a_folder_that_the_batch_needs_for_a_file_is_said_first(
    names, place, needs, other, tmp_path, capsys
):
    for name in names:
        write_octahedron_obj(tmp_path / "in" / name)
    meshes = tmp_path / "in" / "list.csv"
    meshes.write_text("\n".join(["mesh", *names]))
    output = tmp_path / "out"
    assert main(["batch", str(meshes), "-o", str(output), "-k", "3"]) == 2
    nested = next(tmp_path / "in" / name for name in names if "/" in name)
    assert capsys.readouterr().err == (
        f"spheroseg batch: {output / place}: the {needs} of {nested} needs such a folder, but "
        f"{other.replace('{in}', str(tmp_path / 'in'))} lies there; rename the folder or file of "
        "the mesh\n"
    )
    assert not output.exists()


def test_formats_may_have_blanks_between_them(tmp_path):
    write_mesh(tmp_path / "a.ply")
    output = tmp_path / "out"
    formats = ["--formats", "ply, npy"]
    assert main(["batch", str(tmp_path / "a.ply"), "-o", str(output), "-k", "3", *formats]) == 0
    assert (output / "a.npy").exists()


def test_a_device_that_is_not_there_is_said_once(tmp_path, capsys):
    write_mesh(tmp_path / "a.ply")
    options = ["-o", str(tmp_path / "out"), "-k", "3", "--device", "cuda"]
    if main(["segment", str(tmp_path / "a.ply"), "-k", "3", "--device", "cuda"]) == 0:
        pytest.skip("there is a usable GPU")
    capsys.readouterr()
    assert main(["batch", str(tmp_path / "a.ply"), *options]) == 2
    assert capsys.readouterr().err.count("Expected a usable CUDA device") == 1
    assert not (tmp_path / "out" / jobs.RECORD_FOLDER).exists()


@pytest.mark.parametrize("link", [None, "symlink_to", "hardlink_to"])
def test_an_input_is_never_replaced_by_a_result(link, tmp_path, capsys):
    write_mesh(tmp_path / "in" / "a.ply")
    before = (tmp_path / "in" / "a.ply").read_bytes()
    output = tmp_path / ("in" if link is None else "out")
    if link:
        output.mkdir()
        getattr(output / "a.ply", link)(tmp_path / "in" / "a.ply")
    assert main(["batch", str(tmp_path / "in"), "-o", str(output), "-k", "5"]) == 2
    said = capsys.readouterr().err
    assert f"{output / 'a.ply'}: is an input, and the result of {tmp_path / 'in' / 'a.ply'}" in said
    assert "name another output folder" in said
    assert said.count("\n") == 1
    assert (tmp_path / "in" / "a.ply").read_bytes() == before
    assert not (output / jobs.RECORD_FOLDER).exists()


def test_a_list_of_meshes_is_never_replaced_by_the_manifest(tmp_path, capsys):
    write_mesh(tmp_path / "data" / "a.ply")
    (tmp_path / "manifest.csv").write_text("mesh\ndata/a.ply\n")
    assert main(["batch", str(tmp_path / "manifest.csv"), "-o", str(tmp_path), "-k", "5"]) == 2
    assert "is an input, and the manifest would replace it" in capsys.readouterr().err
    assert (tmp_path / "manifest.csv").read_text() == "mesh\ndata/a.ply\n"


def test_a_first_run_replaces_no_file_at_all(tmp_path, capsys):
    write_mesh(tmp_path / "in" / "a.ply")
    write_mesh(tmp_path / "in" / "mine" / "a.ply", seed=1)
    before = (tmp_path / "in" / "mine" / "a.ply").read_bytes()
    assert main(["batch", str(tmp_path / "in"), "-o", str(tmp_path / "in" / "mine")]) == 2
    assert "is there already, and the result of" in capsys.readouterr().err
    assert (tmp_path / "in" / "mine" / "a.ply").read_bytes() == before


@pytest.mark.parametrize("source", [".", "in", "in/**/*.ply", "**/*"])
def test_results_below_the_inputs_are_no_inputs(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    arguments = ["batch", source, "-o", "in/results", "-k", "5"]
    assert main(arguments) == 0
    assert main([*arguments, "--resume"]) == 0
    assert [Path(row["mesh"]).name for row in rows(tmp_path / "in/results")] == ["a.ply", "b.ply"]


def write_octahedron_obj(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    vertices, faces = octahedron()
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("source", [".", "*", "*.*"])
def test_results_among_the_inputs_are_no_inputs(source, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name in ("a", "deep/b"):
        write_octahedron_obj(tmp_path / f"{name}.obj")
    meshes = ["a.obj", "b.obj"] if source != "*.*" else ["a.obj"]
    arguments = ["batch", source, "-o", ".", "-k", "2"]
    assert main(arguments) == 0
    manifest = Path("manifest.csv").read_bytes()
    for more in ([], ["--formats", "npy"], ["--formats", "npy"]):
        assert main([*arguments, "--resume", *more]) == 0
        assert [Path(row["mesh"]).name for row in rows(Path())] == meshes
    # One that can not be done any more leaves its earlier result.
    Path("a.obj").write_text("no mesh")
    assert main([*arguments, "--resume"]) == 1
    write_octahedron_obj(tmp_path / "a.obj")
    assert main([*arguments, "--resume"]) == 0
    assert Path("manifest.csv").read_bytes() == manifest
    capsys.readouterr()
    assert main(arguments) == 2
    assert "add --resume" in capsys.readouterr().err


def test_a_mesh_that_is_named_itself_may_lie_in_the_output_folder(tmp_path):
    write_mesh(tmp_path / "a.ply")
    named = [str(tmp_path / "a.ply"), "-o", str(tmp_path), "-k", "5"]
    assert main(["batch", *named, "--formats", "npy"]) == 0
    assert len(np.unique(np.load(tmp_path / "a.npy"))) == 5


def test_a_long_name_is_done_and_one_too_long_costs_only_its_mesh(tmp_path, capsys):
    # 255 bytes are the most that file systems take; the record of the longest one would need 256.
    names = ["a", "long" + 246 * "g", "longer" + 245 * "r", "z"]
    for name in names:
        write_mesh(tmp_path / "in" / f"{name}.ply")
    arguments = ["batch", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "-k", "5"]
    assert main(arguments) == 1
    assert capsys.readouterr().err.count("File name too long") == 1
    found = {Path(row["mesh"]).stem: row["status"] for row in rows(tmp_path / "out")}
    assert found == dict(zip(names, ["done", "done", "failed", "done"], strict=True))
    assert main([*arguments, "--resume"]) == 1


@pytest.mark.parametrize("encoding", ["latin-1", "ascii"])
def test_names_of_failed_meshes_need_no_certain_encoding(encoding, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONIOENCODING", encoding)
    for name in ("a", "größe/b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "größe").touch()  # where a folder should be
    code, said, complained = run_batch(tmp_path / "in", "-o", tmp_path / "out", "-k", 5)
    assert (code, "1 of 2 meshes done" in said) == (1, True)
    assert complained.count("\n") == 1
    assert "größe" in rows(tmp_path / "out")[1]["error"]


def test_a_damaged_record_costs_only_its_mesh(tmp_path):
    job = jobs.Job(str(tmp_path / "a.ply"), "a", str(tmp_path), {}, (".ply",), {})

    class Place:
        def run(self, _):
            job.record_path().parent.mkdir()
            job.record_path().write_bytes(b"\xff")
            return subprocess.CompletedProcess(["python", "worker"], 0, "", "")

    assert jobs.run_job(job, Place())["status"] == "failed"


@pytest.mark.parametrize(
    "edit",
    [
        lambda record: record | {"measures": record["measures"] | {"submesh_count": 7}},
        lambda record: {name: value for name, value in record.items() if name != "measures"},
        lambda record: [record],
        lambda record: None,
    ],
)
def test_a_mesh_whose_record_was_edited_is_done_again(tmp_path, edit):
    write_mesh(tmp_path / "a.ply")
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out"), "-k", "5"]
    assert main(arguments) == 0
    record = tmp_path / "out" / jobs.RECORD_FOLDER / "a.json"
    before = rows(tmp_path / "out")
    record.write_text(json.dumps(edit(json.loads(record.read_text()))))
    began = record.stat().st_mtime_ns
    assert main([*arguments, "--resume"]) == 0
    assert record.stat().st_mtime_ns > began
    assert rows(tmp_path / "out") == before


def ply_colours(path: Path) -> set[tuple]:
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    return set(map(tuple, np.round(255 * meshes.current_mesh().face_color_matrix()).tolist()))


def glb_colours(path: Path) -> set[tuple]:
    pygltflib = pytest.importorskip("pygltflib")
    materials = pygltflib.GLTF2().load(path).materials
    linear = [material.pbrMetallicRoughness.baseColorFactor for material in materials]
    return set(map(tuple, bytes_of_linear(linear).tolist()))


def test_csv_gives_each_mesh_its_own_count_in_every_format(tmp_path):
    write_mesh(tmp_path / "data" / "a.ply")
    write_mesh(tmp_path / "data" / "b.ply", seed=1)
    (tmp_path / "list.csv").write_text(
        "mesh,submesh_count\ndata/a.ply,3\ndata/a.ply,8\ndata/b.ply,\n"
    )
    output = tmp_path / "out"
    code = main(
        ["batch", str(tmp_path / "list.csv"), "-o", str(output), "-k", "5"]
        + ["--formats", "ply,npy,npz,glb", "--manifest", "parquet"]
    )
    assert code == 0
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(output / "manifest.parquet").to_pydict()
    assert table["submesh_count"] == [3, 8, 5]
    for name, count in (("a-k3", 3), ("a-k8", 8), ("b", 5)):
        assert len(np.unique(np.load(output / f"{name}.npy"))) == count
        with np.load(output / f"{name}.npz") as arrays:
            assert len(arrays["vertex_starts"]) == count + 1
        assert len(glb_colours(output / f"{name}.glb") - ply_colours(output / f"{name}.ply")) == 0


def test_a_manifest_lists_failed_meshes_with_the_number_that_was_asked_for(tmp_path):
    write_mesh(tmp_path / "here.ply")
    (tmp_path / "list.csv").write_text("mesh,k\nabsent.ply,5\nhere.ply,7\n")
    assert main(["batch", str(tmp_path / "list.csv"), "-o", str(tmp_path / "out")]) == 1
    write_mesh(tmp_path / "absent.ply")
    manifest = str(tmp_path / "out" / "manifest.csv")
    assert main(["batch", manifest, "-o", str(tmp_path / "again")]) == 0
    assert [row["submesh_count"] for row in rows(tmp_path / "again")] == ["5", "7"]


def test_a_manifest_of_meshes_of_one_name_is_a_list_that_keeps_their_folders(tmp_path):
    for name in ("one/a", "two/a", "b"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    assert main(["batch", str(tmp_path / "in"), "-k", "5", "-o", str(tmp_path / "out")]) == 0
    manifest = str(tmp_path / "out" / "manifest.csv")
    assert main(["batch", manifest, "-o", str(tmp_path / "again")]) == 0
    names = [row["outputs"] for row in rows(tmp_path / "again")]
    assert names == ["b-k5.ply", "one/a-k5.ply", "two/a-k5.ply"]


def test_a_link_to_a_mesh_that_is_not_there_fails(tmp_path):
    write_mesh(tmp_path / "in" / "here.ply")
    (tmp_path / "in" / "broken.ply").symlink_to("nowhere.ply")
    (tmp_path / "in" / "broken.txt").symlink_to("nowhere.txt")
    assert main(["batch", str(tmp_path / "in"), "-k", "3", "-o", str(tmp_path / "out")]) == 1
    status = {Path(row["mesh"]).name: row["status"] for row in rows(tmp_path / "out")}
    assert status == {"broken.ply": "failed", "here.ply": "done"}


def test_a_count_of_a_csv_comes_before_triangles_per_submesh(tmp_path):
    write_mesh(tmp_path / "a.ply")
    (tmp_path / "list.csv").write_text("mesh,k\na.ply,3\n")
    arguments = ["batch", str(tmp_path / "list.csv"), "-o", str(tmp_path / "out")]
    assert main([*arguments, "--triangles-per-submesh", "10"]) == 0
    assert [row["submesh_count"] for row in rows(tmp_path / "out")] == ["3"]


def test_manifest_tells_what_was_balanced_and_how_well(tmp_path):
    vertices, faces = bumpy_sphere(2, 0)
    two = np.vstack([vertices, vertices + 9]), np.vstack([faces, faces + len(vertices)])
    (tmp_path / "two.ply").write_bytes(ply_bytes(*two))
    for balance in ("triangle_count", "weight"):
        output = tmp_path / balance
        options = ["-o", str(output), "-k", "5", "--balance", balance]
        assert main(["batch", str(tmp_path / "two.ply"), *options]) == 0
        (row,) = rows(output)
        assert (row["balance"], row["component_count"]) == (balance, "2")
        # Two sub-meshes share the 128 triangles of one component: 64 each where the mean is 51.2.
        assert float(row["weight_imbalance"]) == pytest.approx(1.25, abs=0.02)
    (row,) = rows(tmp_path / "triangle_count")
    assert row["best_max_triangle_count_difference"] == "22"


def test_names_with_blanks_and_quotes_are_told_apart_in_the_manifest(tmp_path):
    for name in ("plain", "two words", "it's", "a 'b' c"):
        write_mesh(tmp_path / "in" / f"{name}.ply")
    output = tmp_path / "out"
    assert main(["batch", str(tmp_path / "in"), "-o", str(output), "--formats", "ply,npy"]) == 0
    for row in rows(output):
        names, expected = shlex.split(row["outputs"]), row["output_sha256"].split()
        assert [Path(name).suffix for name in names] == [".ply", ".npy"]
        assert {Path(name).stem for name in names} == {Path(row["mesh"]).stem}
        assert [digests.sha256(output / name) for name in names] == expected


def test_full_disk_is_one_clear_line_and_ends_the_run(tmp_path, small_disk):
    for index in range(6):
        write_mesh(tmp_path / "in" / f"mesh{index}.ply", seed=index, levels=4)
    code, _, complained = run_batch(tmp_path / "in", "-o", small_disk / "out", "-k", 4)
    assert code == 1
    lines = complained.strip().splitlines()
    assert len(lines) == 1
    assert "no room left on the disk for" in lines[0]
    assert "--resume" in lines[0]
    assert not list(small_disk.rglob("*.spheroseg-part"))
    for record in (small_disk / "out" / jobs.RECORD_FOLDER).glob("*.json"):
        for file, digest in json.loads(record.read_text())["outputs"].items():
            assert digests.sha256(small_disk / "out" / file) == digest


def test_a_disk_that_is_full_before_the_first_mesh_is_no_bad_usage(tmp_path, small_disk, capsys):
    write_mesh(tmp_path / "a.ply")
    arguments = ["batch", str(tmp_path / "a.ply"), "-o", str(small_disk / "out"), "-k", "4"]
    with contextlib.suppress(OSError):
        (small_disk / "all").write_bytes(bytes(2**20))
    for more in ([], ["--resume"]):
        assert main([*arguments, *more]) == 1
        said = capsys.readouterr().err
        assert (said.count("no room left"), said.count("--resume"), said.count("\n")) == (1, 1, 1)
    (small_disk / "all").unlink()
    assert main([*arguments, "--resume"]) == 0


@pytest.mark.parametrize(
    "option", [("-k", "0"), ("--threads", "-1"), ("--time-limit", "-1"), ("-k", "-3")]
)
def test_what_is_wrong_for_every_mesh_is_said_before_the_first(option, tmp_path, capsys):
    write_mesh(tmp_path / "a.ply")
    assert main(["batch", str(tmp_path / "a.ply"), "-o", str(tmp_path / "out"), *option]) == 2
    said = capsys.readouterr().err
    assert f"found {option[1]}" in said
    assert said.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_format_that_is_not_known_is_said_before_the_first_mesh(tmp_path, capsys):
    write_mesh(tmp_path / "a.ply")
    options = ["-o", str(tmp_path / "out"), "-k", "5", "--formats", "npy, obj"]
    assert main(["batch", str(tmp_path / "a.ply"), *options]) == 2
    said = capsys.readouterr().err
    assert said == "spheroseg batch: --formats knows ply, npy, npz, glb, but not 'obj'\n"
    assert not (tmp_path / "out").exists()


def test_what_is_not_given_is_as_in_segment(tmp_path):
    """That the manifest tells of all options changes none of them."""
    write_mesh(tmp_path / "a.ply", levels=3)
    options = ["-o", str(tmp_path / "out"), "-k", "40", "--formats", "npy"]
    assert main(["batch", str(tmp_path / "a.ply"), *options]) == 0
    labels = spheroseg.segment(*bumpy_sphere(3, 0), submesh_count=40).labels
    assert np.array_equal(np.load(tmp_path / "out" / "a.npy"), labels)


@pytest.mark.parametrize(
    ("package", "options"),
    [
        ("pygltflib", ["--formats", "ply,glb"]),
        ("pyarrow", ["--manifest", "parquet"]),
        ("distributed", ["--scheduler", "tcp://127.0.0.1:1"]),
    ],
)
def test_missing_package_is_said_before_the_first_mesh(
    package, options, tmp_path, monkeypatch, capsys
):
    write_mesh(tmp_path / "a.ply")
    monkeypatch.setitem(sys.modules, package, None)
    output = tmp_path / "out"
    assert main(["batch", str(tmp_path / "a.ply"), "-o", str(output), *options]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert f"needs the package '{package}'" in said
    assert f"pip install {package}'" in said
    assert not output.exists()


def test_missing_packages_are_said_together(tmp_path, monkeypatch, capsys):
    for package in ("pygltflib", "pyarrow"):
        monkeypatch.setitem(sys.modules, package, None)
    options = ["--formats", "glb", "--manifest", "parquet"]
    assert main(["batch", str(tmp_path), "-o", str(tmp_path / "out"), *options]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "'pip install pygltflib pyarrow'" in said
    assert "pip install 'spheroseg[batch,export]'" in said


def test_process_that_dies_is_a_failure_that_names_the_signal(tmp_path):
    job = jobs.Job(str(tmp_path / "a.ply"), "a", str(tmp_path), {}, (".ply",), {})

    class Place:
        def run(self, _):
            return subprocess.CompletedProcess(["python", "worker"], -signal.SIGSEGV, "", "")

    jobs.store(job, jobs.failed_record(job, "", status="done"))  # of an earlier run
    record = jobs.run_job(job, Place())
    assert record["status"] == "failed"
    assert "signal 11" in record["error"]
    assert jobs.read_record(job) == record


def test_process_whose_parent_has_ended_does_nothing(tmp_path):
    write_mesh(tmp_path / "a.ply")
    settings = {}, (".npy",), jobs.versions()
    job = jobs.Job(str(tmp_path / "a.ply"), "a", str(tmp_path / "out"), *settings)
    with subprocess.Popen(["true"]) as ended:
        pass
    done = subprocess.run(
        [sys.executable, "-m", "spheroseg.batch.worker", str(ended.pid)],
        input=json.dumps(dataclasses.asdict(job)) + "\n",
        capture_output=True,
        text=True,
        env=workers.package_environment(),
    )
    assert (done.returncode, done.stdout, done.stderr) == (1, "", "")
    assert not (tmp_path / "out").exists()


def test_a_worker_of_another_version_does_nothing(tmp_path):
    write_mesh(tmp_path / "a.ply")
    settings = {}, (".npy",), jobs.versions() | {"spheroseg": "0.0.9"}
    job = jobs.Job(str(tmp_path / "a.ply"), "a", str(tmp_path / "out"), *settings)
    with jobs.nursery() as place:
        done = place.run(json.dumps(dataclasses.asdict(job)))
    assert done.returncode == 1
    assert f"has spheroseg {spheroseg.__version__} instead of 0.0.9;" in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_the_meshes_of_a_batch_are_done_in_processes_of_few_nurseries(tmp_path, monkeypatch):
    started = []

    def start(*arguments, begin=workers.start):
        started.append(arguments[0])
        return begin(*arguments)

    monkeypatch.setattr(workers, "start", start)
    for i in range(6):
        write_mesh(tmp_path / "in" / f"{i}.ply", seed=i)
    arguments = ["batch", str(tmp_path / "in"), "-o", str(tmp_path / "out"), "-k", "4"]
    assert main([*arguments, "--workers", "2"]) == 0
    assert 1 <= len(started) <= 2
    assert set(started) == {"spheroseg.batch.worker"}


@pytest.mark.parametrize("suffix", ["ply", "obj", "off", "stl"])
def test_what_a_mesh_needs_is_imported_before_its_process_is_forked(suffix, tmp_path):
    write_mesh(tmp_path / "a.ply")
    mesh = tmp_path / f"a.{suffix}"
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(tmp_path / "a.ply"))
    mesh_set.save_current_mesh(str(mesh))
    (tmp_path / "out").mkdir()
    settings = {"submesh_count": 4}, jobs.FORMATS, jobs.versions()
    job = jobs.Job(str(mesh), "a", str(tmp_path / "out"), *settings)
    program = (
        "import sys; from spheroseg.batch import worker; text = sys.argv[1]\n"
        "worker.prepare(text); before = set(sys.modules); code = worker.do(text)\n"
        "others = {name.partition('.')[0] for name in set(sys.modules) - before}\n"
        "print(code, sorted(others - sys.stdlib_module_names))"
    )
    assert run_python("-c", program, json.dumps(dataclasses.asdict(job))).stdout == "0 []\n"


def test_a_thread_keeps_one_nursery_that_of_the_last_batch():
    before = children(os.getpid())
    kept = jobs.kept_nursery("first")
    assert kept.run('{"formats": []}').returncode == 1
    assert len(children(os.getpid()) - before) == 1
    assert jobs.kept_nursery("first") is kept
    with futures.ThreadPoolExecutor() as pool:
        assert pool.submit(jobs.kept_nursery, "first").result() is not kept
    assert jobs.kept_nursery("second") is not kept
    assert children(os.getpid()) == before


def test_names_of_failed_meshes_are_shown_as_they_are(tmp_path, capsys):
    (tmp_path / ":car:[b].ply").write_text("no mesh")
    assert main(["batch", str(tmp_path), "-o", str(tmp_path / "out")]) == 1
    assert ":car:[b].ply" in capsys.readouterr().err


@pytest.mark.parametrize("given", ["in", "in/*", "in/*/*.ply"])
def test_a_found_name_that_is_not_utf_8_costs_one_row(given, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_mesh(Path("in/sub/a.ply"))
    shutil.copy("in/sub/a.ply", os.fsdecode(b"in/sub/bad\xff.ply"))
    reason = "the name is not UTF-8; rename the file or folder"
    shown = f"{tmp_path}/in/sub/bad\\xff.ply"
    for more in ([], ["--resume"]):
        assert main(["batch", given, "-o", "out", "-k", "4", *more]) == 1
        assert capsys.readouterr().err == f"failed: {shown}: {reason}\n"
        found = [(row["mesh"], row["status"], row["error"]) for row in rows(Path("out"))]
        assert found == [(f"{tmp_path}/in/sub/a.ply", "done", ""), (shown, "failed", reason)]
    assert len(list(Path("out").rglob("*.ply"))) == 1


def test_folder_glob_and_file_name_each_mesh_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("deep/er/a.ply", "deep/b.OBJ", "c.off", "notes.txt"):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    found = inputs.collect(["deep", "*.off", "c.off", "deep/er/a.ply"])
    assert [(str(s.mesh), s.name) for s in found] == [
        ("deep/b.OBJ", "b"),
        ("deep/er/a.ply", "er/a"),
        ("c.off", "c"),
    ]


@pytest.mark.parametrize("given", ["in", "in/**/*.ply", "in/**/*", "in/**", "*/**/*.ply", "i?/*"])
def test_links_in_a_circle_give_each_mesh_once(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("in/a.ply", "in/sub/b.ply"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    for link, target in (("to itself", "."), ("sub/up", ".."), ("sub/again", "../sub")):
        (tmp_path / "in" / link).symlink_to(target)
    found = [source.mesh.resolve().name for source in inputs.collect([given])]
    assert sorted(found) == ["a.ply", "b.ply"]


def test_a_mesh_behind_a_link_to_itself_is_one_that_is_not_there(tmp_path):
    (tmp_path / "link").symlink_to("link")
    found = inputs.collect([str(tmp_path / "link" / "a.ply")], tmp_path / "out")
    assert [source.name for source in found] == ["a"]


def test_a_search_follows_no_links_and_takes_nothing_hidden(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = ["in/a.ply", "in/._a.ply", "in/x/y/a.ply", "in/.hidden/a.ply", "other/z/a.ply"]
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "in" / "link").symlink_to("../other")
    for given, count in (
        ("in", 2),
        ("in/.hidden", 1),
        ("in/**/*.ply", 2),
        ("in/**/x/**/*.ply", 1),
        (f"{tmp_path}/i[n]/**/a*", 2),
        ("**/*.ply", 3),
        ("in/link/**/*.ply", 1),
        ("in/**.ply", 1),
    ):
        assert len(inputs.collect([given])) == count, given


@pytest.mark.parametrize("given", ["in", "in/**/*.ply"])
def test_folders_in_one_another_are_searched_up_to_a_limit(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    deepest = Path("in", *["d"] * 200)
    deepest.mkdir(parents=True)
    write_mesh(deepest / "a.ply")
    write_mesh(Path("in/a.ply"))
    assert main(["batch", given, "-o", "out", "-k", "4"]) == 0
    assert main(["batch", given, "-o", "out", "-k", "4", "--resume"]) == 0
    (deepest / "d").mkdir()
    with pytest.raises(InputError, match="^in: more than 200 folders lie in one another there$"):
        inputs.collect([given])


def test_meshes_that_differ_in_suffix_get_different_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a.ply", "a.obj", "b.ply"):
        (tmp_path / name).touch()
    assert [s.name for s in inputs.collect(["."])] == ["a_obj", "a_ply", "b"]


MODELS = ["one/model.obj", "one/model.ply", "two/model.obj", "three/other.obj"]


@pytest.fixture
def models(tmp_path, monkeypatch) -> Path:
    """Files as data sets have them, each in a folder, with a list of them."""
    monkeypatch.chdir(tmp_path)
    for name in MODELS:
        (tmp_path / "set" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "set" / name).touch()
    text = "\n".join(["mesh,k", "one/model.obj,3", "one/model.obj,4", "two/model.obj,3", "x.obj,"])
    (tmp_path / "set" / "list.csv").write_text(text + f"\n{tmp_path / 'x.obj'},\n../y.obj,\n")
    return tmp_path


@pytest.mark.parametrize(
    ("given", "names"),
    [
        (["set/*/model.obj"], ["one/model", "two/model"]),
        (["set/*/*.obj"], ["one/model", "other", "two/model"]),
        (["set/*/*.*"], ["one/model_obj", "one/model_ply", "other", "two/model"]),
        (["set/o*/*.*"], ["model_obj", "model_ply"]),
        (["set/*o"], ["model"]),
        (["set/[ot][nw][eo]"], ["one/model_obj", "one/model_ply", "two/model"]),
        (["set"], ["one/model_obj", "one/model_ply", "three/other", "two/model"]),
    ],
)
def test_meshes_of_one_name_get_their_folders_in_it(given, names, models):
    assert [source.name for source in inputs.collect(given)] == names


def test_meshes_of_one_name_in_a_list_get_their_folders_in_it(models):
    with pytest.raises(InputError, match="would have one name in the output folder"):
        inputs.collect(["set/list.csv"])
    text = (models / "set" / "list.csv").read_text()
    (models / "set" / "list.csv").write_text(text.replace("\nx.obj,", ""))
    names = [source.name for source in inputs.collect(["set/list.csv"])]
    assert names == ["one/model-k3", "model-k4", "two/model-k3", "x", "y"]


def test_a_batch_of_meshes_of_one_name_can_be_resumed(tmp_path):
    for name in ("one", "two"):
        write_octahedron_obj(tmp_path / "set" / name / "model.obj")
    output = tmp_path / "out"
    arguments = ["batch", str(tmp_path / "set/*/model.obj"), "-o", str(output), "-k", "2"]
    assert main(arguments) == 0
    before = {path: path.stat().st_mtime_ns for path in output.glob("*/model.ply")}
    assert [path.parent.name for path in sorted(before)] == ["one", "two"]
    assert main([*arguments, "--resume"]) == 0
    assert {path: path.stat().st_mtime_ns for path in before} == before


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("file\na.ply\n", "must have a column 'mesh', but has file"),
        ("mesh,k\na.ply,0\n", "line 2: expected a whole number from 1 to 2147483647, found '0'"),
        ("mesh,k\na.ply,2147483648\n", "found '2147483648'"),
        ("mesh,k\na.ply,many\n", "found 'many'"),
        ("mesh,k,submesh_count\na.ply,4,5\n", "has columns submesh_count and k; leave one out"),
        ("mesh\n", "names no mesh file"),
    ],
)
def test_wrong_csv_is_refused_with_the_reason(content, message, tmp_path):
    path = tmp_path / "list.csv"
    path.write_text(content)
    with pytest.raises(InputError, match=message):
        inputs.collect([str(path)])


def test_blanks_after_the_commas_of_a_csv_mean_nothing(tmp_path):
    path = tmp_path / "list.csv"
    path.write_text('mesh , submesh_count\na.ply , 10\nb.ply, "7" \n" c.ply",\n')
    found = inputs.collect([str(path)])
    assert [(source.mesh.name, source.submesh_count) for source in found] == [
        ("a.ply", 10),
        ("b.ply", 7),
        ("c.ply", None),
    ]


def test_a_file_of_two_spellings_is_one_mesh(tmp_path):
    write_mesh(tmp_path / "a.ply")
    (tmp_path / "sub").mkdir()
    spellings = [tmp_path / "a.ply", tmp_path / "sub" / ".." / "a.ply"]
    assert len(inputs.collect(list(map(str, spellings)))) == 1


def test_a_csv_may_begin_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "list.csv"
    path.write_text("mesh,k\na.ply,10\n", encoding="utf-8-sig")
    assert [source.submesh_count for source in inputs.collect([str(path)])] == [10]


def test_two_files_for_one_result_are_refused_with_the_remedy(tmp_path):
    files = [str(tmp_path / folder / "a.ply") for folder in ("one", "two")]
    for file in files:
        write_mesh(Path(file))
    with pytest.raises(InputError) as refusal:
        inputs.collect(files)
    assert str(refusal.value).startswith(" and ".join(files))
    assert "give the folder above them or a glob in quotes" in str(refusal.value)
    assert "a_ply" not in str(refusal.value)
    for remedy in (tmp_path, tmp_path / "*" / "a.ply"):
        assert [source.name for source in inputs.collect([str(remedy)])] == ["one/a", "two/a"]


@pytest.mark.parametrize(
    ("files", "two"),
    [
        (["ok.obj", "ok.ply", "ok_obj.ply"], ["ok.obj", "ok_obj.ply"]),
        (["a.PLY", "a.ply"], ["a.PLY", "a.ply"]),
    ],
)
def test_where_suffixes_make_one_name_of_two_renaming_is_the_remedy(tmp_path, files, two):
    for file in files:
        (tmp_path / file).touch()
    with pytest.raises(InputError) as refusal:
        inputs.collect([str(tmp_path)])
    assert str(refusal.value).startswith(" and ".join(str(tmp_path / file) for file in two))
    assert "in the output folder; rename one of them; or use two output folders" in str(
        refusal.value
    )
    (tmp_path / two[1]).rename(tmp_path / "other.ply")
    assert len(inputs.collect([str(tmp_path)])) == len(files)
