# SPDX-License-Identifier: GPL-3.0-or-later
"""The process that reads a file of a format that is not checked before: a damaged one may end it.

A task names a mesh, by its whole path, and the PLY into which it is copied with all that it has.
"""

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pymeshlab

from spheroseg import mesh_files, workers
from spheroseg.errors import InputError
from spheroseg.textures import copy_textures, give_coordinates_to_faces

_BUFFER = 65536  # at least that of a C library's stream


def prepare(_: workers.Message) -> tuple[workers.Message, Callable]:
    """See `workers.serve`."""
    return {}, _copy


def _copy(task: workers.Message) -> workers.Message:
    source, copy = Path(task["mesh"]), Path(task["copy"])
    # MeshLab looks for images in the working folder first, then beside the mesh.
    os.chdir(copy.parent)
    try:
        mesh_set = mesh_files.load(source)
        # A ply has no place for the transformation of a glTF node or a 3mf item.
        mesh_set.apply_matrix_freeze()
        _save(mesh_set, source, copy)
    except InputError as error:
        return {"refused": str(error).removeprefix(f"{source}: ")}
    except MemoryError as error:
        return {"refused": workers.explained(error)}
    except (OSError, pymeshlab.PyMeshLabException) as error:
        place = copy.parent.parent
        return {
            "refused": f"no copy of it, which is read in its place, can be written to {place}; is "
            "the disk full? Make room, or let the environment variable TMPDIR name another folder "
            f"({workers.explained(error)})"
        }
    return {}


def _save(mesh_set: pymeshlab.MeshSet, source: Path, copy: Path) -> None:
    give_coordinates_to_faces(mesh_set)
    mesh_set.save_current_mesh(str(copy), save_textures=False)
    # In a folder that is not in the working folder, where MeshLab looks for images first.
    images = copy.parent / copy.parent.name
    images.mkdir()
    copy_textures(mesh_set.current_mesh(), source, copy, images, f"{images.name}/")
    # MeshLab's writer does not tell when the last bytes, of its buffer, find no room.
    copy.with_name("room").write_bytes(bytes(_BUFFER))


if __name__ == "__main__":
    sys.exit(workers.serve(prepare))
