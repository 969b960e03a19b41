# SPDX-License-Identifier: GPL-3.0-or-later
"""The processor cores of this process."""

import os


def core_count() -> int:
    """Those that it may use: in a container or a job of Slurm not all that the machine has."""
    allowed = getattr(os, "sched_getaffinity", None)
    return len(allowed(0)) if allowed else os.cpu_count() or 1
