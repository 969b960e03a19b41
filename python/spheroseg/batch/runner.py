# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the jobs of a batch and writes the manifest."""

import asyncio
import contextlib
import csv
import errno
import io
import logging
import math
import queue
import secrets
import shlex
import signal
import time
from collections.abc import Callable, Iterator
from concurrent import futures
from dataclasses import asdict
from pathlib import Path
from typing import Any

from spheroseg import atomic
from spheroseg.batch.jobs import (
    RECORD_FOLDER,
    RESULT_LIST,
    Job,
    failed_record,
    file_identity,
    finished_record,
    is_of_success,
    known_results,
    nursery,
    read_record,
    remember_results,
    remove_results,
    run_job,
    undone_record,
)
from spheroseg.errors import InputError, one_line, shown
from spheroseg.file_checks import check_name
from spheroseg.lock import locked
from spheroseg.workers import Nursery

MANIFEST_STEM = "manifest"
MANIFEST_FORMS = ("csv", "parquet")
TIMINGS_NAME = "timings.csv"
_LOCK_NAME = f"{RECORD_FOLDER}/.lock"
_GRACE_SECONDS = 2
_IDLE_SECONDS = 10
_POLL_SECONDS = 0.05
_ARRIVAL_SECONDS = 60  # for as long NFS may remember by default that a file is not there
_ARRIVAL_POLL_SECONDS = 0.2
_ANSWER_SECONDS = 15

# Measures of the manifest: all single values that are the same on every run.
_MEASURES = (
    "submesh_count",
    "triangle_count",
    "min_submesh_triangles",
    "max_submesh_triangles",
    "max_triangle_count_difference",
    "best_max_triangle_count_difference",
    "may_be_balanced",
    "component_count",
    "weight_imbalance",
    "coefficient_of_variation",
    "boundary_edge_count",
    "boundary_edge_ratio",
    "bowtie_count",
    "disconnected_submesh_count",
    "disk_count",
    "cohesion_iterations",
    "refinement_iterations",
    "time_limit_hit",
    "used_cuda",
)
_OPTIONS = ("method", "effort", "seed", "balance")
_IDENTITY = ("status", "settings", "input_sha256", "outputs")
_SECONDS = ("parametrization_seconds", "cohesion_seconds", "refinement_seconds", "total_seconds")

Record = dict[str, Any]


@contextlib.contextmanager
def prepared_folder(
    folder: Path, jobs: list[Job], lists: list[Path], resume: bool
) -> Iterator[None]:
    """Makes the output folder, which is for this run alone while the `with` block runs. Refuses one
    where another batch writes, one with earlier results unless they are to be resumed, and one
    where a result would replace a mesh of the jobs, one of the `lists` of meshes, or any file that
    no batch has written there; and jobs of which one needs a folder where a file will lie."""
    _check_folders(folder.absolute(), jobs)
    records = folder / RECORD_FOLDER
    if not records.is_dir():
        _checked_results(folder, jobs, lists, resume)  # a refusal leaves nothing
    records.mkdir(parents=True, exist_ok=True)
    with locked(folder, _LOCK_NAME, "batch"):
        remember_results(folder, _checked_results(folder, jobs, lists, resume))
        yield


def _checked_results(folder: Path, jobs: list[Job], lists: list[Path], resume: bool) -> set[str]:
    """The names of all results in the folder, those to come included."""
    records = [path for path in (folder / RECORD_FOLDER).rglob("*.json") if path.is_file()]
    if not resume and any(map(is_of_success, records)):
        raise InputError(
            f"{folder}: has results of an earlier run; add --resume to do only what is missing or "
            "changed, or name another folder"
        )
    known = known_results(folder)
    results = set(known) if resume else set()
    inputs = {file_identity(Path(path)) for path in (*(job.mesh for job in jobs), *lists)} - {None}
    for path, source in _outputs(folder.absolute(), jobs):
        name = path.relative_to(folder.absolute()).as_posix()
        results.add(name)
        found = file_identity(path)
        if found in inputs:
            raise InputError(
                f"{path}: is an input, and {source} would replace it; name another output folder"
            )
        if found and name not in known:
            raise InputError(
                f"{path}: is there already, and {source} would replace it; name another output "
                "folder"
            )
    return results


def _check_folders(folder: Path, jobs: list[Job]) -> None:
    """Raises InputError where a file of the batch would lie where it needs a folder."""
    files = dict(_outputs(folder, jobs))
    files |= {job.record_path(): f"the record of {job.mesh}" for job in jobs}
    files |= {folder / _LOCK_NAME: "the lock", folder / RESULT_LIST: "the list of results"}
    needed = {path.parent: source for path, source in files.items()}
    for parent, source in needed.items():
        for place in (parent, *parent.parents):
            if place in files:
                raise InputError(
                    f"{place}: {source} needs such a folder, but {files[place]} lies there; rename "
                    "the folder or file of the mesh"
                )


def _outputs(folder: Path, jobs: list[Job]) -> Iterator[tuple[Path, str]]:
    """Each file that a batch writes, and what it is."""
    for job in jobs:
        for suffix in job.formats:
            yield job.output_path(suffix), f"the result of {job.mesh}"
    for form in MANIFEST_FORMS:
        yield folder / f"{MANIFEST_STEM}.{form}", "the manifest"
    yield folder / TIMINGS_NAME, "the table of timings"


def run_all(
    jobs: list[Job],
    on_record: Callable[[Record], None],
    *,
    resume: bool,
    worker_count: int,
    on_hint: Callable[[str], None],
    client: Any = None,
    scheduler: str | None = None,
) -> list[Record]:
    """Does the jobs that have no valid record yet; returns all records in the order of `jobs`. Of
    a mesh that fails now, earlier results are removed.

    `client`: of `cluster`, with the address of its `scheduler`; without, they are done here.

    `on_record` gets each record as it comes, `on_hint` what holds the run up. Raises DiskFullError
    when a job finds the disk full; jobs that have not begun are left undone then, for a later run
    with `resume`. Where the scheduler is lost, those that are not done have records with the status
    `undone`. After a KeyboardInterrupt those that run here are ended, too.
    """
    records: dict[str, Record] = {}
    waiting: dict[str, Job] = {}
    for job in jobs:
        record = _refused_record(job) or (finished_record(job) if resume else None)
        if record is None:
            waiting[job.name] = job
        else:
            records[job.name] = record
            on_record(record)
    to_do = list(waiting.values())
    if client is not None:
        source = _on_dask(to_do, client, scheduler, on_hint)
    else:
        source = _on_this_machine(to_do, worker_count)
    try:
        for record in source:
            if record["status"] == "disk_full":
                source.close()
                raise atomic.DiskFullError(errno.ENOSPC, record["error"])
            records[record["name"]] = record
            # Of a mesh that is not there, as on a disk that is not mounted, nothing is outdated.
            if record["status"] == "failed" and record["input_sha256"] is not None:
                try:
                    remove_results(waiting[record["name"]])
                except OSError as error:
                    record["error"] += f"; an earlier result stays: {error}"
            on_record(record)
    except KeyboardInterrupt as interrupt:
        source.throw(interrupt)
    return [records[job.name] for job in jobs]


def _refused_record(job: Job) -> Record | None:
    """Of a mesh whose name neither PyMeshLab nor Dask takes."""
    try:
        check_name(Path(job.mesh))
    except InputError as error:
        return failed_record(job, str(error).removeprefix(f"{shown(job.mesh)}: "))
    return None


def _on_this_machine(jobs: list[Job], worker_count: int) -> Iterator[Record]:
    idle = queue.SimpleQueue()

    def do(job: Job) -> Record:
        place = idle.get()
        try:
            return run_job(job, place)
        finally:
            idle.put(place)

    # Threads only wait here; each job is a process.
    with contextlib.ExitStack() as stack, futures.ThreadPoolExecutor(worker_count) as pool:
        places = [stack.enter_context(nursery()) for _ in range(worker_count)]
        for place in places:
            idle.put(place)
        submitted = []
        try:
            for job in jobs:
                submitted.append(pool.submit(do, job))
            for future in futures.as_completed(submitted):
                yield future.result()
        except KeyboardInterrupt:
            # A second Ctrl-C would break off what ends the processes that do not hear of the first.
            # Not SIG_IGN, which a process that is just begun would inherit.
            before = signal.signal(signal.SIGINT, lambda *_: None)
            try:
                pool.shutdown(wait=False, cancel_futures=True)
                _end_running(submitted, places)
            finally:
                signal.signal(signal.SIGINT, before)
            raise
        finally:
            pool.shutdown(cancel_futures=True)


def _end_running(submitted: list[futures.Future], places: list[Nursery]) -> None:
    """Ends what runs, and what was just about to begin, and waits for it."""
    began = time.monotonic()
    while not all(future.done() for future in submitted):
        patient = time.monotonic() - began < _GRACE_SECONDS
        for place in places:
            place.interrupt() if patient else place.kill()
        futures.wait(submitted, timeout=_POLL_SECONDS)


@contextlib.contextmanager
def cluster(scheduler: str | None) -> Iterator[Any]:
    """A Dask client of the scheduler with this address, while the `with` block runs; None for none.
    Raises InputError where no scheduler answers."""
    if scheduler is None:
        yield None
        return
    from distributed import Client

    for name in ("distributed", "distributed.client"):  # has a level of its own
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        asyncio.run(_ask_for_scheduler(scheduler))
        client = Client(scheduler, timeout=_ANSWER_SECONDS, set_as_default=False)
    # Of the last two kinds are those of encryption.
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise InputError(f"no Dask scheduler answers at {scheduler}: {error}") from None
    with client:
        yield client


async def _ask_for_scheduler(address: str) -> None:
    """Raises an error where none answers. A client would wait without end for one that speaks
    another protocol, and half a minute after any other error."""
    from distributed.comm import get_address_host_port
    from distributed.core import rpc
    from distributed.security import Security

    get_address_host_port(address)  # half a minute for one without a port
    encryption = Security().get_connection_args("client")
    async with rpc(address, timeout=_ANSWER_SECONDS, connection_args=encryption) as remote:
        try:
            # Later than what says that nobody is there.
            found = (await asyncio.wait_for(remote.identity(), _ANSWER_SECONDS + 1))["type"]
        except TimeoutError as error:
            raise OSError(str(error) or "what is there speaks no Dask") from None
    if found != "Scheduler":
        raise ValueError(f"it is the address of a {found}")


def _on_dask(
    jobs: list[Job], client, scheduler: str, on_hint: Callable[[str], None]
) -> Iterator[Record]:
    # A local function travels by value. One of this module would be imported by the scheduler,
    # where the package need not be, and where PyMeshLab, imported in a thread, aborts at exit.
    def run_on_worker(job: Record) -> Record:
        import socket

        host = socket.gethostname()
        try:
            from spheroseg.batch.jobs import Job, kept_nursery, run_job
        except ImportError as error:
            raise ImportError(f"on {host}: {error}") from None  # PluginError does not travel
        return run_job(Job(**job), kept_nursery(batch)) | {"host": host}

    def on_idle() -> None:
        on_hint(
            f"the Dask scheduler at {scheduler} has no worker; the run goes on when you start one: "
            f"dask worker {scheduler}"
        )

    # Clients of one scheduler that ask for one key all get the result of the first.
    batch = secrets.token_hex(8)
    # A job is done again when its worker is lost; its results are the same, written whole.
    submitted = {
        client.submit(
            run_on_worker,
            asdict(job),
            pure=False,
            retries=3,
            fifo_timeout="0 ms",  # else those of a tenth of a second have no order among them
            key=f"spheroseg-{batch}-{job.name}",
        ): job
        for job in jobs
    }
    try:
        results = _ResultsOfCluster()
        for future in _as_completed(client, list(submitted), on_idle):
            job = submitted[future]
            try:
                # None for one that is cancelled, as all are without a scheduler; its result
                # is an error then.
                error = future.exception()
                record = None if error else future.result()
            except (futures.CancelledError, OSError):
                lost = f"the Dask scheduler at {scheduler} was lost, or has cancelled the work"
                yield finished_record(job) or undone_record(job, lost)
                continue
            if error is None:
                yield results.checked(job, record)
            else:
                # Its workers may have died with other meshes, after they had done this one.
                message = one_line(f"{type(error).__name__}: {error}")
                yield finished_record(job) or failed_record(job, message)
            future.release()  # else it would be done again when its worker is lost later
    finally:
        client.cancel(list(submitted))


def _as_completed(client, submitted: list, on_idle: Callable[[], None]) -> Iterator:
    """The futures as they are done. `on_idle` is called, once until the next one is done, where
    some seconds bring none and no worker is there."""
    from distributed import as_completed

    completed = as_completed(submitted, loop=client.loop)
    idle_since = time.monotonic()
    while not completed.is_empty():
        if completed.has_ready():
            yield next(completed)
            idle_since = time.monotonic()
            continue
        time.sleep(_POLL_SECONDS)
        if time.monotonic() - idle_since > _IDLE_SECONDS:
            if client.scheduler_info()["workers"]:
                idle_since = time.monotonic()
            else:
                on_idle()
                idle_since = math.inf


class _ResultsOfCluster:
    """Believes a record of a worker only when what it tells of is here.

    A network file system may show new files late, so the first that is missing is waited for; when
    it does not come, the folder is taken for one that is not shared, and no other is waited for.
    """

    def __init__(self):
        self.patience = _ARRIVAL_SECONDS

    def checked(self, job: Job, record: Record) -> Record:
        """The record, or that of a failure."""
        if record["settings"] != job.settings():
            return failed_record(job, "the cluster gave the result of other settings; try again")
        is_unseen = record["status"] == "failed" and record["input_sha256"] is None
        if is_unseen and Path(job.mesh).is_file():
            error = f"{record['error']} on {record['host']}, but here: each worker must see it, too"
            return record | {"error": error}
        if record["status"] != "done" or self._has_arrived(job, record):
            return record
        return failed_record(
            job,
            f"done on {record['host']}, but the result is not in {job.folder} here: DIR must be a "
            "folder that all machines share",
        )

    def _has_arrived(self, job: Job, record: Record) -> bool:
        end = time.monotonic() + self.patience
        while not _is_here(job, record):
            if time.monotonic() >= end:
                self.patience = 0
                return False
            time.sleep(_ARRIVAL_POLL_SECONDS)
        return True


def _is_here(job: Job, record: Record) -> bool:
    try:
        stored = read_record(job)
        # Not of an earlier run; times differ where a lost worker did the job, too.
        same = all(stored[name] == record[name] for name in _IDENTITY)
    except (OSError, ValueError):
        return False
    return same and all((Path(job.folder) / name).is_file() for name in record["outputs"])


def write_manifest(folder: Path, records: list[Record], form: str) -> Path:
    """Writes the manifest (`csv` or `parquet`) and the timings; returns the manifest's path.

    The manifest is the same however often the run was broken off; what changes from run to run is
    in the timings.
    """
    rows = [_row(record) for record in records]
    path = folder / f"{MANIFEST_STEM}.{form}"
    for other in set(MANIFEST_FORMS) - {form}:
        (folder / f"{MANIFEST_STEM}.{other}").unlink(missing_ok=True)  # of an earlier run
    if form == "parquet":
        atomic.write_bytes(path, _parquet_bytes(rows))
    else:
        atomic.write_text(path, _csv_text(rows))
    timings = [
        {"mesh": record["mesh"], "seconds": record.get("seconds")}
        | {name: record.get("measures", {}).get(name) for name in _SECONDS}
        for record in records
    ]
    atomic.write_text(folder / TIMINGS_NAME, _csv_text(timings))
    return path


def _row(record: Record) -> dict[str, Any]:
    settings = record["settings"]
    outputs = record["outputs"]
    row = {"mesh": record["mesh"], "status": record["status"], "error": record["error"]}
    row |= {name: record.get("measures", {}).get(name) for name in _MEASURES}
    if "measures" not in record:
        row["submesh_count"] = settings["options"].get("submesh_count")  # as a list, of all meshes
    row |= {name: settings["options"].get(name) for name in _OPTIONS}
    row |= {
        "input_sha256": record.get("input_sha256"),
        "outputs": shlex.join(outputs),
        "output_sha256": " ".join(outputs.values()),
    }
    return row | settings["version"]


def _csv_text(rows: list[dict[str, Any]]) -> str:
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, fieldnames=list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return buffer.getvalue()


def _parquet_bytes(rows: list[dict[str, Any]]) -> bytes:
    import pyarrow
    from pyarrow import parquet

    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.Table.from_pylist(rows), sink)
    return sink.getvalue().to_pybytes()
