# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds the MeshLab plugin, loads it into PyMeshLab and binds its filters."""

import atexit
import contextlib
import functools
import os
import re
import signal
import threading
from pathlib import Path
from typing import Any

from spheroseg._host import pymeshlab  # before any other import of it
from spheroseg.errors import InputError, PluginError, one_line
from spheroseg.install import PLUGIN_FILE, plugin_host

PLUGIN_VARIABLE = "SPHEROSEG_PLUGIN"
_CANCELLED = "The operation was cancelled"  # says the engine (progress.h)

FILTERS = {
    "compute_scalar_by_balanced_segmentation_per_face": """\
Balanced Segmentation (SpheroSeg): writes the label 0..k-1 of each face as its quality.

Keyword arguments: submesh_count (int, 200, or ceil(F / 10) if that is less),
triangles_per_submesh (int, 0), method (default 'fast', or 'all_pairs'), effort (default 'standard',
or 'draft', 'high'), device (default 'auto', or 'cpu', 'cuda'), seed (int, 0), thread_count (int, 0:
all cores), max_cohesion_iterations, max_refinement_iterations (int, 0: until converged),
time_limit_seconds (float, 0: none), balance (default 'triangle_count', or 'weight'),
weight_attribute (str, '': areas), initial_labels (default 'none', or 'face_quality'), colorize
(bool, True). Returns the measures as a dictionary; see docs/measures.md.""",
    "compute_spherical_parametrization_per_vertex": """\
Spherical Parametrization (SpheroSeg): writes the vertex attribute 'sphere_position'.

Keyword argument: new_layer (bool, False), also makes a layer with those positions. Returns
flipped_triangle_count, min_triangle_area, area_distortion_mean, area_distortion_max, seconds.""",
    "get_segmentation_measures": """\
Segmentation Measures (SpheroSeg): measures the labels that face quality holds, whoever wrote them.

Returns the measures as a dictionary; see docs/measures.md.""",
    "generate_submesh_layers": """\
Split into Sub-mesh Layers (SpheroSeg): one layer per sub-mesh, with the attributes
'source_vertex' and 'source_face'. Returns layer_count.""",
}


# The plugin refuses a filter while another one runs. A fork waits for it too, as the child would
# find it running for ever. The handler of a signal that came meanwhile may call one or fork: Python
# calls it before the call that it met has returned.
_one_at_a_time = threading.RLock()
os.register_at_fork(
    before=_one_at_a_time.acquire,
    after_in_parent=_one_at_a_time.release,
    after_in_child=_one_at_a_time.release,
)
_of_this_thread = threading.local()
# The thread that ends this process, once it does.
_ending_thread: int | None = None
_CANCEL_SECONDS = 0.1


@atexit.register
def _end_filters() -> None:
    """Python ends daemon threads where they are; one that comes back from a filter then would abort
    the process. So a filter that runs is cancelled, or waited for where Ctrl-C is ignored or has a
    handler that is not Python's own, and daemon threads begin no other."""
    global _ending_thread
    _ending_thread = threading.get_ident()
    while not _one_at_a_time.acquire(timeout=_CANCEL_SECONDS):
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            with contextlib.suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
    _one_at_a_time.release()


def _is_ended() -> bool:
    """Is this a daemon thread of a process that ends?"""
    return _ending_thread not in (None, threading.get_ident())


def plugin_path() -> Path:
    """Path of the plugin that this package uses.

    In this order: the file that the environment variable SPHEROSEG_PLUGIN names, the one in the
    folder of this package, the one in the build folder `build/plugin` of a source checkout. Raises
    PluginError when there is none.
    """
    named = os.environ.get(PLUGIN_VARIABLE)
    if named:
        path = Path(named)
        if not path.is_file():
            raise PluginError(f"{PLUGIN_VARIABLE} names {named!r}, which is no file")
        return path.resolve()
    package = Path(__file__).resolve().parent
    candidates = [package / PLUGIN_FILE, package.parents[1] / "build" / "plugin" / PLUGIN_FILE]
    for path in candidates:
        if path.is_file():
            return path
    places = " and ".join(str(path) for path in candidates)
    raise PluginError(
        f"The MeshLab plugin is not built: expected it at {places}. Run `make plugin` in the "
        f"source folder, install the package with `pip install .`, or let {PLUGIN_VARIABLE} name "
        "the file."
    )


@functools.cache
def load_plugin() -> Path:
    """Loads the plugin into this process's PyMeshLab and makes its filters methods of MeshSet.

    Importing the package calls it; calling it again does nothing. Returns the plugin's path.
    Raises PluginError when the plugin is missing or does not fit the installed PyMeshLab.
    """
    path = plugin_path()
    if not _loaded_filters():
        _check_host(path)
        try:
            pymeshlab.load_plugin(str(path))
        except pymeshlab.PyMeshLabException as error:
            raise PluginError(_load_failure(path, str(error))) from None
    for name in _loaded_filters():
        setattr(pymeshlab.MeshSet, name, _bound_filter(name))
    return path


def apply_filter(mesh_set: pymeshlab.MeshSet, name: str, parameters: dict[str, Any]) -> Any:
    """MeshSet.apply_filter for the plugin's filters, after those that other threads are running.

    Nothing is left behind by a failed call. A filter that a Ctrl-C has cancelled
    (filter_spheroseg/interrupt.h) ends with what the handler of the signal raises, or with
    KeyboardInterrupt where that raises nothing. Raises InputError where a parameter has a type or
    size that PyMeshLab does not take, PluginError where the filter would never end.
    """
    with _one_at_a_time:
        if _is_ended():
            raise SystemExit  # in silence
        if parameters.get("thread_count") != 1:
            _refuse_after_fork()
        try:
            return mesh_set.apply_filter(name, **parameters)
        except pymeshlab.PyMeshLabException as error:
            try:
                forget_failed_call()
            except BaseException as raised:
                # Of a signal that came during the filter: Python calls its handler only now.
                forget_failed_call()
                raise raised from None
            if _CANCELLED in str(error):
                raise SystemExit if _is_ended() else KeyboardInterrupt from None
            raise
        except RuntimeError:
            forget_failed_call()
            misfits = _misfits(mesh_set, name, parameters)
            if not misfits:
                raise
            raise InputError("; ".join(misfits)) from None


def _misfits(mesh_set: pymeshlab.MeshSet, name: str, parameters: dict[str, Any]) -> list[str]:
    """What is wrong with parameters that PyMeshLab can not convert; its own error names none."""
    kinds = {int: "a whole number of 32 bits", float: "a number", bool: "a bool", str: "a string"}
    defaults = mesh_set.filter_parameter_values(name)
    misfits = []
    for key, value in parameters.items():
        try:
            mesh_set.filter_parameter_values(name, **{key: value})
        except RuntimeError:
            kind = kinds[type(defaults[key])]
            misfits.append(f"{key} must be {kind}, got {value!r} (see help(MeshSet.{name}))")
    return misfits


def _refuse_after_fork() -> None:
    """OpenMP waits for ever in a forked child for the threads that the forking thread had."""
    process = os.getpid()
    if getattr(_of_this_thread, "parallel_process", process) != process:
        raise PluginError(
            "This process was forked from one that had run a SpheroSeg filter on several threads, "
            "which it can not do again: start it with multiprocessing's method 'spawn' or "
            "'forkserver', or use thread_count=1 in one of the two"
        )
    _of_this_thread.parallel_process = process


def forget_failed_call() -> None:
    """To be called after PyMeshLab has thrown, while the MeshSet of the failed call still exists.

    PyMeshLab keeps a pointer to the log of a MeshSet whose call has failed, and the next file that
    is loaded writes there, when that MeshSet may be long gone: a crash (its issues 384 and 399).
    Any filter that succeeds resets the pointer.
    """
    pymeshlab.MeshSet().apply_filter("create_cube")


def _loaded_filters() -> list[str]:
    present = set(pymeshlab.filter_list())
    return [name for name in FILTERS if name in present]


def _bound_filter(name: str):
    def filter_method(self, **parameters):
        return apply_filter(self, name, parameters)

    filter_method.__name__ = name
    filter_method.__qualname__ = f"MeshSet.{name}"
    filter_method.__doc__ = FILTERS[name]
    return filter_method


def _running_release() -> str:
    return str(pymeshlab.pmeshlab.__version__)


def _meshlab_release(pymeshlab_release: str) -> str:
    """PyMeshLab 2025.7.post1 -> the MeshLab release 2025.07 inside it."""
    year, month = re.match(r"(\d+)\.(\d+)", pymeshlab_release).groups()
    return f"{year}.{int(month):02d}"


def _check_host(path: Path) -> None:
    try:
        host = plugin_host(path)
    except InputError as error:
        raise PluginError(str(error)) from None
    running = _meshlab_release(_running_release())
    if host.release != running:
        year, month = host.release.split(".")
        wanted = f"{year}.{int(month)}"
        raise PluginError(
            f"The plugin {path} was built for PyMeshLab {wanted} (MeshLab {host.release}), but "
            f"PyMeshLab {_running_release()} (MeshLab {running}) is installed. Install pymeshlab "
            f"{wanted}, or build the plugin again for this release."
        )
    if host.scalar != "double":
        raise PluginError(
            f"The plugin {path} was built for {host}; PyMeshLab needs one in double precision "
            "(`make plugin`)."
        )


def _load_failure(path: Path, reason: str) -> str:
    return (
        f"PyMeshLab {_running_release()} can not load the plugin {path}: "
        f"{one_line(reason)} Build it again for this release (`make plugin`)."
    )
