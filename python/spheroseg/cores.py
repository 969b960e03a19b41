# SPDX-License-Identifier: GPL-3.0-or-later
"""The processor cores of this process."""

import math
import os
from collections.abc import Iterator
from pathlib import Path

_GROUPS = Path("/sys/fs/cgroup")
_OWN_GROUP = Path("/proc/self/cgroup")


def core_count() -> int:
    """How many cores this process may run on, which is also how many threads OpenMP starts. Fewer
    than the machine has where the affinity is restricted, as in a job of Slurm."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def busy_core_count() -> int:
    """How many of these cores the process can keep busy: fewer where a control group limits its
    processor time (`docker --cpus`, the limits of Kubernetes); fractions are rounded up."""
    return min([core_count(), *map(math.ceil, _shares())])


def _shares() -> Iterator[float]:
    """The limits, in cores, of the control groups that the process is in.

    Of version 1 of control groups only the outermost one is read: in a container its own.
    """
    group = _GROUPS / _text(_OWN_GROUP).rpartition("::")[2].strip().strip("/")
    limits = [_text(folder / "cpu.max") for folder in (group, *group.parents)]
    limits.append(
        " ".join(_text(_GROUPS / f"cpu/cpu.cfs_{name}_us") for name in ("quota", "period"))
    )
    for limit in limits:
        numbers = limit.split()
        if len(numbers) == 2 and all(map(str.isdigit, numbers)):  # not "max" or "-1"
            yield int(numbers[0]) / int(numbers[1])


def _text(path: Path) -> str:
    try:
        return path.read_text()
    except OSError:
        return ""
