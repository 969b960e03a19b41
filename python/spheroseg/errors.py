# SPDX-License-Identifier: GPL-3.0-or-later
"""Exceptions of the package, whose messages say what was expected, what was found, what to do; and
how messages count and show names."""

import os
from pathlib import Path

_ESCAPES = {code: f"\\x{code:02x}" for code in (*range(0x20), *range(0x7F, 0xA0))}


def one_line(message: str) -> str:
    """For logs and terminals, whatever names and libraries put into it: control characters, which
    move a cursor or change colours, are escaped."""
    return " ".join(message.split()).translate(_ESCAPES)


def counted(count: int, one: str, plural: str) -> str:
    """As in "1 sub-mesh" and "2 sub-meshes"; `plural`: what is added to `one`."""
    return f"{count} {one}{'' if count == 1 else plural}"


def shown(path: str | Path) -> str:
    """For tables and terminals: what is not UTF-8 is escaped."""
    return os.fsencode(path).decode(errors="backslashreplace")


class InputError(ValueError):
    """A mesh, an array, a file or an option that can not be used."""


class MissingPackageError(InputError, ImportError):
    """Something that was asked for needs an optional package that is not installed."""


class PluginError(ImportError):
    """The MeshLab plugin is missing, does not fit PyMeshLab, or can not run in a forked process."""
