# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line `spheroseg`.

A subcommand is a module with two functions and one line in `COMMANDS`:

    def add_arguments(parser): ...      # fills an argparse.ArgumentParser
    def run(arguments) -> int: ...      # does the work, returns the exit code

The module's docstring is what `spheroseg COMMAND --help` shows; the module is imported only when
its command is called, so that heavy imports of one command cost the others nothing.

`run` reports bad input by raising `spheroseg.errors.InputError` (or `OSError` for a file that can
not be read or written): `main` turns either into one line on stderr and exit code 2. Exit code 1
is for work that was accepted and failed in part, such as one mesh of a batch.
"""

import argparse
import errno
import importlib
import io
import os
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from spheroseg import __version__
from spheroseg._command_line import complain
from spheroseg.errors import InputError, PluginError, one_line

EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 130
EXIT_PIPE_CLOSED = 141

# Name: (module, one line for `spheroseg --help`).
COMMANDS = {
    "segment": ("spheroseg.commands.segment", "cut a mesh into balanced sub-meshes"),
    "parametrize": ("spheroseg.commands.parametrize", "map a mesh onto the unit sphere"),
    "measure": ("spheroseg.commands.measure", "measure the labels of a segmented mesh"),
    "install-plugin": (
        "spheroseg.commands.install_plugin",
        "add the plugin to the MeshLab application",
    ),
    "split": ("spheroseg.commands.split", "write each sub-mesh as a file of its own"),
    "export": ("spheroseg.commands.export", "write GPU-ready arrays (.npz) or a .glb"),
    "evaluate": ("spheroseg.commands.evaluate", "compare with METIS and region growing"),
    "batch": ("spheroseg.commands.batch", "segment many meshes, here or on a Dask cluster"),
}


class _OneLineParser(argparse.ArgumentParser):
    """Reports bad usage in one line; argparse would print the usage before it."""

    def error(self, message: str) -> None:
        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {one_line(message)} (see {self.prog} --help)\n")


class _CommandParser(_OneLineParser):
    """Imports the module of its command when the command is called, and refuses itself what that
    does not know, by its own name."""

    def parse_known_args(self, args=None, namespace=None):
        if self.get_default("run") is None:
            module = importlib.import_module(COMMANDS[self.prog.split()[-1]][0])
            self.description = module.__doc__
            self.formatter_class = argparse.RawDescriptionHelpFormatter
            module.add_arguments(self)
            self.set_defaults(run=module.run)
        namespace, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return namespace, unknown


def build_parser() -> argparse.ArgumentParser:
    parser = _OneLineParser(
        prog="spheroseg",
        description="Cuts triangle meshes into connected sub-meshes whose triangle "
        "counts differ by at most one.",
        epilog="Exit codes: 0 done; 1 a part of a batch or an evaluate failed, or the disk of a "
        "batch is full; 2 bad usage or bad input, a full disk or a missing plugin; 130 interrupted "
        "by Ctrl-C; 141 nobody reads what is printed.",
    )
    parser.add_argument(
        "--version",
        action="version",
        version=f"spheroseg {__version__}",
        help="print the version and exit",
    )
    commands = parser.add_subparsers(
        title="commands", metavar="COMMAND", dest="command", parser_class=_CommandParser
    )
    for name, (_, summary) in COMMANDS.items():
        commands.add_parser(name, help=summary)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the command line and returns the exit code."""
    _open_closed_streams()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A name that the output's encoding does not have is no reason to fail after the work.
        # Not written through, with PYTHONUNBUFFERED neither: what can not be written is said below.
        sys.stdout.reconfigure(errors="backslashreplace", write_through=False)
    try:
        code = _run(argv)
    except SystemExit as stop:  # of argparse
        code = stop.code
    error = _flushed(sys.stdout)
    if isinstance(error, BrokenPipeError):
        code = EXIT_PIPE_CLOSED
    elif error:
        code = code or _report("spheroseg", f"the standard output: {error.strerror}")
    _flushed(sys.stderr)
    return code


def _flushed(stream: TextIO) -> OSError | None:
    """What is left in the stream after an error is given up: it would be tried again, and end the
    program with a traceback or another exit code, when Python ends."""
    try:
        stream.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return error
    return None


def _open_closed_streams() -> None:
    """Lets streams that the caller has closed lead nowhere.

    The next file that is opened would get their number and, with it, what libraries print.
    """
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode))  # noqa: SIM115 (until the end)


def _run(argv: Sequence[str] | None) -> int:
    program = "spheroseg"
    try:
        arguments = _arguments(argv)
        program = f"spheroseg {arguments.command}"
        return arguments.run(arguments)
    except (InputError, PluginError) as error:
        return _report(program, str(error))
    except BrokenPipeError:
        return EXIT_PIPE_CLOSED
    except OSError as error:
        name = error.filename
        if name is None and error.errno == errno.ENOENT:
            name = "the working folder"  # all others have names
        where = f"{name}: " if name else ""
        return _report(program, f"{where}{error.strerror or error}")
    except MemoryError:
        return _report(
            program, "there is not enough memory; close other programs, or simplify the mesh"
        )
    except KeyboardInterrupt:
        _report(program, "interrupted")
        return EXIT_INTERRUPTED


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = build_parser()
    argv = sys.argv[1:] if argv is None else argv
    arguments = parser.parse_args(argv)
    if arguments.command is None:
        parser.error("a command is missing: choose one of " + ", ".join(COMMANDS))
    for name, value in vars(arguments).items():
        # Mostly a variable of the shell that is not set.
        if value == "" or (isinstance(value, list) and "" in value):
            parser.error(f"{name.replace('_', '-')} is empty: name something, or leave it out")
    arguments.command_line = shlex.join(["spheroseg", *argv])
    return arguments


def _report(program: str, message: str) -> int:
    complain(f"{program}: {one_line(message)}")
    return EXIT_BAD_INPUT
