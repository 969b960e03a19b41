# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that reads a file of a format that is not checked before: a damaged one may end it.

A task names a mesh and the PLY into which it is copied with all that it has.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import pymeshlab

from spheroseg import mesh_files, workers
from spheroseg.errors import InputError


def prepare(_: workers.Message) -> tuple[workers.Message, Callable]:
    """See `workers.serve`."""
    return {}, _copy


def _copy(task: workers.Message) -> workers.Message:
    try:
        mesh_set = mesh_files.load(Path(task["mesh"]))
        try:
            mesh_set.save_current_mesh(task["copy"], save_textures=True)
        except pymeshlab.PyMeshLabException:
            # A texture inside a file may have a name under which no picture can be saved.
            mesh_set.save_current_mesh(task["copy"], save_textures=False, save_wedge_texcoord=False)
    except (InputError, MemoryError, pymeshlab.PyMeshLabException) as error:
        return {"refused": workers.explained(error)}
    return {}


if __name__ == "__main__":
    sys.exit(workers.serve(prepare))
