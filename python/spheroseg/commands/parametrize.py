# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps a closed genus-0 mesh onto the unit sphere without a flipped triangle.

SPHERE.ply has the mesh's vertices and faces in their order, each vertex at its place on the sphere.
"""

from spheroseg import api, atomic, mesh_files
from spheroseg.commands import shared
from spheroseg.ply import ply_bytes


def add_arguments(parser):
    parser.add_argument("mesh", metavar="MESH", help="mesh file: ply, obj, off, stl, ...")
    parser.add_argument("-o", "--output", metavar="SPHERE.ply", required=True, help="the sphere")
    shared.add_report_arguments(parser)


def run(arguments) -> int:
    shared.check_outputs(arguments)
    mesh_set, lost = mesh_files.read_counting_lost(arguments.mesh)
    measures = shared.run_with_progress(
        mesh_set, arguments.mesh, "Parametrizing", api.PARAMETRIZE_FILTER
    )
    faces = mesh_set.current_mesh().face_matrix()
    atomic.write_bytes(arguments.output, ply_bytes(api.sphere_positions(mesh_set), faces))
    shared.tell_of_lost_vertices(arguments, lost)
    shared.report(arguments, measures)
    return 0
