# SPDX-License-Identifier: GPL-3.0-or-later
"""A nursery (spheroseg.workers) whose jobs are what its processes must live through."""

import json
import os
import signal
import sys
import time

import odd_worker

from spheroseg import workers

prepared = 0


def prepare(job):
    global prepared
    prepared = json.loads(job).get("prepare", prepared)


def do(job):
    task = json.loads(job)
    print(os.getpid(), os.getppid(), repr(sys.stdin.read()), flush=True)
    print("x" * task.get("length", 0), file=sys.stderr)
    odd_worker.do(task)
    return task.get("code", prepared)


if __name__ == "__main__":
    print(end=os.environ.get("GREETING", ""))  # as a library that is imported might
    if "SLOW_FORK" in os.environ:  # as on a busy machine: the job is first to go on
        os.register_at_fork(after_in_parent=lambda: time.sleep(0.5))
    if "EARLY_INTERRUPT" in os.environ:
        os.register_at_fork(after_in_child=lambda: os.kill(os.getpid(), signal.SIGINT))
    sys.exit(workers.nurse(do, prepare))
