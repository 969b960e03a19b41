# SPDX-License-Identifier: GPL-3.0-or-later
"""The process of one job, which is JSON: writes results and, last, the record.

Exit codes: 0 done, 1 failed with the reason as the last line of stderr, 4 the disk is full; of a
nursery, where it is interrupted.
"""

import contextlib
import json
import signal
import socket
import sys
import time
from pathlib import Path

import numpy as np
import numpy.ma  # noqa: F401 (which numpy imports when it is used, in each process that was forked)

from spheroseg import api, atomic, mesh_files
from spheroseg.batch.jobs import (
    DISK_FULL_EXIT,
    Job,
    remove_results,
    store,
    versions,
)
from spheroseg.digests import sha256
from spheroseg.errors import InputError, MissingPackageError, PluginError, one_line
from spheroseg.export import glb_bytes, gltf_library, npz_bytes
from spheroseg.ply import colour_properties, ply_bytes
from spheroseg.submeshes import split_into_submeshes
from spheroseg.workers import nurse


def prepare(text: str) -> None:
    if ".glb" in json.loads(text)["formats"]:
        with contextlib.suppress(MissingPackageError):  # the job says so
            gltf_library()


def do(text: str) -> int:
    _be_interrupted_once()
    job = Job(**json.loads(text))
    try:
        _check_versions(job)
        record = _record(job)
        remove_results(job, kept=job.formats)
        store(job, record)
    except atomic.DiskFullError as error:
        print(error.strerror, file=sys.stderr)
        return DISK_FULL_EXIT
    except (InputError, PluginError, ImportError, OSError, MemoryError) as error:
        message = str(error).removeprefix(f"{job.mesh}: ")
        print(one_line(message) or type(error).__name__, file=sys.stderr)
        return 1
    return 0


def _check_versions(job: Job) -> None:
    """The record tells of the versions that the batch was started with."""
    here = versions()
    differing = [
        f"{name} {here.get(name)} instead of {job.version.get(name)}"
        for name in sorted(here | job.version)
        if here.get(name) != job.version.get(name)
    ]
    if differing:
        raise PluginError(
            f"{socket.gethostname()} has {', '.join(differing)}; a batch needs the same everywhere"
        )


def _record(job: Job) -> dict:
    began = time.perf_counter()
    digest = sha256(Path(job.mesh))
    has_indices = ".npz" in job.formats
    read_mesh = mesh_files.read_every_vertex if has_indices else mesh_files.read_mesh
    mesh_set = read_mesh(job.mesh)
    options = job.options | {"thread_count": job.thread_count}
    measures = api.plain(api.run_filter(mesh_set, api.SEGMENT_FILTER, **options))
    mesh = mesh_set.current_mesh()
    labels = mesh.face_scalar_array().astype(np.int32)
    outputs = {}
    for suffix in job.formats:
        path = job.output_path(suffix)
        path.parent.mkdir(parents=True, exist_ok=True)
        atomic.write_bytes(path, _content(suffix, mesh, labels))
        outputs[path.relative_to(job.folder).as_posix()] = sha256(path)
    return {
        "mesh": job.mesh,
        "name": job.name,
        "status": "done",
        "error": "",
        "settings": job.settings(),
        "input_sha256": digest,
        "outputs": outputs,
        "measures": measures,
        "seconds": time.perf_counter() - began,
    }


def _content(suffix: str, mesh, labels: np.ndarray) -> bytes:
    vertices, faces = mesh.vertex_matrix(), mesh.face_matrix()
    colours = mesh_files.face_colours(mesh)
    if suffix == ".ply":
        properties = {"quality": labels.astype(np.float32)} | colour_properties(colours)
        of_vertices = colour_properties(mesh_files.vertex_colours(mesh))
        return ply_bytes(vertices, faces, of_vertices, properties)
    if suffix == ".npy":
        return mesh_files.npy_bytes(labels)
    submeshes = split_into_submeshes(vertices, faces, labels)
    return npz_bytes(submeshes) if suffix == ".npz" else glb_bytes(submeshes, colours)


def _be_interrupted_once() -> None:
    """Of a Ctrl-C in a terminal both this process and its parent hear, and the parent passes it on:
    the second one must not disturb what the first one has to clean up."""

    def interrupt(*_):
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, interrupt)


if __name__ == "__main__":
    sys.exit(nurse(do, prepare))
