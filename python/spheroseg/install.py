# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the desktop plugin where a MeshLab installation looks for plugins of its user.

MeshLab loads a plugin only if it was built for the same release and the same precision; another one
gives an error message at each of its starts. So both are compared before the file is copied.
"""

import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from spheroseg import atomic
from spheroseg.errors import InputError, PluginError

PLUGIN_FILE = "libfilter_spheroseg.so"
DESKTOP_PLUGIN_VARIABLE = "SPHEROSEG_DESKTOP_PLUGIN"

# Written into the plugin by filter_spheroseg.cpp.
_HOST_MARKER = re.compile(rb"SpheroSeg built for MeshLab (\d+\.\d+)\w* \((float|double)\)")
_PROGRAM_SECONDS = 60
_PRECISIONS = {"float": "single", "double": "double"}


@dataclass(frozen=True)
class Host:
    """What a plugin and its MeshLab must have in common."""

    release: str
    scalar: str

    def __str__(self) -> str:
        return f"MeshLab {self.release} in {_PRECISIONS[self.scalar]} precision"


def desktop_plugin_path() -> Path:
    """Path of the plugin for the MeshLab application.

    In this order: the file that SPHEROSEG_DESKTOP_PLUGIN names, the one in the folder `desktop`
    of this package, the one in the build folder `build/gui` of a source checkout. Raises
    PluginError when there is none.
    """
    named = os.environ.get(DESKTOP_PLUGIN_VARIABLE)
    if named:
        if not Path(named).is_file():
            raise PluginError(f"{DESKTOP_PLUGIN_VARIABLE} names {named!r}, which is no file")
        return Path(named).resolve()
    package = Path(__file__).resolve().parent
    candidates = [
        package / "desktop" / PLUGIN_FILE,
        package.parents[1] / "build" / "gui" / PLUGIN_FILE,
    ]
    for path in candidates:
        if path.is_file():
            return path
    places = " and ".join(str(path) for path in candidates)
    raise PluginError(
        f"The plugin for the MeshLab application is not built: expected it at {places}. Run "
        f"`make plugin-gui` in the source folder, or let {DESKTOP_PLUGIN_VARIABLE} name the file."
    )


def plugin_host(plugin: Path) -> Host:
    """The MeshLab that a plugin file was built for. Raises InputError for a foreign file."""
    found = _HOST_MARKER.search(plugin.read_bytes())
    if found is None:
        raise InputError(f"{plugin} is not a SpheroSeg plugin")
    release, scalar = (part.decode() for part in found.groups())
    return Host(release, scalar)


def meshlab_host(program: str | os.PathLike) -> Host:
    """Asks a MeshLab program for its release and precision."""
    try:
        answer = subprocess.run(
            [program, "--version"], capture_output=True, text=True, timeout=_PROGRAM_SECONDS
        ).stdout
    except (OSError, subprocess.TimeoutExpired) as error:
        raise InputError(f"{program} can not be run: {error}") from None
    found = re.search(r"MeshLab (\d+\.\d+)(\w*)", answer)
    if found is None:
        raise InputError(f"{program} --version does not answer as MeshLab does: {answer.strip()!r}")
    # MeshLab marks a build in double precision by a d behind its version.
    return Host(found[1], "double" if found[2].startswith("d") else "float")


def user_plugin_folder(host: Host) -> Path:
    """The folder in which that MeshLab looks for plugins that its user added."""
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    precision = "fp" if host.scalar == "float" else "dp"
    return Path(data) / "VCG" / f"MeshLab_64bit_{precision}" / "MeshLabExtraPlugins" / host.release


def install_plugin(
    directory: str | os.PathLike | None = None,
    *,
    meshlab: str | os.PathLike | None = None,
    plugin: str | os.PathLike | None = None,
) -> Path:
    """Copies the plugin to where a desktop MeshLab looks for it; returns the copy's path.

    directory: plugin folder of a MeshLab installation; default the user's own folder of extra
        plugins for the MeshLab that is found.
    meshlab: the MeshLab program (an AppImage too); default `meshlab` on the PATH, asked for its
        version. Not asked when `directory` is given without it.
    plugin: the plugin file; default the package's one for the desktop application.

    Raises InputError when there is no such MeshLab or folder, PluginError when there is no plugin
    or it was built for another release or precision; the message has both.
    """
    source = Path(plugin) if plugin is not None else desktop_plugin_path()
    if not source.is_file():
        raise InputError(f"There is no plugin file {source}")
    built_for = plugin_host(source)
    host = _find_host(directory, meshlab)
    if host is not None and host != built_for:
        raise PluginError(
            f"The plugin {source} was built for {built_for}, but {host} is installed. Build it "
            "again with that release's headers (MESHLAB_SOURCE_DIR) and precision "
            "(SPHEROSEG_SCALAR), or install the MeshLab that it was built for."
        )
    if directory is None:
        target = user_plugin_folder(host)
        target.mkdir(parents=True, exist_ok=True)
    else:
        target = Path(directory)
        if not target.is_dir():
            raise InputError(f"{target} is no folder; expected a plugin folder of MeshLab")
    # A new file in the place of the old one: a running MeshLab keeps the one that it has loaded.
    with atomic.atomic_path(target / PLUGIN_FILE) as temporary:
        shutil.copy2(source, temporary)
    return target / PLUGIN_FILE


def _find_host(directory: str | os.PathLike | None, meshlab: str | os.PathLike | None):
    """The MeshLab to install for, or None when a bare folder says nothing about it."""
    if meshlab is not None:
        return meshlab_host(meshlab)
    if directory is not None:
        return _host_of_folder(Path(directory))
    program = shutil.which("meshlab")
    if program is None:
        raise InputError(
            "No MeshLab was found: there is no program `meshlab` on the PATH. Name it with "
            "--meshlab PROGRAM (the AppImage, for example), or name its plugin folder with "
            "--directory DIR."
        )
    return meshlab_host(program)


def _host_of_folder(directory: Path) -> Host | None:
    found = re.search(
        r"MeshLab_64bit_([fd])p/MeshLabExtraPlugins/(\d+\.\d+)", directory.absolute().as_posix()
    )
    if found is None:
        return None
    return Host(found[2], "float" if found[1] == "f" else "double")
