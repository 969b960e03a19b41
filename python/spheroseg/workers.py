# SPDX-License-Identifier: GPL-3.0-or-later
"""Processes that do the work of a command: they end with the process that started them, say what
they found in lines of JSON, and leave a reason where they fail.

A worker is a module whose main function is `serve`; the other side calls `results`. Where each task
needs a process of its own, it is `nurse`; the other side has a `Nursery`.
"""

import collections
import contextlib
import ctypes
import functools
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any, NoReturn

from spheroseg import atomic
from spheroseg.errors import InputError, one_line

INTERRUPTED_EXIT = 130
_PR_SET_PDEATHSIG = 1
_MOST_OF_STDERR = 4096
_IDLE_SECONDS = 60

Message = dict[str, Any]


class WorkerError(RuntimeError):
    """A process ended before its first task; the message is the reason."""


def results(module: str, job: Message, tasks: list[Message]) -> Iterator[tuple[Message, Message]]:
    """Each task with its result, from processes that run `python -m module` one after the other.

    A task that ends its process, or whose result is no JSON, has the result {"status": "failed",
    "error": reason}; those after it go on in a new process. The facts of `serve` are part of each
    result. Raises WorkerError where a process ends before its first task.
    """
    waiting = collections.deque(tasks)
    while waiting:
        facts = reason = None
        with tempfile.TemporaryFile() as complaints:
            with _fed(module, job | {"tasks": list(waiting)}, complaints) as process:
                for line in process.stdout:
                    if not line.endswith("\n"):
                        break  # killed while it wrote
                    message = _message(line)
                    if message is None:
                        # Those that follow might be taken for results of other tasks.
                        process.kill()
                        reason = f"the process said '{line.strip()[:80]}' instead of a result"
                        break
                    if facts is None:
                        facts = message
                    else:
                        yield waiting.popleft(), facts | message
            length = complaints.seek(0, os.SEEK_END)
            complaints.seek(max(0, length - _MOST_OF_STDERR))
            said = complaints.read().decode(errors="replace")
        reason = reason or failure_reason(process.returncode, said)
        if facts is None:
            raise WorkerError(reason)
        if waiting:
            yield waiting.popleft(), facts | {"status": "failed", "error": reason}


def _message(line: str) -> Message | None:
    try:
        message = json.loads(line)
    except ValueError:
        return None
    return message if isinstance(message, dict) else None


@contextlib.contextmanager
def _fed(module: str, job: Message, complaints: IO) -> Iterator[subprocess.Popen]:
    with start(module, complaints) as process:
        try:
            with contextlib.suppress(BrokenPipeError), process.stdin:
                json.dump(job, process.stdin)
            yield process
        except BaseException:
            process.kill()
            raise


class Nursery:
    """A process that runs `python -m module`, whose main function is `nurse`: it imports what jobs
    need, which takes longer than a small job, and is forked for each of them. It begins with the
    first job, and ends with the thread that had it, or where a minute brings no other; one that
    has ended is replaced for the next job. For jobs of one thread at a time.
    """

    def __init__(self, module: str):
        self._module = module
        self._process: subprocess.Popen | None = None
        self._used = threading.Lock()
        self._end: threading.Timer | None = None

    def run(self, job: str) -> subprocess.CompletedProcess:
        """Does a job, of one line; with the exit code and stderr of its process, or of the nursery
        where that has ended."""
        with self._used:
            self._cancel_end()
            done = self._run(job)
            self._end = threading.Timer(_IDLE_SECONDS, self.close)
            self._end.daemon = True
            with contextlib.suppress(RuntimeError):  # no more threads: it stays until it is closed
                self._end.start()
        return done

    def _run(self, job: str) -> subprocess.CompletedProcess:
        if self._process is None:
            # With the threads of a library a fork would not be safe.
            alone = {"OPENBLAS_NUM_THREADS": "1"}
            self._process = start(self._module, subprocess.PIPE, alone)
        process = self._process
        with contextlib.suppress(BrokenPipeError):
            print(job, file=process.stdin, flush=True)
        line = process.stdout.readline()
        answer = _message(line) if line.endswith("\n") else None
        if answer and answer.keys() == {"returncode", "stderr"}:
            return subprocess.CompletedProcess(process.args, **answer)
        if line:
            process.kill()  # What follows might be taken for the answer to another job.
        self._process = None
        _, complained = process.communicate()
        return subprocess.CompletedProcess(process.args, process.returncode, stderr=complained)

    def interrupt(self) -> None:
        """Sends SIGINT to the process of the job that runs, if one does."""
        self._send(signal.SIGINT)

    def kill(self) -> None:
        """Ends the process of the job that runs, if one does, at once."""
        self._send(signal.SIGTERM)

    def _send(self, number: int) -> None:
        process = self._process
        if process is not None:
            process.send_signal(number)

    def close(self) -> None:
        with self._used:
            self._cancel_end()
            if self._process is not None:
                with self._process:  # ends when it gets no more jobs
                    self._process = None

    def _cancel_end(self) -> None:
        if self._end is not None:
            self._end.cancel()


def start(
    module: str, stderr: IO | int, variables: dict[str, str] | None = None
) -> subprocess.Popen:
    """Starts `python -m module`, which calls `end_with` its argument; a pipe each way, of text.

    `variables`: of the environment, besides its own.
    """
    return subprocess.Popen(
        # -P: no module of the folder where the command runs, whatever its name.
        [sys.executable, "-P", "-m", module, str(os.getpid())],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=stderr,
        # Not by the locale, and what is said of a failure can always be read.
        encoding="utf-8",
        errors="replace",
        env=package_environment() | {"PYTHONIOENCODING": "utf-8"} | (variables or {}),
    )


def package_environment() -> dict[str, str]:
    """Environment for a process that imports this very package, wherever the caller found it."""
    package = str(Path(__file__).resolve().parents[1])
    others = os.environ.get("PYTHONPATH")
    return dict(os.environ, PYTHONPATH=os.pathsep.join([package, others] if others else [package]))


def failure_reason(returncode: int, said: str) -> str:
    """Why a process failed, from its exit code and what it wrote to stderr."""
    lines = said.strip().splitlines()
    if returncode < 0:
        ended = f"the process was ended by signal {-returncode}"
        return f"{ended}: {lines[-1]}" if lines else ended
    return lines[-1] if lines else f"the process ended with exit code {returncode}"


def serve(prepare: Callable[[Message], tuple[Message, Callable[[Message], Message]]]) -> int:
    """The main function of a worker; its argument is the id of the process that started it.

    `prepare` gets the job and returns facts, which become part of every result, and the function
    that does a task. What that one throws is the failure of a task; returns the exit code.
    """
    end_with(int(sys.argv[1]))
    # Libraries print; the results have a channel of their own.
    channel = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    job = json.load(sys.stdin)
    try:
        facts, do = prepare(job)
    except (InputError, ImportError, OSError, MemoryError) as error:
        print(explained(error), file=sys.stderr)
        return 1
    print(json.dumps(facts), file=channel, flush=True)
    for task in job["tasks"]:
        try:
            result = do(task)
        except Exception as error:
            result = {"status": "failed", "error": explained(error)}
        print(json.dumps(result), file=channel, flush=True)
    return 0


def nurse(do: Callable[[str], int], prepare: Callable[[str], None]) -> int:
    """The main function of the module of a nursery; its argument is the id of the process that
    started it. `do` gets a job in a process of its own, and returns the exit code of that one;
    `prepare` gets it before, to import here what all such jobs need.

    What the process writes to stderr or stdout is part of the answer. A SIGINT is for the job, and
    a SIGTERM kills it: who waits for the answer then knows that it has ended.
    """
    end_with(int(sys.argv[1]))
    channel = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    child = 0

    def pass_on(number: int, _) -> None:
        if child:
            with contextlib.suppress(ProcessLookupError):  # it has just ended
                os.kill(child, signal.SIGKILL if number == signal.SIGTERM else number)

    signal.signal(signal.SIGTERM, pass_on)
    if handlers[signal.SIGINT] != signal.SIG_IGN:
        signal.signal(signal.SIGINT, pass_on)
    for job in sys.stdin:
        prepare(job)
        said, complaints = os.pipe()
        nursery = os.getpid()
        # Until it is known here whom they are for, and the job has its own handlers, signals wait.
        signal.pthread_sigmask(signal.SIG_BLOCK, handlers)
        child = os.fork()
        if child == 0:
            channel.close()
            os.close(said)
            _end_after(functools.partial(do, job), handlers, nursery, complaints)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, handlers)
        os.close(complaints)
        with os.fdopen(said, encoding="utf-8", errors="replace") as lines:
            complained = lines.read()
        status = os.waitpid(child, 0)[1]
        child = 0
        answer = {"returncode": os.waitstatus_to_exitcode(status), "stderr": complained}
        print(json.dumps(answer), file=channel, flush=True)
    return 0


def _end_after(
    work: Callable[[], int], handlers: dict[int, Any], parent: int, complaints: int
) -> NoReturn:
    """All that a process that was forked does, and its end: `work` returns the exit code.

    `handlers`: of signals, for `work`; until they are set, these signals wait.
    """
    code = 1
    try:
        end_with(parent)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(complaints, 1)
        os.dup2(complaints, 2)
        for number, handler in handlers.items():
            signal.signal(number, handler)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, handlers)
        code = work()
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        code = INTERRUPTED_EXIT
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


def end_with(parent: int) -> None:
    """Asks Linux to end this process when its parent is killed, which may have happened already."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() != parent:
            sys.exit(1)


def explained(error: Exception) -> str:
    """An error in one line; with its type where the message is not made for people."""
    if isinstance(error, atomic.DiskFullError):
        return error.strerror
    message = one_line(str(error))
    if isinstance(error, InputError | ImportError | OSError | RuntimeError) and message:
        return message
    return f"{type(error).__name__}: {message}" if message else type(error).__name__
