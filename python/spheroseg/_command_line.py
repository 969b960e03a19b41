# SPDX-License-Identifier: GPL-3.0-or-later
"""What this package has to know about the program that imports it, and how that complains."""

import contextlib
import itertools
import signal
import sys
from collections.abc import Iterator
from pathlib import Path


def is_command_line() -> bool:
    """Does this process run the program, or a module of this package?"""
    name = Path(sys.argv[0]).name if sys.argv else ""
    if name == "-m":  # only while Python looks for the module that it was told to run
        words = itertools.dropwhile(lambda word: not word.startswith("-m"), sys.orig_argv)
        name = next(words, "").removeprefix("-m") or next(words, "")
    return name.partition(".")[0] == "spheroseg"


def complain(line: str) -> None:
    """Says a line on stderr. Where that can not be written, the exit code must do."""
    with contextlib.suppress(OSError):
        print(line, file=sys.stderr, flush=True)


@contextlib.contextmanager
def ended_by_interrupt() -> Iterator[None]:
    """In the block Ctrl-C ends the program at once and in silence: so early there is nothing to
    tidy up, and the traceback of an import tells nobody anything."""
    if not is_command_line() or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
