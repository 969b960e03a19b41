# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes each sub-mesh of a labelled mesh as a PLY file of its own, and a manifest.

A file has the vertex property source_vertex and the face property source_face: the indices in
MESH. DIR/manifest.json names each file with its counts and its neighbours.
"""

from pathlib import Path

from spheroseg.commands import labelled, shared
from spheroseg.errors import InputError, counted
from spheroseg.split import MANIFEST_NAME, write_split


def add_arguments(parser):
    labelled.add_arguments(parser)
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder for the files")


def run(arguments) -> int:
    folder = Path(arguments.output)
    shared.check_folder(folder)
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder}: must be a new or an empty folder")
    mesh = labelled.read(arguments)
    write_split(
        mesh.submeshes,
        mesh.vertices,
        folder,
        arguments.mesh,
        mesh.face_colours,
        mesh.vertex_colours,
    )
    count = counted(mesh.submeshes.count, "sub-mesh", "es")
    print(f"{count} in {folder} ({MANIFEST_NAME} lists them)")
    return 0
