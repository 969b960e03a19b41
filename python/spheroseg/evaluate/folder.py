# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of a report: what lies where, and how an earlier report makes room.

The list `DIR/.report` names every file that a report may write; it is there before the first of
them, so that also a report that was broken off can be removed whole, and nothing but it.
"""

import contextlib
import json
from collections.abc import Iterable
from pathlib import Path

from spheroseg import atomic
from spheroseg.errors import InputError

LIST_NAME = ".report"
PAGE = "report.html"
TABLE = "results.csv"
DOCUMENT = "results.json"


def arrays_file(name: str) -> str:
    return f"labels/{name}.npz"


def stem(name: str, k: int, method: str) -> str:
    """What the files of one result are called."""
    return f"{name}-k{k}-{method}"


def files_of(results: Iterable[tuple[str, int, str]]) -> list[str]:
    """Every file that a report of (mesh, k, method) may write, relative to its folder."""
    results = list(results)
    names = dict.fromkeys(name for name, _, _ in results)
    files = [PAGE, TABLE, DOCUMENT, "plots/shared-memory.svg", "plots/quality-and-time.svg"]
    files += map(arrays_file, names)
    for one in (stem(*result) for result in results):
        files += [f"labels/{one}.npy", f"pictures/{one}.png", f"plots/iterations/{one}.svg"]
    return files


def prepare(folder: Path, files: list[str], replace: bool) -> None:
    """Makes the folder for a report that writes `files`. Refuses one with an earlier report unless
    that is to be replaced, and one where a file is there already."""
    if (folder / LIST_NAME).exists():
        if not replace:
            raise InputError(
                f"{folder}: has an earlier report, or a part of one; add --replace to remove that "
                "first, or name another folder"
            )
        clear(folder)
    elif not replace:
        found = next((folder / file for file in files if (folder / file).exists()), None)
        if found:
            raise InputError(
                f"{found}: is there already, and the report would replace it; name another folder, "
                "or add --replace"
            )
    folder.mkdir(parents=True, exist_ok=True)
    atomic.remove_leftovers(folder)
    atomic.write_text(folder / LIST_NAME, json.dumps(files, indent=0) + "\n")


def clear(folder: Path) -> None:
    """Removes the files that the list names, then folders that are empty now, then the list."""
    path = folder / LIST_NAME
    try:
        files = [Path(file) for file in json.loads(path.read_text())]
    except (ValueError, TypeError):
        raise InputError(f"{path}: is no list of a report's files; remove the report") from None
    parents = set()
    for file in files:
        # Of a list that somebody else wrote nothing outside the folder is removed.
        if not file.is_absolute() and ".." not in file.parts and (folder / file).is_file():
            (folder / file).unlink()
            parents |= set(file.parents) - {Path()}
    for parent in sorted(parents, key=lambda parent: len(parent.parts), reverse=True):
        with contextlib.suppress(OSError):
            (folder / parent).rmdir()
    path.unlink()
