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


@dataclass(frozen=True)
class LabelledMesh:
    """Vertices (V, 3), the sub-meshes and, where the mesh has them, (F, 3) uint8 face colours."""

    vertices: np.ndarray
    submeshes: SubMeshes
    face_colours: np.ndarray | None


def read(arguments) -> LabelledMesh:
    """The mesh with the labels of the file itself, of --labels or of a segmentation."""
    options = api.segment_parameters(segment.segment_options(arguments))
    if arguments.labels and options:
        option = next(iter(options)).replace("_", "-")
        raise InputError(f"--labels brings the labels; --{option} would make others")
    # The mesh lives as long as its MeshSet, so all arrays are taken here.
    mesh_set = mesh_files.read_mesh(arguments.mesh)
    labels = _labels(arguments, mesh_set, options)
    mesh = mesh_set.current_mesh()
    vertices = mesh.vertex_matrix()
    try:
        submeshes = split_into_submeshes(vertices, mesh.face_matrix(), labels)
    except InputError as error:
        raise InputError(f"{arguments.mesh}: {error}") from None
    return LabelledMesh(vertices, submeshes, mesh_files.face_colours(mesh))


def _labels(arguments, mesh_set: pymeshlab.MeshSet, options: dict) -> np.ndarray:
    if arguments.labels:
        return shared.read_labels(arguments.labels, mesh_set)
    if options.keys() & {"submesh_count", "triangles_per_submesh"}:
        shared.run_with_progress(
            mesh_set, arguments.mesh, "Segmenting", api.SEGMENT_FILTER, **options
        )
    elif not mesh_set.current_mesh().has_face_scalar():
        raise InputError(
            f"{arguments.mesh} has no labels: its faces carry no quality; name a file of labels "
            "with --labels, or segment it with -k N"
        )
    elif options:
        option = next(iter(options)).replace("_", "-")
        raise InputError(
            f"{arguments.mesh} has labels, which --{option} does not change; leave it out, or "
            "segment the mesh anew with -k N"
        )
    return mesh_set.current_mesh().face_scalar_array()
