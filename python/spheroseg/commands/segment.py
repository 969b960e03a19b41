# SPDX-License-Identifier: GPL-3.0-or-later
"""Cuts a mesh into balanced sub-meshes and writes the labels.

OUT.ply keeps the mesh's faces in their order; each face has its label as quality and a colour.
LABELS hold one whole number per triangle, in the order of the file.
"""

from spheroseg import api, mesh_files
from spheroseg.commands import shared
from spheroseg.errors import InputError


def add_arguments(parser):
    parser.add_argument("mesh", metavar="MESH", help="mesh file: ply, obj, off, stl, ...")
    count = parser.add_mutually_exclusive_group()
    count.add_argument(
        "-k",
        "--submesh-count",
        type=int,
        metavar="N",
        help="number of sub-meshes (200, or ceil(F / 10) if that is less)",
    )
    count.add_argument(
        "--triangles-per-submesh", type=int, metavar="N", help="cut into ceil(F / N) sub-meshes"
    )
    parser.add_argument("-o", "--output", metavar="OUT.ply", help="labelled and coloured mesh")
    parser.add_argument("--labels", metavar="OUT.npy|.txt", help="labels, one per triangle")
    add_segment_options(parser)
    parser.add_argument(
        "--weights",
        metavar="FILE.npy|.txt",
        help="weights, one per triangle, for --balance weight (default: areas)",
    )
    parser.add_argument(
        "--initial-labels",
        metavar="FILE.npy|.txt",
        help="repair, balance and refine these labels; k is the number of different ones",
    )
    shared.add_report_arguments(parser)


def add_segment_options(parser):
    """The options of the method, for every command that segments."""
    parser.add_argument("--method", choices=api.METHODS, help="segmentation method (fast)")
    parser.add_argument(
        "--balance", choices=api.BALANCES, help="what is equal in all sub-meshes (triangle_count)"
    )
    parser.add_argument("--effort", choices=api.EFFORTS, help="how long `fast` refines (standard)")
    parser.add_argument("--device", choices=api.DEVICES, help="where to compute (auto)")
    parser.add_argument("--seed", type=int, metavar="N", help="same seed, same labels (0)")
    parser.add_argument(
        "--threads", dest="thread_count", type=int, metavar="N", help="threads (0: all cores)"
    )
    parser.add_argument(
        "--time-limit",
        dest="time_limit_seconds",
        type=float,
        metavar="S",
        help="stop improving after S seconds; the result is still balanced (0: no limit)",
    )
    for step in ("cohesion", "refinement"):
        parser.add_argument(
            f"--max-{step}-iterations",
            type=int,
            metavar="N",
            help=f"stop {step} after N iterations (0: when converged)",
        )


def segment_options(arguments) -> dict:
    """The options that were given, by the filter's names."""
    names = ["submesh_count", "triangles_per_submesh", "method", "effort", "device", "seed"]
    names += ["balance", "thread_count", "time_limit_seconds"]
    names += ["max_cohesion_iterations", "max_refinement_iterations"]
    given = {name: getattr(arguments, name, None) for name in names}
    size = given["triangles_per_submesh"]
    if size is not None and size < 1:  # 0 would mean the default k
        raise InputError(f"triangles_per_submesh must be 1 or more, got {size}")
    return {name: value for name, value in given.items() if value is not None}


def run(arguments) -> int:
    options = api.segment_parameters(segment_options(arguments))
    shared.check_outputs(arguments)
    mesh_set, lost = mesh_files.read_counting_lost(arguments.mesh)
    shared.set_weights(arguments.weights, mesh_set, options)
    if arguments.initial_labels:
        labels = shared.read_labels(arguments.initial_labels, mesh_set)
        api.check_label_count(labels, options)
        mesh_files.set_labels(mesh_set, labels)
        options["initial_labels"] = "face_quality"
    measures = shared.run_with_progress(
        mesh_set, arguments.mesh, "Segmenting", api.SEGMENT_FILTER, **options
    )
    if arguments.output:
        left_out = mesh_files.save_ply(mesh_set, arguments.output, arguments.mesh)
        if left_out:
            shared.warn(
                arguments,
                f"{arguments.output} lacks textures of {arguments.mesh} that are not there, can "
                f"not be read or are no images: {', '.join(left_out)}",
            )
        shared.tell_of_lost_vertices(arguments, lost)
    if arguments.labels:
        labels = mesh_set.current_mesh().face_scalar_array()
        mesh_files.save_labels(labels, arguments.labels)
    shared.warn_of_shortcomings(arguments, measures, options)
    shared.report(arguments, measures)
    return 0
