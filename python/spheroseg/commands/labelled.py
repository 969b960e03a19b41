# SPDX-License-Identifier: GPL-3.0-or-later
"""Input of the commands that need a mesh with labels."""

from dataclasses import dataclass

import numpy as np
import pymeshlab

from spheroseg import api, mesh_files
from spheroseg.commands import segment, shared
from spheroseg.errors import InputError
from spheroseg.submeshes import SubMeshes, split_into_submeshes


def add_arguments(parser) -> None:
    parser.add_argument("mesh", metavar="MESH", help="mesh file: ply, obj, off, stl, ...")
    parser.add_argument(
        "--labels", metavar="LABELS.npy|.txt", help="labels, one per triangle (default: MESH's own)"
    )
    group = parser.add_argument_group("to segment MESH first, with -k or --triangles-per-submesh")
    count = group.add_mutually_exclusive_group()
    count.add_argument("-k", "--submesh-count", type=int, metavar="N", help="into N sub-meshes")
    count.add_argument(
        "--triangles-per-submesh", type=int, metavar="N", help="into ceil(F / N) sub-meshes"
    )
    segment.add_segment_options(group)
    group.add_argument(
        "--weights",
        metavar="FILE.npy|.txt",
        help="weights, one per triangle, for --balance weight (default: areas)",
    )


@dataclass(frozen=True)
class LabelledMesh:
    """Vertices (V, 3), the sub-meshes and, where the mesh has them, uint8 colours: (F, 3) of faces
    and (V, 4) of vertices."""

    vertices: np.ndarray
    submeshes: SubMeshes
    face_colours: np.ndarray | None
    vertex_colours: np.ndarray | None


def read(arguments, every_vertex: bool = True) -> LabelledMesh:
    """The mesh with the labels of the file itself, of --labels or of a segmentation.

    `every_vertex`: what is written tells of vertices by their index in the file.
    """
    options = api.segment_parameters(segment.segment_options(arguments))
    given = [name.replace("_", "-") for name in options] + ["weights"] * bool(arguments.weights)
    if arguments.labels and given:
        raise InputError(f"--labels brings the labels; --{given[0]} would make others")
    # The mesh lives as long as its MeshSet, so all arrays are taken here.
    read_file = mesh_files.read_every_vertex if every_vertex else mesh_files.read_mesh
    mesh_set = read_file(arguments.mesh)
    labels = _labels(arguments, mesh_set, options, given)
    mesh = mesh_set.current_mesh()
    vertices = mesh.vertex_matrix()
    with shared.named(arguments.mesh):
        submeshes = split_into_submeshes(vertices, mesh.face_matrix(), labels)
    colours = mesh_files.face_colours(mesh), mesh_files.vertex_colours(mesh)
    return LabelledMesh(vertices, submeshes, *colours)


def _labels(arguments, mesh_set: pymeshlab.MeshSet, options: dict, given: list[str]) -> np.ndarray:
    if arguments.labels:
        return shared.read_labels(arguments.labels, mesh_set)
    if options.keys() & {"submesh_count", "triangles_per_submesh"}:
        shared.set_weights(arguments.weights, mesh_set, options)
        measures = shared.run_with_progress(
            mesh_set, arguments.mesh, "Segmenting", api.SEGMENT_FILTER, **options
        )
        shared.warn_of_shortcomings(arguments, measures, options)
    else:
        shared.require_labels(arguments.mesh, mesh_set, ", or segment it with -k N")
        if given:
            raise InputError(
                f"{arguments.mesh} has labels, which --{given[0]} does not change; leave it out, "
                "or segment the mesh anew with -k N"
            )
    return mesh_set.current_mesh().face_scalar_array()
