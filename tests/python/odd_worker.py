# SPDX-License-Identifier: GPL-3.0-or-later
"""A worker (spheroseg.workers) whose tasks are what its processes must live through."""

import os
import sys
import time
from pathlib import Path

from spheroseg import workers
from spheroseg.errors import InputError


def prepare(job):
    if job.get("refuse"):
        raise InputError(job["refuse"])
    return {"fact": job.get("fact")}, do


def do(task):
    if "print" in task:
        print(task["print"])
    if "signal" in task:
        os.kill(os.getpid(), task["signal"])
    if "exit" in task:
        print("one line\nthe last line", file=sys.stderr)
        os._exit(task["exit"])
    if "raise" in task:
        raise {"memory": MemoryError(), "key": KeyError("k"), "input": InputError("no")}[
            task["raise"]
        ]
    if "sleep" in task:
        Path(task["mark"]).write_text(str(os.getpid()))
        time.sleep(task["sleep"])
    return {"status": "done", "process": os.getpid()}


if __name__ == "__main__":
    sys.exit(workers.serve(prepare))
