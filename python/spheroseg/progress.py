# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress bars: of many meshes, and of filters that run inside PyMeshLab.

PyMeshLab has no progress callback for Python; in verbose mode it writes each report of the filter
to the process's stderr. For the time of a filter that stream is read here and drawn as a bar.
"""

import contextlib
import ctypes
import io
import os
import re
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pymeshlab
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from spheroseg.errors import one_line

_REPORT = re.compile(r"LOG: \d+ (.*?)\s+\[ (\d+)% \]")


class _PatientConsole(Console):
    """Goes on, in silence, when nobody reads any more; rich would end the program."""

    def on_broken_pipe(self) -> None:
        self.quiet = True


class MeshProgress:
    """Of `total` meshes on stderr: where that is a terminal a bar with the time left while the
    `with` block runs, and in any case the lines that are said."""

    def __init__(self, title: str, total: int):
        columns = (TextColumn(title), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        self._console = _PatientConsole(stderr=True, highlight=False, soft_wrap=True)
        self._bar = Progress(*columns, console=self._console, disable=not self._console.is_terminal)
        self._task = self._bar.add_task("", total=total)

    def __enter__(self):
        self._bar.start()
        return self

    def __exit__(self, *_):
        self._bar.stop()

    def advance(self) -> None:
        self._bar.advance(self._task)

    def say(self, line: str) -> None:
        with contextlib.suppress(OSError):  # a full disk, where stderr is a file
            self._console.print(line, markup=False, emoji=False)

    def say_failed(self, failure: str) -> None:
        self.say(f"failed: {one_line(failure)}")


@contextlib.contextmanager
def filter_progress(mesh_set: pymeshlab.MeshSet, title: str) -> Iterator[None]:
    """Draws the progress of the filters that run inside the `with` block.

    Does nothing when stderr is no terminal. Takes over the file descriptors of stdout, where the
    verbose mode prints the parameters, and of stderr meanwhile: for programs that own their
    process, not for libraries.
    """
    if not sys.stderr.isatty():
        yield
        return
    terminal = os.dup(2)
    reader, writer = os.pipe()
    with (
        os.fdopen(terminal, "w", errors="replace") as screen,
        os.fdopen(reader, errors="replace") as reports,
        os.fdopen(writer, "w") as pipe,
    ):
        console = Console(file=screen, force_terminal=True)
        spinner = "dots" if console.encoding.startswith("utf") else "line"
        columns = (
            SpinnerColumn(spinner),
            TextColumn("{task.description}"),
            BarColumn(),
            TimeElapsedColumn(),
        )
        with Progress(*columns, console=console, transient=True) as progress:
            task = progress.add_task(title, total=None)
            follower = threading.Thread(target=_follow, args=(reports, progress, task, title))
            follower.start()
            os.dup2(writer, 2)
            pipe.close()
            mesh_set.set_verbosity(True)
            try:
                with _no_output():
                    yield
            finally:
                mesh_set.set_verbosity(False)
                os.dup2(terminal, 2)  # closes the pipe's last writer, which ends the follower
                follower.join()


@contextlib.contextmanager
def _no_output() -> Iterator[None]:
    """Nothing that Python or a library prints inside the `with` block is seen."""
    sys.stdout.flush()
    output = os.dup(1)
    with Path(os.devnull).open("w") as nothing:
        os.dup2(nothing.fileno(), 1)
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            yield
    finally:
        ctypes.CDLL(None).fflush(None)  # C's buffers
        os.dup2(output, 1)
        os.close(output)


def _follow(reports, progress: Progress, task, title: str) -> None:
    for line in reports:
        found = _REPORT.search(line)
        if found:
            step, percent = found.groups()
            progress.update(task, total=100, completed=int(percent), description=f"{title}: {step}")
