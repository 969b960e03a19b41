# SPDX-License-Identifier: GPL-3.0-or-later
"""The processor cores of this process."""

import math
import os
from collections.abc import Iterator
from pathlib import Path

_GROUPS = Path("/sys/fs/cgroup")
_OWN_GROUP = Path("/proc/self/cgroup")


def core_count() -> int:
    """Those that it may run on, in a job of Slurm not all that the machine has; OpenMP starts as
    many threads."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed else os.cpu_count() or 1


def busy_core_count() -> int:
    """As many of them as it can keep busy: a container may have a share of their time (`docker
    --cpus`, the limits of Kubernetes), which is rounded up."""
    return min([core_count(), *map(math.ceil, _shares())])


def _shares() -> Iterator[float]:
    """The limits in cores of the control groups that the process is in.

    With version 1 of such groups only that of a container, which sees its own as the outermost.
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
