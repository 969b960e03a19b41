# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a labelled mesh in a form that a GPU reads: local vertices and indices per sub-mesh.

OUT.npz holds the arrays that docs/export.md lists, OUT.glb one primitive per sub-mesh.
"""

from pathlib import Path

from spheroseg.commands import labelled, shared
from spheroseg.errors import counted
from spheroseg.export import FORMATS, export, gltf_library


def add_arguments(parser):
    labelled.add_arguments(parser)
    parser.add_argument(
        "-o", "--output", metavar="OUT.glb|OUT.npz", required=True, help="file to write"
    )


def run(arguments) -> int:
    shared.check_output(arguments.output, *FORMATS)
    is_glb = Path(arguments.output).suffix.lower() == ".glb"
    if is_glb:
        gltf_library()
    mesh = labelled.read(arguments, every_vertex=not is_glb)
    submeshes = mesh.submeshes
    export(submeshes, Path(arguments.output), mesh.face_colours)
    bits = 8 * submeshes.triangles.dtype.itemsize
    count = counted(submeshes.count, "sub-mesh", "es")
    print(f"{count} with {bits}-bit indices in {arguments.output}")
    return 0
