# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of a report: what lies where, and how an earlier report makes room.

The list `DIR/.report` names every file that a report may write; it is there before the first of
them. When a report is done, it takes the place of the earlier one: what that one had more is
removed, even where it was broken off, and nothing else. `DIR/.report.lock` lies there as long as
the list does.
"""

import contextlib
import json
from collections.abc import Iterable, Iterator
from pathlib import Path

from spheroseg import atomic
from spheroseg.errors import InputError
from spheroseg.lock import locked

LIST_NAME = ".report"
LOCK_NAME = ".report.lock"
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


@contextlib.contextmanager
def prepared(folder: Path, files: list[str]) -> Iterator[list[str]]:
    """Makes the folder for a report that writes `files`, which is for this one alone while the
    `with` block runs; yields the files of an earlier report there.

    Refuses a folder where another report is written, and one where one of the files is there
    already and of no report. Where the block does not end well, a new folder is removed if nothing
    is left in it.
    """
    _check_free(folder, files)  # a refusal leaves nothing
    with atomic.made_folder(folder), locked(folder, LOCK_NAME, "evaluation"):
        earlier = _listed(folder)
        atomic.remove_leftovers(folder)
        _write_list(folder, list(dict.fromkeys([*earlier, *files])))
        yield earlier


def _check_free(folder: Path, files: list[str]) -> None:
    known = set(_listed(folder))
    for file in files:
        if file not in known and (folder / file).exists():
            raise InputError(
                f"{folder / file}: is there already, and the report would replace it; name "
                "another folder"
            )


def keep_only(folder: Path, files: list[str]) -> None:
    """Removes what the list names beside `files`, and folders that are empty then."""
    kept = set(files)
    parents = set()
    for file in map(Path, _listed(folder)):
        # Of a list that somebody else wrote nothing outside the folder is removed.
        inside = not file.is_absolute() and ".." not in file.parts
        if inside and file.as_posix() not in kept and (folder / file).is_file():
            (folder / file).unlink()
            parents |= set(file.parents) - {Path()}
    for parent in sorted(parents, key=lambda parent: len(parent.parts), reverse=True):
        with contextlib.suppress(OSError):
            (folder / parent).rmdir()
    if files:
        _write_list(folder, files)
    else:
        for name in (LIST_NAME, LOCK_NAME):
            (folder / name).unlink(missing_ok=True)


def _listed(folder: Path) -> list[str]:
    path = folder / LIST_NAME
    try:
        return [str(file) for file in json.loads(path.read_text())]
    except FileNotFoundError:
        return []
    except (ValueError, TypeError):
        raise InputError(f"{path}: is no list of a report's files; remove the report") from None


def _write_list(folder: Path, files: list[str]) -> None:
    atomic.write_text(folder / LIST_NAME, json.dumps(files, indent=0) + "\n")
