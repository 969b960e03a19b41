# SPDX-License-Identifier: GPL-3.0-or-later
"""From files, folders, globs and CSV lists to the jobs of a batch."""

import csv
import glob
import os
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from spheroseg.batch.jobs import known_results
from spheroseg.errors import InputError
from spheroseg.file_checks import check_is_file, check_name

MESH_SUFFIXES = frozenset({".ply", ".obj", ".off", ".stl"})
_COUNT_COLUMNS = ("submesh_count", "k")
_MOST_SUBMESHES = 2**31 - 1
_MOST_NESTED = 200  # folders; Python's own functions end at some hundreds
_RECURSIVE_GLOB = re.compile(r"(.*?/|)\*\*(?:/(.*))?", re.DOTALL)


@dataclass(frozen=True)
class Source:
    """A mesh of a batch. `name` is its place below the output folder, without suffix; `long_name`
    another one, with the folders below that of the list or the search that led to the mesh."""

    mesh: Path
    name: str
    submesh_count: int | None = None
    long_name: str | None = None


class _Results:
    """What a batch that is resumed has written to its folder."""

    def __init__(self, folder: Path, resume: bool):
        self.folder = folder.resolve()
        self.names = known_results(folder) if resume else set()


def collect(inputs: list[str], output: Path | None = None, *, resume: bool = False) -> list[Source]:
    """The meshes that `inputs` name, in their order, each once.

    A folder stands for all mesh files below it; a CSV file has a column `mesh` (relative to the
    CSV's folder) and may have a column `submesh_count` or `k`. A file that is named but absent is
    kept, and so is one that is found and whose name is not UTF-8: it fails on its own. A search
    leaves out results: what lies in `output`, the folder for them, where it is further down, and
    with `resume` what batches have written there. Raises InputError for an input that names
    nothing, or whose own name is not UTF-8.
    """
    results = None if output is None else _Results(output, resume)
    sources: dict[tuple, Source] = {}
    for text in inputs:
        check_name(Path(text).absolute())
        found = list(_expand(text, results))
        if not found:
            raise InputError(f"{text}: names no mesh file ({', '.join(sorted(MESH_SUFFIXES))})")
        for source in found:
            sources.setdefault((_place(source.mesh), source.submesh_count), source)
    return _with_unique_names(list(sources.values()))


def _place(mesh: Path) -> Path:
    """The same for all paths to a file, but for links to the file itself."""
    return Path(os.path.realpath(mesh.parent), mesh.name)  # resolve() refuses circles of links


def _expand(text: str, results: _Results | None):
    path = Path(text)
    if path.is_dir():
        for mesh in sorted(parent / name for parent, names in _folders(path) for name in names):
            is_broken_link = mesh.is_symlink() and not mesh.exists()  # of data not fetched
            has_content = mesh.is_file() or is_broken_link
            is_mesh = has_content and mesh.suffix.lower() in MESH_SUFFIXES
            if is_mesh and not _is_result(mesh, path, results):
                yield Source(mesh, mesh.relative_to(path).with_suffix("").as_posix())
    elif path.suffix.lower() == ".csv":
        yield from _from_csv(path)
    elif not path.exists() and glob.has_magic(text):
        searched = next(parent for parent in path.parents if not glob.has_magic(str(parent)))
        for match in sorted(_matches(text)):
            if not _is_result(Path(match), searched, results):
                for source in _expand(match, results):
                    yield source if source.long_name else _with_long_name(source, searched)
    else:
        yield Source(path, path.stem)


def _matches(pattern: str, folder: str = "") -> Iterator[str]:
    """What a glob finds, in `folder`. As in shells, `**` follows no links to folders."""
    recursive = _RECURSIVE_GLOB.fullmatch(pattern)
    if not recursive:
        found = glob.glob(pattern, root_dir=folder or None)  # noqa: PTH207 (any pattern)
        yield from (os.path.join(folder, match) for match in found)  # noqa: PTH118 (empty, too)
        return
    head, tail = recursive.groups()
    for root in _matches(head, folder) if head else [folder]:
        if not tail:
            yield root or "."  # which is searched
            continue
        for below, _ in _folders(Path(root)):
            yield from _matches(tail, str(below))


def _folders(top: Path) -> Iterator[tuple[Path, list[str]]]:
    """The folder and those below it, each with its files, without hidden ones of either. Links to
    folders are not followed. Raises InputError where one can not be read, or where too many lie in
    one another."""

    def refuse(error: OSError):
        raise InputError(f"{error.filename}: the folder can not be read ({error.strerror})")

    for parent, folders, files in os.walk(top, onerror=refuse):
        path = Path(parent)
        if len(path.parts) - len(top.parts) > _MOST_NESTED:
            raise InputError(f"{top}: more than {_MOST_NESTED} folders lie in one another there")
        folders[:] = filter(_is_seen, folders)
        yield path, list(filter(_is_seen, files))


def _is_seen(name: str) -> bool:
    """Hidden is, among others, what macOS puts beside each file of an archive (`._a.ply`)."""
    return not name.startswith(".")


def _is_result(path: Path, searched: Path, results: _Results | None) -> bool:
    """Whether a search of the folder `searched` came to a result."""
    if results is None:
        return False
    place = _place(path)
    if not place.is_relative_to(results.folder):
        return False
    if searched.resolve() in results.folder.parents:
        return True
    return place.relative_to(results.folder).as_posix() in results.names


def _from_csv(path: Path):
    check_is_file(path)
    try:
        sources = [_with_long_name(source, path.parent) for source in _csv_rows(path)]
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: is no CSV file in UTF-8: {error}") from None
    # Those of a manifest lie elsewhere.
    apart = [os.path.normpath(s.mesh.parent.absolute()) for s in sources if not s.long_name]
    root = Path(os.path.commonpath(apart)) if apart else path.parent
    yield from (source if source.long_name else _with_long_name(source, root) for source in sources)


def _csv_rows(path: Path):
    with path.open(newline="", encoding="utf-8-sig") as stream:
        reader = csv.DictReader(stream, skipinitialspace=True)
        columns = reader.fieldnames = [name.strip() for name in reader.fieldnames or []]
        if "mesh" not in columns:
            raise InputError(f"{path}: must have a column 'mesh', but has {', '.join(columns)}")
        count_columns = [name for name in _COUNT_COLUMNS if name in columns]
        if len(count_columns) > 1:
            raise InputError(f"{path}: has columns {' and '.join(count_columns)}; leave one out")
        count_column = count_columns[0] if count_columns else None
        for row in reader:
            count = _count(path, reader.line_num, row.get(count_column) if count_column else None)
            if not (row["mesh"] or "").strip() or "\0" in row["mesh"]:
                raise InputError(f"{path}: line {reader.line_num}: names no mesh")
            mesh = path.parent / row["mesh"].strip()
            name = mesh.stem if count is None else f"{mesh.stem}-k{count}"
            yield Source(mesh, name, count)


def _count(path: Path, line: int, text: str | None) -> int | None:
    if text is None or not text.strip():
        return None
    try:
        count = int(text)
    except ValueError:
        count = 0
    if not 1 <= count <= _MOST_SUBMESHES:
        raise InputError(
            f"{path}: line {line}: expected a whole number from 1 to {_MOST_SUBMESHES}, found "
            f"'{text}'"
        )
    return count


def _with_long_name(source: Source, root: Path) -> Source:
    """With the folders from `root` to the mesh, if it lies below."""
    folder = Path(os.path.relpath(source.mesh.parent, root))
    if ".." in folder.parts:
        return source
    return replace(source, long_name=(folder / Path(source.name).name).as_posix())


def _with_unique_names(sources: list[Source]) -> list[Source]:
    """Meshes with one name that differ in their suffixes get these as part of it, others their
    long names."""
    uses = Counter((source.name, source.mesh.suffix.lower()) for source in sources)
    shared = {name for (name, _), count in uses.items() if count > 1}
    named = _with_suffixes(
        [
            replace(source, name=source.long_name or source.name)
            if source.name in shared
            else source
            for source in sources
        ]
    )
    first: dict[str, Source] = {}
    for source in named:
        other = first.setdefault(source.name, source)
        if other is not source:
            remedy = "rename one of them"
            if other.mesh.name == source.mesh.name:
                remedy = (
                    "to keep the folders in their names, give the folder above them or a glob in "
                    "quotes"
                )
            raise InputError(
                f"{other.mesh} and {source.mesh} would have one name in the output folder; "
                f"{remedy}; or use two output folders"
            )
    return named


def _with_suffixes(sources: list[Source]) -> list[Source]:
    uses = Counter(source.name for source in sources)
    return [
        source
        if uses[source.name] == 1
        else replace(source, name=f"{source.name}_{source.mesh.suffix[1:].lower()}")
        for source in sources
    ]
