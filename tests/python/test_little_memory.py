# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory that the system refuses: an error that helps, and the next call works."""

import json
import os
import subprocess
import sys

from mesh_paths import REPOSITORY

# One thread: where the system refuses a thread its stack, OpenMP ends the process.
SCRIPT = """
import collections, json, resource
import numpy as np
import pymeshlab
from shapes import subdivided_sphere
from spheroseg import api
from spheroseg.errors import InputError

hard = resource.getrlimit(resource.RLIMIT_AS)[1]

def labels_within(extra_bytes, vertices, faces):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces))
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + extra_bytes, hard))
    try:
        options = {"submesh_count": 50, "effort": "draft", "thread_count": 1}
        api.run_filter(mesh_set, api.SEGMENT_FILTER, **options)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    return mesh_set.current_mesh().face_scalar_array()

labels_within(2**30, *subdivided_sphere(2))
vertices, faces = subdivided_sphere(6)
results = []
messages = []
for step in range(1, 20):
    try:
        # Another mesh each time: what was prepared for the last one is kept.
        results.append(labels_within(2**16 * 2**(step // 2), step * vertices, faces))
    except InputError as error:
        messages.append(str(error))
assert all(np.array_equal(labels, results[0]) for labels in results)
print(json.dumps({"done": len(results), "messages": messages}))
"""


def test_refused_memory_is_an_error_that_says_what_to_do():
    folders = [str(REPOSITORY / folder) for folder in ("python", "tests/python")]
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(folders)},
    )
    assert done.returncode == 0, done.stderr
    outcome = json.loads(done.stdout)
    assert outcome["done"] >= 1
    assert outcome["messages"]
    assert all("There is not enough memory" in message for message in outcome["messages"])
    assert all("simplify the mesh" in message for message in outcome["messages"])
