# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that appear whole or not at all: written beside their place, then renamed."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path

TEMPORARY_SUFFIX = ".spheroseg-part"


class DiskFullError(OSError):
    """No room for a result: nothing that follows could be written either."""


@contextlib.contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yields a temporary path in the folder of `path`; renames it to `path` when the block ends
    well, removes it otherwise. Raises DiskFullError when the disk has no room."""
    path = Path(path)
    temporary = path.with_name(f".{path.name}.{os.getpid()}{TEMPORARY_SUFFIX}")
    try:
        with explained_disk_full(path):
            yield temporary
            with temporary.open("rb") as stream:
                os.fsync(stream.fileno())
            temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def write_bytes(path: Path, data: bytes) -> None:
    """Writes a file atomically."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Writes a UTF-8 file atomically."""
    write_bytes(path, text.encode())


@contextlib.contextmanager
def explained_disk_full(path: Path) -> Iterator[None]:
    """Turns "no space left" into a DiskFullError that names the file."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT) and not isinstance(error, DiskFullError):
            raise DiskFullError(
                error.errno, f"no room left on the disk for '{path}'; make room and run again"
            ) from error
        raise


def remove_leftovers(folder: Path) -> int:
    """Removes temporary files that a killed run left in `folder` or below; returns how many."""
    leftovers = list(Path(folder).rglob(f".*{TEMPORARY_SUFFIX}"))
    for path in leftovers:
        path.unlink(missing_ok=True)
    return len(leftovers)
