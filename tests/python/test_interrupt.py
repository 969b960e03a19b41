# SPDX-License-Identifier: GPL-3.0-or-later
"""A Ctrl-C cancels a filter that runs, and whoever listened for it hears it."""

import json
import os
import pty
import signal
import subprocess
import sys
import threading
import time

import pytest
from batches import wait_for_records
from mesh_paths import REPOSITORY, SAMPLE_FOLDER
from processes import children, is_running, jobs_of, wait_until
from shapes import bumpy_sphere
from terminal import read_terminal

from spheroseg import workers
from spheroseg.batch import jobs, runner
from spheroseg.ply import ply_bytes

PATHS = [REPOSITORY / folder for folder in ("python", "tests/plugin", "tests/python")]
ENVIRONMENT = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, PATHS)), "TERM": "xterm"}

# Runs a filter that would take seconds, with a handler of SIGINT; tells what came of it as JSON.
PROGRAM = """
import ctypes, json, os, signal, sys
import host_meshes, pymeshlab
from spheroseg import api

handler_name, filter_name, levels, parameters, sample = json.loads(sys.argv[1])
calls = []

class Stop(Exception):
    pass

def note(*_):
    calls.append("note")

def stop(*_):
    raise Stop

def installed():
    # The handler of the process, the first member; signal.getsignal tells that of Python.
    action = (ctypes.c_void_p * 32)()
    assert ctypes.CDLL(None).sigaction(signal.SIGINT, None, action) == 0
    return action[0]

handlers = {"default": signal.default_int_handler, "note": note, "stop": stop}
handler = handlers.get(handler_name) or getattr(signal, handler_name)
signal.signal(signal.SIGINT, handler)
handler_before = installed()
mesh_set = host_meshes.ellipsoid(levels)
before = host_meshes.state(mesh_set)
mesh_set.set_verbosity(True)
try:
    if handler_name == "default":
        api.run_filter(mesh_set, filter_name, **parameters)
    else:
        getattr(mesh_set, filter_name)(**parameters)
    raised = None
except BaseException as error:
    raised = type(error).__name__
mesh_set.set_verbosity(False)
told = {
    "raised": raised,
    "unchanged": host_meshes.state(mesh_set) == before,
    "calls": len(calls),
    "handler_is_there": signal.getsignal(signal.SIGINT) is handler
    and installed() == handler_before,
}
if handler_name == "note":
    os.kill(os.getpid(), signal.SIGINT)
    told["calls_afterwards"] = len(calls)
# PyMeshLab alone may crash here; see spheroseg._plugin.forget_failed_call.
pymeshlab.MeshSet().load_new_mesh(sample)
api.run_filter(mesh_set, api.SEGMENT_FILTER, submesh_count=7, effort="draft")
told["sub-meshes_of_second_call"] = int(host_meshes.labels_of(mesh_set).max()) + 1
print(json.dumps(told))
"""

SEGMENT = ("compute_scalar_by_balanced_segmentation_per_face", 7)
LONG = {"submesh_count": 1000, "effort": "high"}
SHORT = {"submesh_count": 1000, "effort": "draft"}
PARAMETRIZE = ("compute_spherical_parametrization_per_vertex", 8)


def interrupt_program(handler, filter_name, levels, parameters):
    """Exit code and what the program told of itself; the signal comes after the first report."""
    arguments = json.dumps(
        [handler, filter_name, levels, parameters, str(SAMPLE_FOLDER / "cube.obj")]
    )
    process = subprocess.Popen(
        [sys.executable, "-c", PROGRAM, arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
    )
    before = []
    for line in process.stderr:
        before.append(line)
        if "% ]" in line:
            break
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate()
    if process.returncode != 0:
        return process.returncode, "".join(before) + complained
    return 0, json.loads(said.splitlines()[-1])


@pytest.mark.parametrize(
    ("filter_and_levels", "parameters"),
    [
        (SEGMENT, LONG),
        ((SEGMENT[0], 6), {"submesh_count": 200, "method": "all_pairs"}),
        (PARAMETRIZE, {}),
    ],
)
def test_filter_is_cancelled_and_its_mesh_set_can_be_used(filter_and_levels, parameters):
    assert interrupt_program("default", *filter_and_levels, parameters) == (
        0,
        {
            "raised": "KeyboardInterrupt",
            "unchanged": True,
            "calls": 0,
            "handler_is_there": True,
            "sub-meshes_of_second_call": 7,
        },
    )


# Half a second after it began, when most layers are still to be made.
LAYERS_PROGRAM = """
import os, subprocess
import host_meshes

mesh_set = host_meshes.ellipsoid(6)
mesh_set.compute_scalar_by_function_per_face(q="fi")
before = host_meshes.state(mesh_set)
subprocess.Popen(["sh", "-c", f"sleep 0.5; kill -INT {os.getpid()}"])
try:
    mesh_set.generate_submesh_layers()
except KeyboardInterrupt:
    print(mesh_set.mesh_number(), host_meshes.state(mesh_set) == before)
"""


def test_layers_that_were_made_before_an_interrupt_are_removed():
    result = subprocess.run(
        [sys.executable, "-c", LAYERS_PROGRAM], capture_output=True, text=True, env=ENVIRONMENT
    )
    assert result.stdout.split() == ["1", "True"], result.stderr


def test_own_handler_is_called_once_and_stays():
    code, told = interrupt_program("note", *SEGMENT, LONG)
    assert code == 0, told
    assert (told["raised"], told["unchanged"]) == ("KeyboardInterrupt", True)
    assert (told["calls"], told["calls_afterwards"]) == (1, 2)
    assert told["handler_is_there"]


def test_what_an_own_handler_raises_is_raised():
    code, told = interrupt_program("stop", *SEGMENT, LONG)
    assert code == 0, told
    assert (told["raised"], told["unchanged"], told["handler_is_there"]) == ("Stop", True, True)
    assert told["sub-meshes_of_second_call"] == 7


# The signal comes while a filter runs; where the process hangs, the alarm ends it.
CALLING_PROGRAM = """
import os, signal, sys, threading
import numpy, spheroseg
from processes import is_filter_running
from shapes import bumpy_sphere

arrays = bumpy_sphere(6, 0)

def call(*_):
    signal.alarm(20)
    child = os.fork()
    if child == 0:
        os._exit(0)
    os.waitpid(child, 0)
    measures = spheroseg.measure(*arrays, numpy.zeros(len(arrays[1])))
    print(measures["boundary_edge_count"], flush=True)
    sys.exit(3)

def send():
    while not is_filter_running():
        pass
    os.kill(os.getpid(), int(sys.argv[1]))

signal.signal(int(sys.argv[1]), call)
threading.Thread(target=send, daemon=True).start()
spheroseg.segment(*arrays, 200, effort="high")
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_own_handler_may_call_filters_and_fork(number):
    done = subprocess.run(
        [sys.executable, "-c", CALLING_PROGRAM, str(int(number))],
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
    )
    assert (done.returncode, done.stdout) == (3, "0\n"), done.stderr


def test_ignored_signal_stays_ignored():
    code, told = interrupt_program("SIG_IGN", *SEGMENT, SHORT)
    assert code == 0, told
    assert (told["raised"], told["unchanged"], told["handler_is_there"]) == (None, False, True)


def test_signal_that_ends_the_process_does_so():
    code, _ = interrupt_program("SIG_DFL", *SEGMENT, LONG)
    assert code == -signal.SIGINT


def test_command_line_ends_with_one_line_and_writes_nothing(tmp_path):
    (tmp_path / "mesh.ply").write_bytes(ply_bytes(*bumpy_sphere(7, 0)))
    outputs = ["-o", "out.ply", "--labels", "out.npy", "--json", "out.json"]
    controller, terminal = pty.openpty()  # for the bar, which tells of the first report
    process = subprocess.Popen(
        [sys.executable, "-m", "spheroseg", "segment", "mesh.ply", "-k", "1000"]
        + ["--effort", "high", *outputs],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=terminal,
        env=ENVIRONMENT,
    )
    os.close(terminal)
    shown = b""
    sent = False
    while chunk := read_terminal(controller):
        shown += chunk
        if not sent and b"Segmenting: " in shown:
            process.send_signal(signal.SIGINT)
            sent = True
    os.close(controller)
    assert process.wait() == 130, shown
    assert shown.endswith(b"spheroseg segment: interrupted\r\n")
    assert b"Traceback" not in shown
    assert [path.name for path in tmp_path.iterdir()] == ["mesh.ply"]


# Ctrl-C comes when a module is about to be imported.
STARTING = """
import os, signal, sys

class Interrupter:
    def find_spec(self, name, *_):
        if name == sys.argv[1]:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupter())
sys.argv[0] = sys.argv[2]
from spheroseg import cli
sys.exit(cli.main(["segment", "mesh.ply"]))
"""


@pytest.mark.parametrize(
    ("module", "program", "code", "said"),
    [
        ("pymeshlab", "spheroseg", -signal.SIGINT, ""),
        ("spheroseg.commands.segment", "spheroseg", 130, "spheroseg: interrupted\n"),
        # It is for the other program to say what an interrupt is.
        ("pymeshlab", "other.py", -signal.SIGINT, "KeyboardInterrupt\n"),
    ],
)
def test_a_program_that_starts_is_interrupted_without_a_traceback(module, program, code, said):
    done = subprocess.run(
        [sys.executable, "-c", STARTING, module, program],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
    )
    last_line = "".join(done.stderr.splitlines(keepends=True)[-1:])
    assert (done.returncode, last_line) == (code, said)
    assert ("Traceback" in done.stderr) == (program == "other.py")


def test_split_leaves_no_file_and_no_folder(tmp_path):
    vertices, faces = bumpy_sphere(5, 0)
    (tmp_path / "mesh.ply").write_bytes(ply_bytes(vertices, faces))
    (tmp_path / "labels.txt").write_text("".join(f"{label}\n" for label in range(len(faces))))
    call = [sys.executable, "-m", "spheroseg", "split", "mesh.ply", "--labels", "labels.txt"]
    process = subprocess.Popen(
        [*call, "-o", "parts"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
    )
    wait_until((tmp_path / "parts" / "submesh_0020.ply").exists)
    process.send_signal(signal.SIGINT)
    said, complained = process.communicate()
    assert (process.returncode, said, complained) == (130, "", "spheroseg split: interrupted\n")
    assert {path.name for path in tmp_path.iterdir()} == {"mesh.ply", "labels.txt"}


@pytest.mark.parametrize("send", [os.kill, os.killpg])
def test_batch_ends_with_its_workers_and_can_be_resumed(send, tmp_path):
    (tmp_path / "a.ply").write_bytes(ply_bytes(*bumpy_sphere(1, 0)))
    (tmp_path / "b.ply").write_bytes(ply_bytes(*bumpy_sphere(7, 0)))
    output = tmp_path / "out"
    call = [sys.executable, "-m", "spheroseg", "batch", "a.ply", "b.ply", "-o", str(output)]
    call += ["-k", "20", "--effort", "high", "--workers", "1"]
    process = subprocess.Popen(
        call,
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
        start_new_session=True,
    )
    wait_for_records(output, 1, process)
    wait_until(lambda: jobs_of(process.pid))
    send(process.pid, signal.SIGINT)
    said, complained = process.communicate()
    assert (process.returncode, said) == (130, "")
    assert complained == "spheroseg batch: interrupted\n"
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)
    found = {path.name for path in output.iterdir()}
    assert found == {jobs.RECORD_FOLDER, "a.ply"}

    (tmp_path / "b.ply").write_bytes(ply_bytes(*bumpy_sphere(2, 0)))  # takes less time
    kept = (output / "a.ply").stat().st_mtime_ns
    done = subprocess.run(
        [*call, "--resume"], cwd=tmp_path, capture_output=True, text=True, env=ENVIRONMENT
    )
    assert "2 of 2 meshes done" in done.stdout
    assert (output / "a.ply").stat().st_mtime_ns == kept


WORKER = """
import os, signal, sys
from spheroseg.batch import worker

def interrupted_twice(job):
    try:
        os.kill(os.getpid(), signal.SIGINT)
    finally:
        os.kill(os.getpid(), signal.SIGINT)
        print("cleaned up")

worker.Job = dict
worker._check_versions = interrupted_twice
try:
    worker.do('{}')
except KeyboardInterrupt:
    print("interrupted")
"""


def test_an_interrupt_between_two_results_of_a_batch_ends_what_runs(monkeypatch):
    began, ended = threading.Event(), threading.Event()

    def run_job(job, place):
        if job.name == "slow":
            began.set()
            ended.wait(20)
        return {"name": job.name, "status": "done"}

    def interrupt(record):
        assert began.wait(20)
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "run_job", run_job)
    monkeypatch.setattr(workers.Nursery, "interrupt", lambda _: ended.set())
    both = [jobs.Job("a.ply", name, "out", {}, (), {}) for name in ("quick", "slow")]
    with pytest.raises(KeyboardInterrupt):
        runner.run_all(both, interrupt, resume=False, worker_count=2, on_hint=print)
    assert ended.is_set()


def test_a_second_ctrl_c_leaves_no_worker_that_does_not_hear_of_the_first(tmp_path):
    (tmp_path / "a.ply").write_bytes(ply_bytes(*bumpy_sphere(7, 0)))
    call = [sys.executable, "-m", "spheroseg", "batch", "a.ply", "-o", "out", "-k", "20"]
    process = subprocess.Popen(
        [*call, "--effort", "high"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=ENVIRONMENT,
    )

    wait_until(lambda: jobs_of(process.pid))
    (nursery,) = children(process.pid)
    (worker,) = jobs_of(process.pid)
    os.kill(worker, signal.SIGSTOP)  # as one that waits for a disk
    try:
        for _ in range(2):
            process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        _, complained = process.communicate(timeout=20)
    finally:
        process.kill()
    assert (process.returncode, complained) == (130, "spheroseg batch: interrupted\n")
    assert not any(map(is_running, (nursery, worker)))


def test_a_second_ctrl_c_does_not_disturb_what_a_worker_of_batch_cleans_up():
    done = subprocess.run(
        [sys.executable, "-c", WORKER],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        env=ENVIRONMENT,
    )
    assert (done.stdout, done.stderr) == ("cleaned up\ninterrupted\n", "")
