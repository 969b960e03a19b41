# SPDX-License-Identifier: GPL-3.0-or-later
"""A file that tells processes, on all machines that share it, that a folder is in use."""

import contextlib
import fcntl
import os
import socket
from collections.abc import Iterator
from pathlib import Path

from spheroseg.errors import InputError


@contextlib.contextmanager
def locked(folder: Path, name: str, work: str) -> Iterator[None]:
    """Holds the lock file `folder / name` while the `with` block runs, at most until this process
    ends; `work`: what is done in the folder.

    Where another one holds it, raises InputError that says who it is. Where the file system has no
    locks, or no such file can be written, nothing is locked.
    """
    with contextlib.ExitStack() as held:
        with contextlib.suppress(OSError):
            # NFS locks only what is open for writing.
            file = held.enter_context((folder / name).open("a+b", buffering=0))
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                file.seek(0)
                holder = file.read().decode(errors="replace").strip()
                raise InputError(
                    f"{folder}: another {work} writes there; wait until it is done, or name "
                    f"another folder ({holder or 'it has just begun'})"
                ) from None
            file.truncate(0)
            file.write(f"process {os.getpid()} on {socket.gethostname()}\n".encode())
        yield
