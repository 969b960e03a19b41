# SPDX-License-Identifier: GPL-3.0-or-later
"""Memory that the system refuses: a helpful error, the mesh as it was, and the next call works.
And memory that many calls hold."""

import json
import os
import subprocess
import sys

import pytest
from mesh_paths import REPOSITORY
from processes import run_python

from spheroseg.api import PARAMETRIZE_FILTER, SEGMENT_FILTER

# One thread: where the system refuses a thread its stack, OpenMP ends the process.
SCRIPT = """
import json, resource, sys
import pymeshlab
from shapes import subdivided_sphere
from spheroseg import api
from spheroseg.errors import InputError

name, options = json.loads(sys.argv[1])
hard = resource.getrlimit(resource.RLIMIT_AS)[1]

def run(mesh_set):
    api.run_filter(mesh_set, name, **options)

def run_within(extra_bytes, mesh_set):
    used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + extra_bytes, hard))
    try:
        run(mesh_set)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))

def written(mesh_set):
    mesh = mesh_set.mesh(1)
    return {
        "layers": mesh_set.mesh_number(),
        "current": mesh_set.current_mesh_id(),
        "labels": mesh.face_scalar_array().tolist() if mesh.has_face_scalar() else None,
        "colors": mesh.face_color_matrix().tolist() if mesh.has_face_color() else None,
        "sphere": sphere(mesh),
    }

def sphere(mesh):
    try:
        return mesh.vertex_custom_point_attribute_matrix("sphere_position").tolist()
    except pymeshlab.PyMeshLabException:
        return None

def mesh_set_of(vertices, faces):
    mesh_set = pymeshlab.MeshSet()
    mesh_set.create_cube()  # so that the current layer is not the first
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces))
    return mesh_set

run(mesh_set_of(*subdivided_sphere(2)))
vertices, faces = subdivided_sphere(6)
whole = mesh_set_of(vertices, faces)
before = written(whole)
run(whole)
after = written(whole)
assert after != before
done, messages = 0, []
extra = 2**16
while extra < 2**27:
    # Another mesh each time: what was prepared for the last one is kept.
    mesh_set = mesh_set_of(vertices * 2.0 ** (len(messages) + 1), faces)
    try:
        run_within(extra, mesh_set)
        assert written(mesh_set) == after
        done += 1
        extra *= 2
    except InputError as error:
        messages.append(str(error))
        assert written(mesh_set) == before
        run(mesh_set)  # nothing is broken
        assert written(mesh_set) == after
        extra = extra * 5 // 4
print(json.dumps({"done": done, "messages": messages}))
"""


def run_script(script, argument):
    folders = [str(REPOSITORY / folder) for folder in ("python", "tests/python")]
    return subprocess.run(
        [sys.executable, "-c", script, argument],
        capture_output=True,
        text=True,
        env={
            **os.environ,
            "PYTHONPATH": os.pathsep.join(folders),
            # Blocks of memory go back to the system as soon as they are free.
            "MALLOC_MMAP_THRESHOLD_": "65536",
        },
    )


@pytest.mark.parametrize(
    ("name", "options"),
    [
        (SEGMENT_FILTER, {"submesh_count": 50, "effort": "draft", "thread_count": 1}),
        (PARAMETRIZE_FILTER, {"new_layer": True}),
    ],
    ids=["segmentation", "parametrization"],
)
def test_refused_memory_is_an_error_that_says_what_to_do_and_changes_nothing(name, options):
    done = run_script(SCRIPT, json.dumps([name, options]))
    assert done.returncode == 0, done.stderr
    outcome = json.loads(done.stdout)
    assert outcome["done"] >= 1
    assert outcome["messages"]
    assert all("There is not enough memory" in message for message in outcome["messages"])
    assert all("simplify the mesh" in message for message in outcome["messages"])


READING_SCRIPT = """
import resource, sys
import pymeshlab
from shapes import subdivided_sphere
from spheroseg import mesh_files
from spheroseg.errors import InputError

meshes = pymeshlab.MeshSet()
meshes.add_mesh(pymeshlab.Mesh(*subdivided_sphere(6)))
meshes.save_current_mesh(sys.argv[1])
hard = resource.getrlimit(resource.RLIMIT_AS)[1]
used = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 2**16, hard))
try:
    mesh_files.read_mesh(sys.argv[1])
except InputError as error:
    print(error)
resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
read = mesh_files.read_mesh(sys.argv[1])
assert read.current_mesh().face_number() == 32768
"""


def test_too_little_memory_to_read_a_mesh_is_an_error_that_says_what_to_do(tmp_path):
    mesh = tmp_path / "sphere.stl"
    done = run_script(READING_SCRIPT, str(mesh))
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"{mesh}: there is not enough memory to read it; close other")


REPEATED_SCRIPT = """
import resource
import pymeshlab
from spheroseg import api

def resident_bytes():
    return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize()

mesh_set = pymeshlab.MeshSet()
mesh_set.create_sphere(subdiv=5)

def resident_after(calls):
    for _ in range(calls):
        api.run_filter(mesh_set, api.SEGMENT_FILTER, submesh_count=100, effort="draft")
    return resident_bytes()

# Memory is given back after each million faces, the 49th, 98th and 147th call.
before = resident_after(50)
print((resident_after(100) - before) / 100 / mesh_set.current_mesh().face_number())
"""


def test_many_segmentations_of_one_mesh_do_not_hold_more_and_more_memory():
    """PyMeshLab keeps 14 kB of each call, less than a byte per face here; it was 30 once."""
    done = run_python("-c", REPEATED_SCRIPT)
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < 5, done.stdout
