# SPDX-License-Identifier: GPL-3.0-or-later
"""Segments many meshes, each in a process of its own, and writes a manifest of the results.

INPUTS are mesh files, folders (searched below), globs, or CSV files with the columns mesh and, if
wanted, submesh_count. A mesh that fails costs one line and exit code 1; the others go on. A run
that was broken off, killed included, continues with --resume. docs/batch.md tells more.
"""

from pathlib import Path

from spheroseg import api, atomic
from spheroseg._command_line import complain
from spheroseg.batch import inputs, runner
from spheroseg.batch.jobs import FORMATS, RECORD_FOLDER, Job, file_identity, versions
from spheroseg.commands import shared
from spheroseg.commands.segment import add_segment_options, segment_options
from spheroseg.cores import busy_core_count
from spheroseg.errors import InputError
from spheroseg.file_checks import check_is_file
from spheroseg.packages import require_all
from spheroseg.progress import MeshProgress

# Of the filter; given here so that the manifest tells of them, and so that to give them changes
# nothing.
_DEFAULTS = {
    "method": "fast",
    "effort": "standard",
    "device": "auto",
    "seed": 0,
    "balance": "triangle_count",
    "max_cohesion_iterations": 0,
    "max_refinement_iterations": 0,
    "time_limit_seconds": 0.0,
}


def add_arguments(parser):
    parser.add_argument("inputs", metavar="INPUTS", nargs="+", help="meshes, folders, globs, CSV")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder for results")
    count = parser.add_mutually_exclusive_group()
    count.add_argument(
        "-k", "--submesh-count", type=int, metavar="N", help="where no CSV says otherwise"
    )
    count.add_argument("--triangles-per-submesh", type=int, metavar="N")
    parser.add_argument(
        "--formats",
        default="ply",
        metavar="LIST",
        help="results per mesh, out of ply,npy,npz,glb (ply: labelled and coloured)",
    )
    parser.add_argument("--manifest", choices=runner.MANIFEST_FORMS, default="csv")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="meshes at a time here (all cores)")
    where.add_argument("--scheduler", metavar="tcp://...", help="run on this Dask cluster instead")
    parser.add_argument(
        "--resume", action="store_true", help="do only what is missing, failed or changed"
    )
    add_segment_options(parser)


def run(arguments) -> int:
    if arguments.workers is not None and arguments.workers < 1:
        raise InputError(f"--workers must be 1 or more, got {arguments.workers}")
    folder = Path(arguments.output)
    for place in (folder, folder / RECORD_FOLDER):
        shared.check_folder(place)
    _check_packages(arguments)
    jobs, workers = _jobs(arguments)
    lists = [Path(text) for text in arguments.inputs]
    try:
        with (
            runner.cluster(arguments.scheduler) as client,  # where none answers, nothing is touched
            runner.prepared_folder(folder, jobs, lists, arguments.resume),
        ):
            atomic.remove_leftovers(folder)
            return _run(arguments, jobs, workers, client)
    except atomic.DiskFullError as error:
        complain(f"spheroseg batch: {error.strerror} with --resume")
        return 1


def _run(arguments, jobs: list[Job], workers: int, client) -> int:
    with MeshProgress("Segmenting", len(jobs)) as progress:

        def done(record: dict) -> None:
            if record["status"] == "failed":
                progress.say_failed(f"{record['mesh']}: {record['error']}")
            progress.advance()

        records = runner.run_all(
            jobs,
            done,
            resume=arguments.resume,
            worker_count=workers,
            on_hint=lambda hint: progress.say(f"spheroseg batch: {hint}"),
            client=client,
            scheduler=arguments.scheduler,
        )
    manifest = runner.write_manifest(Path(arguments.output), records, arguments.manifest)
    lost = next((record["error"] for record in records if record["status"] == "undone"), None)
    if lost:
        complain(f"spheroseg batch: {lost}; go on with --resume")
    finished = [record for record in records if record["status"] == "done"]
    print(f"{len(finished)} of {len(records)} meshes done{_short(finished)}; {manifest}")
    return 0 if len(finished) == len(records) else 1


def _short(finished: list[dict]) -> str:
    """How many results fall short of what `fast` aims at, in brackets; empty for none."""
    short = [
        record["measures"]
        for record in finished
        if api.shortcomings(record["measures"], record["settings"]["options"]["balance"])
    ]
    hopeless = sum(not api.can_be_balanced(measures) for measures in short)
    of_these = f"; {hopeless} of these can not be balanced" if hopeless else ""
    text = f" ({len(short)} not balanced within a triangle, in pieces or with bowties{of_these})"
    return text if short else ""


def _jobs(arguments) -> tuple[list[Job], int]:
    """The jobs, and how many of them run at a time on this machine."""
    options = _DEFAULTS | api.segment_parameters(segment_options(arguments))
    _check_options(options, on_cluster=bool(arguments.scheduler))
    threads = options.pop("thread_count", None)
    asked = [f".{name}" for name in _formats(arguments)]
    for name in asked:
        if name not in FORMATS:
            known = ", ".join(form[1:] for form in FORMATS)
            raise InputError(f"--formats knows {known}, but not '{name[1:]}'")
    formats = tuple(name for name in FORMATS if name in asked)
    sources = inputs.collect(arguments.inputs, Path(arguments.output), resume=arguments.resume)
    if not (arguments.resume or any(file_identity(source.mesh) for source in sources)):
        check_is_file(sources[0].mesh)  # else each fails on its own
    # Several meshes at a time use the cores better than several threads on one mesh.
    workers = min(arguments.workers or busy_core_count(), len(sources))
    if threads is None:
        threads = 1 if arguments.scheduler else max(1, busy_core_count() // workers)
    version = versions()
    jobs = [
        Job(
            mesh=str(source.mesh.absolute()),
            name=source.name,
            folder=str(Path(arguments.output).absolute()),
            options=_own_options(options, source.submesh_count),
            formats=formats,
            version=version,
            thread_count=threads,
        )
        for source in sources
    ]
    return jobs, workers


def _formats(arguments) -> list[str]:
    return [name.strip() for name in arguments.formats.split(",")]


def _check_options(options: dict, on_cluster: bool) -> None:
    """What is wrong, or missing, for every mesh is said once, before the first."""
    count = options.get("submesh_count", 1)
    if count < 1:
        raise InputError(f"submesh_count must be 1 or more, found {count}")
    left_out = {"submesh_count", "triangles_per_submesh"} | ({"device"} if on_cluster else set())
    others = {name: value for name, value in options.items() if name not in left_out}
    api.segment(*api.TETRAHEDRON, 1, **others)


def _check_packages(arguments) -> None:
    """All that is missing is said before the first mesh."""
    purposes = {}
    if "glb" in _formats(arguments):
        purposes["pygltflib"] = "--formats glb"
    if arguments.manifest == "parquet":
        purposes["pyarrow"] = "--manifest parquet"
    if arguments.scheduler:
        purposes["distributed"] = "--scheduler"
    require_all(purposes)


def _own_options(options: dict, submesh_count: int | None) -> dict:
    if submesh_count is None:
        return options
    others = {name: v for name, v in options.items() if name != "triangles_per_submesh"}
    return others | {"submesh_count": submesh_count}
