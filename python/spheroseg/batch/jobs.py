# SPDX-License-Identifier: GPL-3.0-or-later
"""A job, its record on disk, and the process that does it.

The record `DIR/.records/NAME.json` is written after all results, so its presence says that they
are whole. Everything a run needs to go on after a kill is in these records.
"""

import contextlib
import json
import threading
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from spheroseg import __version__, atomic, workers
from spheroseg.digests import plugin_digest, sha256, sha256_of
from spheroseg.errors import InputError, shown

FORMATS = (".ply", ".npy", ".npz", ".glb")
RECORD_FOLDER = ".records"
RESULT_LIST = f"{RECORD_FOLDER}/.results"
DISK_FULL_EXIT = 4
_DIGEST = "record_sha256"
_WORKER = "spheroseg.batch.worker"

_of_this_thread = threading.local()


@dataclass(frozen=True)
class Job:
    """One mesh to segment. Paths are text, so that a job travels as JSON or pickle.

    `options` are the filter's; `thread_count` is apart from them, as it changes no result.
    """

    mesh: str
    name: str
    folder: str
    options: dict[str, Any]
    formats: tuple[str, ...]
    version: dict[str, str]
    thread_count: int = 1

    def record_path(self) -> Path:
        return Path(self.folder) / RECORD_FOLDER / f"{self.name}.json"

    def output_path(self, suffix: str) -> Path:
        return Path(self.folder) / f"{self.name}{suffix}"

    def settings(self) -> dict[str, Any]:
        """What decides the result besides the mesh's content."""
        return {"options": self.options, "formats": list(self.formats), "version": self.version}


def versions() -> dict[str, str]:
    """Of all that decides a result."""
    return {
        "spheroseg": __version__,
        "pymeshlab": metadata.version("pymeshlab"),
        "plugin": plugin_digest(),
    }


def finished_record(job: Job) -> dict[str, Any] | None:
    """The job's record if the mesh, the settings and the results are those it tells of.

    The content tells the mesh, which may have another place than it had then.
    """
    try:
        record = read_record(job)
        if record["status"] != "done" or record["settings"] != job.settings():
            return None
        if record["input_sha256"] != sha256(Path(job.mesh)):
            return None
        for file, digest in record["outputs"].items():
            if sha256(Path(job.folder) / file) != digest:
                return None
    except (OSError, ValueError):
        return None  # no such record, or a damaged one
    return record | {"mesh": job.mesh}


def remove_results(job: Job, kept: tuple[str, ...] = ()) -> None:
    """Removes what earlier runs made of the job's mesh, but for formats that are `kept`."""
    known = known_results(Path(job.folder))
    mesh = file_identity(Path(job.mesh))
    for suffix in set(FORMATS) - set(kept):
        path = job.output_path(suffix)
        if f"{job.name}{suffix}" in known and file_identity(path) not in (None, mesh):
            path.unlink()


def file_identity(path: Path) -> tuple[int, int] | None:
    """The same for all paths of one file; None where there is none."""
    try:
        status = path.stat()
    except OSError:
        return None
    return status.st_dev, status.st_ino


def is_of_success(path: Path) -> bool:
    """Is this the record of a mesh that was done? A damaged one may be."""
    try:
        return json.loads(path.read_text())["status"] == "done"
    except (ValueError, KeyError, TypeError):
        return True


def remember_results(folder: Path, names: set[str]) -> None:
    """Stores the names in `folder` of all files that batches write there.

    Before the first of them, so that a run that is broken off leaves no result that nobody knows.
    """
    if names != known_results(folder):
        text = json.dumps(sorted(names), indent=0)
        atomic.write_text(folder / RESULT_LIST, text + "\n")


def known_results(folder: Path) -> set[str]:
    try:
        return set(json.loads((folder / RESULT_LIST).read_text()))
    except (OSError, ValueError, TypeError):
        return set()  # no such list, or a damaged one


def nursery() -> contextlib.closing[workers.Nursery]:
    """Where `run_job` does one job after the other, in a `with` block."""
    return contextlib.closing(workers.Nursery(_WORKER))


def kept_nursery(batch: str) -> workers.Nursery:
    """That of this thread for the jobs of a batch, whose name no other has: the next batch may have
    another build of the plugin. To be left open for the next job; it ends by itself."""
    kept = _of_this_thread
    if getattr(kept, "batch", None) != batch:
        if hasattr(kept, "nursery"):
            kept.nursery.close()
        kept.nursery = workers.Nursery(_WORKER)
        kept.batch = batch
    return kept.nursery


def run_job(job: Job, place: workers.Nursery) -> dict[str, Any]:
    """Does a job in a process of its own and returns its record; never raises for a bad mesh.

    A full disk gives a record with the status `disk_full`, which is not stored; neither is one
    whose file can not be written.
    """
    try:
        job.record_path().unlink(missing_ok=True)
        process = place.run(json.dumps(asdict(job)))
        # A signal may end a process that is done.
        if job.record_path().exists():
            return read_record(job)
        if process.returncode == DISK_FULL_EXIT:
            return failed_record(job, process.stderr.strip().splitlines()[-1], status="disk_full")
        record = failed_record(job, workers.failure_reason(process.returncode, process.stderr))
        store(job, record)
        return record
    except atomic.DiskFullError as error:
        return failed_record(job, error.strerror, status="disk_full")
    except (OSError, ValueError) as error:  # of a record that is damaged
        return failed_record(job, str(error))


def store(job: Job, record: dict[str, Any]) -> None:
    path = job.record_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps(record | {_DIGEST: _digest(record)}, indent=1)
    atomic.write_text(path, text + "\n")


def read_record(job: Job) -> dict[str, Any]:
    """The stored one. Raises ValueError where it is not as it was written, OSError for none."""
    path = job.record_path()
    record = json.loads(path.read_text())
    if not isinstance(record, dict) or record.pop(_DIGEST, None) != _digest(record):
        raise ValueError(f"{path}: is damaged")
    return record


def _digest(record: dict[str, Any]) -> str:
    return sha256_of(json.dumps(record).encode())


def failed_record(job: Job, error: str, status: str = "failed") -> dict[str, Any]:
    return undone_record(job, error) | {"status": status, "input_sha256": _digest_of_input(job)}


def undone_record(job: Job, error: str) -> dict[str, Any]:
    """Of a mesh of which nothing is known; it is not stored."""
    return {
        "mesh": shown(job.mesh),
        "name": job.name,
        "status": "undone",
        "error": error,
        "settings": job.settings(),
        "outputs": {},
    }


def _digest_of_input(job: Job) -> str | None:
    try:
        return sha256(Path(job.mesh))
    except (InputError, OSError):
        return None
