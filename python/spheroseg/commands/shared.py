# SPDX-License-Identifier: GPL-3.0-or-later
"""What the subcommands share: checks of paths, progress, the table of measures, JSON."""

import contextlib
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
from rich.console import Console
from rich.table import Table

from spheroseg import __version__, api, atomic, mesh_files
from spheroseg._command_line import complain
from spheroseg.arrays import as_labels
from spheroseg.errors import InputError
from spheroseg.file_checks import check_name
from spheroseg.progress import filter_progress

_WIDER_THAN_MEASURES = 200
_LABEL_SUFFIXES = (".npy", ".txt")


def add_report_arguments(parser) -> None:
    parser.add_argument("--json", metavar="OUT.json", help="write the measures as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="print no table of measures")


def check_output(path: str | None, *suffixes: str) -> None:
    """Refuses a path that could not be written later, before any work is done."""
    if path is None:
        return
    _check_path(Path(path))
    if Path(path).suffix.lower() not in suffixes:
        raise InputError(f"{path}: the name must end in {' or '.join(suffixes)}")
    if not Path(path).parent.is_dir():
        raise InputError(f"{path}: there is no folder {Path(path).parent}")
    if Path(path).is_dir():
        raise InputError(f"{path}: is a folder")
    if Path(path).exists() and not Path(path).is_file():
        raise InputError(f"{path}: is no ordinary file; name another one")
    atomic.check_place(Path(path))


def check_folder(folder: Path) -> None:
    """Refuses a folder, there or not, in which nothing could be written later."""
    _check_path(folder)
    nearest = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    try:
        atomic.check_place(nearest / "any")
    except OSError as error:
        error.filename = str(folder)
        raise


def _check_path(path: Path) -> None:
    with contextlib.suppress(FileNotFoundError):
        path.stat()  # raises for a name that is too long, and for links that lead in a circle
    check_name(path.resolve())


def check_outputs(arguments) -> None:
    check_output(arguments.output, ".ply")
    check_output(getattr(arguments, "labels", None), *_LABEL_SUFFIXES)
    check_output(arguments.json, ".json")


def read_labels(path: str, mesh_set: pymeshlab.MeshSet) -> np.ndarray:
    """Labels for the current mesh from a file."""
    labels = mesh_files.read_labels(path)
    with named(path):
        return as_labels(labels, mesh_set.current_mesh().face_number())


def set_weights(path: str | None, mesh_set: pymeshlab.MeshSet, options: dict[str, Any]) -> None:
    """Gives the current mesh the weights of a file, where there is one."""
    if path is None:
        return
    weights = mesh_files.read_weights(path)
    with named(path):
        api.set_face_weights(mesh_set, weights, options)


@contextlib.contextmanager
def named(path: str) -> Iterator[None]:
    """Puts the name of a file in front of what the `with` block refuses."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def require_labels(path: str, mesh_set: pymeshlab.MeshSet, otherwise: str = "") -> None:
    """Raises InputError where the current mesh has no face quality; `otherwise`: what could be done
    besides naming a file of labels."""
    if not mesh_set.current_mesh().has_face_scalar():
        raise InputError(
            f"{path} has no labels: its faces carry no quality (in ply: a property 'quality' of "
            f"the type float or double); name a file of labels with --labels{otherwise}"
        )


def warn(arguments, text: str) -> None:
    """Says one line about a result that lacks something."""
    complain(f"spheroseg {arguments.command}: warning: {text}")


def warn_of_shortcomings(arguments, measures: dict[str, Any], options: dict[str, Any]) -> None:
    """Warns where a segmentation with these options is not balanced, in pieces or has bowties."""
    missing = api.shortcomings(measures, options.get("balance", "triangle_count"))
    if missing:
        warn(arguments, f"the result for {arguments.mesh} has {missing}")


def tell_of_lost_vertices(arguments, count: int) -> None:
    """Warns of vertices of MESH that the output does not have."""
    if count > 0:
        warn(
            arguments,
            f"{arguments.output} is without {count} of the vertices of {arguments.mesh}, which no "
            "face names and whose coordinates are not finite (NaN); the others keep their order",
        )


def run_with_progress(
    mesh_set: pymeshlab.MeshSet, mesh_path: str, title: str, filter_name: str, **parameters: Any
) -> dict[str, Any]:
    """Runs a filter of the plugin; its refusals get the mesh's name in front."""
    with named(mesh_path), filter_progress(mesh_set, title):
        return api.run_filter(mesh_set, filter_name, **parameters)


def report(arguments, measures: dict[str, Any]) -> None:
    """Writes the JSON file that was asked for and prints the table of measures."""
    if arguments.json:
        content = {"mesh": arguments.mesh, "version": __version__, **api.plain(measures)}
        atomic.write_text(arguments.json, json.dumps(content, indent=2) + "\n")
    if not arguments.quiet:
        print_measures(measures)


def print_measures(measures: dict[str, Any]) -> None:
    """Prints the single values; the series of values per iteration are in the JSON file."""
    table = Table(show_header=False)
    table.add_column("measure")
    table.add_column("value", justify="right")
    for key, value in measures.items():
        if not isinstance(value, np.ndarray):
            table.add_row(key, _shown(value))
    console = Console(width=_WIDER_THAN_MEASURES)  # a narrow one would cut values
    with console.capture() as shown:
        console.print(table)
    # By Python, as the console would end the program where nobody reads.
    print(shown.get(), end="")


def _shown(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
