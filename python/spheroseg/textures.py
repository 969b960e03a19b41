# SPDX-License-Identifier: GPL-3.0-or-later
"""The images of a mesh, which go where the mesh goes.

PyMeshLab puts a picture of its own in place of an image that it can not decode (JPEG) or find, and
forgets the name. So the names are read in the mesh's file, and the images are copied as they are.
"""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

import pymeshlab

from spheroseg import atomic
from spheroseg._plugin import forget_failed_call
from spheroseg.ply_faces import read_ply_header

#: Else a mesh from somewhere could have any file of this machine copied to where its result goes.
_IMAGE_SUFFIXES = (
    *(".bmp", ".dds", ".exr", ".gif", ".hdr", ".jpeg", ".jpg", ".ktx", ".ktx2"),
    *(".pgm", ".png", ".ppm", ".tga", ".tif", ".tiff", ".webp"),
)
#: What PyMeshLab calls an image that it does not have.
_PLACEHOLDER = "dummy.png"
#: Qt's number for the least compression but none: a fourth of the default's time, a sixth larger.
_FAST_PNG = 80
_IN_PLY = re.compile(rb"^(comment TextureFile[ \t]+)([^\r\n]*[^ \t\r\n])", re.M)
_IN_OBJ = re.compile(rb"^[ \t]*(mtllib[ \t]+)([^\r\n]*[^ \t\r\n])", re.M)
_IN_MTL = re.compile(rb"^[ \t]*(map_Kd[ \t]+)([^\r\n]*[^ \t\r\n])", re.M | re.I)


def copy_textures(
    mesh: pymeshlab.Mesh, source: Path, ply: Path, folder: Path, prefix: str = ""
) -> list[str]:
    """Copies the images of a mesh that was read from `source` into `folder`, and names them in
    `ply`, which MeshLab wrote of it, with `prefix` in front.

    An image keeps its name, without folders, and gets a number where another file has that name.
    What has no image's name is not copied. Returns the names of those that could not be.
    """
    header = read_ply_header(ply)
    written = _names(_IN_PLY, header)
    images = _images(source) if written else []
    if len(images) != len(written):
        images = [(old, []) for old in written]
    names, left_out = [], []
    # MeshLab keeps the order.
    for old, (name, folders) in zip(written, images, strict=True):
        if old not in (_PLACEHOLDER, name):
            name, folders = old, []
        if not name.lower().endswith(_IMAGE_SUFFIXES):
            folders = []
        found = filter(None, (content_of(place / name) for place in folders))
        content = next(found, None)
        names.append(name.rpartition("/")[2])
        # Where folders are known, PyMeshLab may have one of that name from the working folder only.
        if not folders and (content := _decoded(mesh, old)):
            names[-1] = _as_png(names[-1])
        if content:
            names[-1] = _place(content, folder, names[-1])
        else:
            left_out.append(name)
    names = [prefix + name for name in names]
    if names != written:
        following = map(os.fsencode, names)
        renamed = _IN_PLY.sub(lambda line: line[1] + next(following), header)
        ply.write_bytes(renamed + ply.read_bytes()[len(header) :])
    return left_out


def give_coordinates_to_faces(mesh_set: pymeshlab.MeshSet) -> None:
    """Where vertices have texture coordinates and there are several images. MeshLab's writer of ply
    files looks up the image of each face then, and ends the process where faces have none."""
    mesh = mesh_set.current_mesh()
    is_of_vertices = mesh.has_vertex_tex_coord() and not mesh.has_wedge_tex_coord()
    if is_of_vertices and mesh.texture_number() > 1:
        mesh_set.compute_texcoord_transfer_vertex_to_wedge()


def _images(source: Path) -> list[tuple[str, list[Path]]]:
    """The names of the images in a mesh's file, each with the folders where it may be."""
    suffix = source.suffix.lower()
    if suffix == ".ply":
        return [(name, [source.parent]) for name in _names(_IN_PLY, read_ply_header(source))]
    if suffix not in (".obj", ".qobj"):
        return []
    with source.open("rb") as lines:
        naming = b"".join(line for line in lines if b"mtllib" in line)
    images: dict[str, list[Path]] = {}
    for library in material_libraries(naming, source):
        for name in _names(_IN_MTL, content_of(library) or b""):
            # Options stand before the name.
            name = name.split()[-1] if name.startswith("-") else name
            images.setdefault(name, [source.parent, library.parent])
    return list(images.items())


def material_libraries(text: bytes, source: Path) -> list[Path]:
    """The files of materials that are named in a text of an obj file."""
    return [source.parent / name for name in _names(_IN_OBJ, text)]


def _names(pattern: re.Pattern[bytes], text: bytes) -> list[str]:
    return [os.fsdecode(name).replace("\\", "/") for _, name in pattern.findall(text)]


def content_of(path: Path) -> bytes | None:
    """What is in a file that is there and can be read."""
    try:
        return path.read_bytes() if path.is_file() else None
    except OSError:
        return None


def _decoded(mesh: pymeshlab.Mesh, name: str) -> bytes | None:
    """An image as PyMeshLab has it, which is without a file of its own in glTF, as PNG: it writes
    no JPEG, and nothing under a name without a suffix, as images inside glTF have."""
    if name == _PLACEHOLDER or name not in mesh.textures():
        return None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "image.png"
        try:
            mesh.textures()[name].save(str(path), _FAST_PNG)
        except pymeshlab.PyMeshLabException:
            forget_failed_call()
        return content_of(path)


def _as_png(name: str) -> str:
    stem = Path(name).stem if name.lower().endswith(_IMAGE_SUFFIXES) else name
    return f"{stem}.png"


def _place(content: bytes, folder: Path, name: str) -> str:
    """Writes an image unless it is there; returns the name that was free for it."""
    path, number = folder / name, 1
    while path.exists() and content_of(path) != content:
        number += 1
        path = folder / f"{Path(name).stem}_{number}{Path(name).suffix}"
    if not path.exists():
        atomic.write_bytes(path, content)
    return path.name
