# SPDX-License-Identifier: GPL-3.0-or-later
"""Where and with what a report was made."""

import platform
import subprocess
from importlib import metadata
from pathlib import Path

from spheroseg import __version__
from spheroseg.cores import core_count

_PACKAGES = ("pymeshlab", "numpy", "pymetis", "kaminpar", "mtkahypar", "numba", "pyvista")


def describe(command: str, seeds: str) -> dict[str, str]:
    """Names and values for the report, in the order in which they are shown."""
    return {"command": command, "seed": seeds, "threads": _threads()} | surroundings()


def surroundings() -> dict[str, str]:
    """The part that does not depend on what was run."""
    facts = {"SpheroSeg": __version__, "commit": _commit()}
    for package in _PACKAGES:
        try:
            facts[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            facts[package] = "not installed"
    facts["Python"] = platform.python_version()
    facts["system"] = f"{platform.system()} {platform.release()} {platform.machine()}"
    facts["processor"] = _first_value("/proc/cpuinfo", "model name") or platform.processor()
    facts["cores"] = str(core_count())
    memory = _first_value("/proc/meminfo", "MemTotal")
    if memory:
        facts["memory"] = f"{int(memory.split()[0]) / 2**20:.1f} GiB"
    return facts


def machine(facts: dict[str, str]) -> str:
    """What a time depends on, in a few words."""
    return f"{facts['processor']}, {facts['cores']} cores"


def _threads() -> str:
    """Ours has as many as the plugin takes by default, the processors that it may use."""
    return f"{core_count()} for our methods, 1 for the others"


def _commit() -> str:
    file = Path(__file__).resolve()
    try:
        git = ["git", "-C", str(file.parent)]
        ask = {"capture_output": True, "text": True, "check": True}
        # An installed package may lie in a checkout of something else.
        subprocess.run([*git, "ls-files", "--error-unmatch", file.name], **ask)
        commit = subprocess.run([*git, "rev-parse", "--short=12", "HEAD"], **ask).stdout.strip()
        changes = subprocess.run([*git, "status", "--porcelain", "-uno"], **ask).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return "unknown (not a checkout)"
    return f"{commit} with local changes" if changes else commit


def _first_value(file: str, name: str) -> str | None:
    try:
        lines = Path(file).read_text().splitlines()
    except OSError:
        return None
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith(name)), None)
