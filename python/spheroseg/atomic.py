# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that appear whole or not at all: written beside their place, then renamed."""

from __future__ import annotations

import contextlib
import errno
import os
import re
import secrets
import shutil
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

TEMPORARY_SUFFIX = ".spheroseg-part"
_OWNER = re.compile(rf"\.(\d+)@(.+){re.escape(TEMPORARY_SUFFIX)}")
_LONGEST_WRITE_SECONDS = 24 * 3600


class DiskFullError(OSError):
    """No room for a result: nothing that follows could be written either."""


@contextlib.contextmanager
def atomic_path(path: Path, suffix: str = "") -> Iterator[Path]:
    """Yields a temporary path in the folder of `path`; renames it to `path` when the block ends
    well, removes it otherwise. A file that is replaced leaves its permissions to the new one. A
    symbolic link stays one: what it leads to is replaced. `suffix` is for writers that go by it.
    Raises DiskFullError when the disk has no room."""
    target = Path(path).resolve()
    temporary = _temporary_beside(target, suffix)
    with _explained(path, temporary):
        try:
            if target.exists():
                temporary.touch(0o600)  # what nobody may read must not be readable meanwhile
            yield temporary
            with temporary.open("rb") as stream:
                os.fsync(stream.fileno())
            with contextlib.suppress(FileNotFoundError):
                shutil.copymode(target, temporary)
            temporary.replace(target)
        finally:
            # Fails where nothing can be written, though there is no such file.
            temporary.unlink(missing_ok=True)


@contextlib.contextmanager
def made_folder(folder: Path) -> Iterator[None]:
    """Makes the folder. Where the block does not end well, what this process was writing there is
    removed, and folders that are new and empty."""
    with contextlib.ExitStack() as undo:
        for parent in (*reversed(folder.parents), folder):
            if not parent.exists():
                undo.callback(_remove_empty, parent)
        undo.callback(_remove_temporaries, folder)
        folder.mkdir(parents=True, exist_ok=True)
        yield
        undo.pop_all()


@contextlib.contextmanager
def all_or_none(folder: Path) -> Iterator[Callable[[str, bytes], None]]:
    """Makes the folder and yields a function that writes a file there, atomically, under a name.
    Where the block does not end well, files and folders that are new are removed."""
    with made_folder(folder), contextlib.ExitStack() as undo:

        def write(name: str, data: bytes) -> None:
            path = folder / name
            if not path.exists():
                undo.callback(path.unlink, missing_ok=True)
            write_bytes(path, data)

        yield write
        undo.pop_all()


def _remove_temporaries(folder: Path) -> None:
    """Those of this process. A KeyboardInterrupt on the way into or out of `atomic_path` is raised
    where that can not remove its own yet."""
    for path in folder.glob(f".*.{_this_process()}{TEMPORARY_SUFFIX}*"):
        path.unlink(missing_ok=True)


def _remove_empty(folder: Path) -> None:
    with contextlib.suppress(OSError):
        folder.rmdir()


def check_place(path: Path) -> None:
    """Raises an OSError that names `path` where `atomic_path` could not write it."""
    temporary = _temporary_beside(Path(path).resolve())
    with _explained(path, temporary):
        temporary.touch()
        temporary.unlink()


def _temporary_beside(target: Path, suffix: str = "") -> Path:
    # Not from the target's name, which may be as long as the file system allows.
    owner = f"{secrets.token_hex(4)}.{_this_process()}"
    return target.with_name(f".{owner}{TEMPORARY_SUFFIX}{suffix}")


def _this_process() -> str:
    return f"{os.getpid()}@{socket.gethostname()}"


def write_bytes(path: Path, data: bytes) -> None:
    """Writes a file atomically."""
    with atomic_path(path) as temporary:
        temporary.write_bytes(data)


def write_text(path: Path, text: str) -> None:
    """Writes a UTF-8 file atomically."""
    write_bytes(path, text.encode())


@contextlib.contextmanager
def _explained(path: Path, temporary: Path) -> Iterator[None]:
    """Errors name the file that was wanted; "no space left" becomes a DiskFullError."""
    try:
        yield
    except OSError as error:
        if error.errno in (errno.ENOSPC, errno.EDQUOT):
            raise DiskFullError(
                error.errno, f"no room left on the disk for '{path}'; make room and run again"
            ) from error
        if error.filename is None or str(error.filename) == str(temporary):
            error.filename = str(path)
        raise


def remove_leftovers(folder: Path) -> int:
    """Removes temporary files that a killed run left in `folder` or below; returns how many.

    Those of a process that lives on this machine stay, and those of other machines for a day.
    """
    leftovers = [
        path for path in Path(folder).rglob(f".*{TEMPORARY_SUFFIX}*") if not _may_be_in_use(path)
    ]
    for path in leftovers:
        path.unlink(missing_ok=True)
    return len(leftovers)


def _may_be_in_use(path: Path) -> bool:
    owner = _OWNER.search(path.name)
    if owner is None:
        return False
    if owner[2] == socket.gethostname():
        return _is_alive(int(owner[1]))
    try:
        return time.time() - path.stat().st_mtime < _LONGEST_WRITE_SECONDS
    except FileNotFoundError:
        return False  # finished meanwhile


def _is_alive(process_id: int) -> bool:
    try:
        # Empty for one that has ended but that its parent has not asked about.
        return Path(f"/proc/{process_id}/cmdline").read_bytes() != b""
    except OSError:
        return False
