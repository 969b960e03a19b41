# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the labels of a mesh: those in its face quality, or those in LABELS.

LABELS hold one whole number per triangle, in the order of the file.
"""

from spheroseg import api, mesh_files
from spheroseg.commands import shared


def add_arguments(parser):
    parser.add_argument("mesh", metavar="MESH", help="mesh file: ply, obj, off, stl, ...")
    parser.add_argument("--labels", metavar="LABELS.npy|.txt", help="labels, one per triangle")
    shared.add_report_arguments(parser)


def run(arguments) -> int:
    shared.check_output(arguments.json, ".json")
    mesh_set = mesh_files.read_mesh(arguments.mesh)
    mesh = mesh_set.current_mesh()
    if arguments.labels:
        labels = shared.read_labels(arguments.labels, mesh_set)
        mesh_set = api.labelled_mesh_set(mesh.vertex_matrix(), mesh.face_matrix(), labels)
    else:
        shared.require_labels(arguments.mesh, mesh_set)
    measures = shared.run_with_progress(mesh_set, arguments.mesh, "Measuring", api.MEASURE_FILTER)
    counts = {
        "submesh_count": len(measures["submesh_triangles"]),
        "triangle_count": mesh_set.current_mesh().face_number(),
    }
    shared.report(arguments, dict(sorted({**measures, **counts}.items())))
    return 0
