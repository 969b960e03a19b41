# SPDX-License-Identifier: GPL-3.0-or-later
"""GPU-ready files of a labelled mesh: `.npz` arrays per sub-mesh and `.glb` for any viewer."""

from __future__ import annotations

import io
from pathlib import Path
from types import ModuleType

import numpy as np

from spheroseg import atomic
from spheroseg.errors import InputError
from spheroseg.packages import require
from spheroseg.palette import colour_indices, palette
from spheroseg.submeshes import SubMeshes

FORMATS = (".npz", ".glb")


def export(submeshes: SubMeshes, path: Path, face_colours: np.ndarray | None = None) -> None:
    """Writes `path` atomically in the format that its suffix names, `.npz` or `.glb`, the latter
    with the colours of `glb_bytes`. Raises InputError where a coordinate is too large for it."""
    path = Path(path)
    if path.suffix.lower() == ".npz":
        atomic.write_bytes(path, npz_bytes(submeshes))
    elif path.suffix.lower() == ".glb":
        atomic.write_bytes(path, glb_bytes(submeshes, face_colours))
    else:
        raise InputError(f"'{path}' must end in one of {', '.join(FORMATS)}")


def gltf_library() -> ModuleType:
    """What writes `.glb` files. Raises MissingPackageError."""
    return require("pygltflib", "a '.glb' file")


def npz_bytes(submeshes: SubMeshes) -> bytes:
    """The arrays of `SubMeshes` under their own names, for `numpy.load`."""
    _check_positions(submeshes)
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **submeshes.arrays())
    return buffer.getvalue()


def glb_bytes(submeshes: SubMeshes, face_colours: np.ndarray | None = None) -> bytes:
    """A binary glTF 2.0 file: one mesh with one primitive per sub-mesh, in its colour.

    `face_colours`, (F, 3) uint8, are kept where each sub-mesh has one colour and no neighbour has
    the same, as the filter paints them; else a palette's colours are taken.
    Primitive i is sub-mesh i; its `extras` name the sub-mesh and its triangle count. An empty
    sub-mesh has no primitive, as glTF allows no empty accessor. Corners that share a vertex share
    its normal within a sub-mesh only. The node translates a mesh that has an `origin`.
    """
    _check_positions(submeshes)
    gltf = gltf_library()
    first_vertices = np.repeat(submeshes.vertex_starts[:-1], np.diff(submeshes.triangle_starts))
    normals = vertex_normals(
        submeshes.positions, submeshes.triangles.astype(np.int64) + first_vertices[:, None]
    )
    arrays = _Arrays(gltf)
    positions_of = arrays.add_vectors(submeshes.positions, submeshes.vertex_starts)
    normals_of = arrays.add_vectors(normals, submeshes.vertex_starts)
    corners_of = arrays.add_indices(submeshes.triangles, submeshes.triangle_starts)
    colours, materials = np.unique(
        _submesh_colours(submeshes, face_colours), axis=0, return_inverse=True
    )
    primitives = [
        gltf.Primitive(
            attributes=gltf.Attributes(POSITION=positions_of[submesh], NORMAL=normals_of[submesh]),
            indices=corners_of[submesh],
            material=int(materials.flat[submesh]),
            mode=gltf.TRIANGLES,
            extras={"submesh": submesh, "triangle_count": triangle_count},
        )
        for submesh, triangle_count in enumerate(np.diff(submeshes.triangle_starts).tolist())
        if triangle_count > 0
    ]
    document = gltf.GLTF2(
        asset=gltf.Asset(version="2.0", generator="SpheroSeg"),
        scene=0,
        scenes=[gltf.Scene(nodes=[0])],
        nodes=[gltf.Node(mesh=0, name="segmentation", translation=_translation(submeshes))],
        meshes=[gltf.Mesh(primitives=primitives, name="segmentation")],
        materials=_materials(gltf, colours),
        accessors=arrays.accessors,
        bufferViews=arrays.views,
        buffers=[gltf.Buffer(byteLength=len(arrays.data))],
    )
    document.set_binary_blob(bytes(arrays.data))
    return b"".join(document.save_to_bytes())


def _check_positions(submeshes: SubMeshes) -> None:
    is_beyond = ~np.isfinite(submeshes.positions).all(axis=1)
    if is_beyond.any():
        raise InputError(
            f"vertex {submeshes.source_vertices[is_beyond.argmax()]} has a coordinate beyond "
            f"{np.finfo(np.float32).max:.3g}, too large for single precision; scale the mesh down"
        )


def _translation(submeshes: SubMeshes) -> list[float] | None:
    return submeshes.origin.tolist() if submeshes.origin.any() else None


def vertex_normals(positions: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals weighted by area; (0, 0, 1) where the triangles around a vertex cancel out."""
    corners = positions.astype(np.float64)[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros((len(positions), 3))
    np.add.at(normals, triangles.reshape(-1), np.repeat(cross, 3, axis=0))
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0)
    normals[lengths[:, 0] == 0] = (0, 0, 1)
    return normals.astype(np.float32)


def _submesh_colours(submeshes: SubMeshes, face_colours: np.ndarray | None) -> np.ndarray:
    """(k, 3) uint8, different for neighbours."""
    if face_colours is not None:
        in_blocks = face_colours[submeshes.source_triangles]
        # An empty sub-mesh, which is not drawn, may have any.
        colours = in_blocks[np.minimum(submeshes.triangle_starts[:-1], len(in_blocks) - 1)]
        here = np.repeat(colours, np.diff(submeshes.neighbour_starts), axis=0)
        differ = (here != colours[submeshes.neighbours]).any(axis=1).all()
        painted = np.repeat(colours, np.diff(submeshes.triangle_starts), axis=0)
        if differ and np.array_equal(painted, in_blocks):
            return colours
    indices = colour_indices(submeshes.count, submeshes.neighbour_starts, submeshes.neighbours)
    return palette(int(indices.max()) + 1)[indices]


def _materials(gltf, colours: np.ndarray) -> list:
    # By the transfer function of sRGB (IEC 61966-2-1).
    share = colours / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return [
        gltf.Material(
            name=f"colour {index}",
            doubleSided=True,  # open surfaces are seen from both sides
            pbrMetallicRoughness=gltf.PbrMetallicRoughness(
                baseColorFactor=[*map(float, colour), 1.0], metallicFactor=0.0, roughnessFactor=0.8
            ),
        )
        for index, colour in enumerate(linear)
    ]


class _Arrays:
    """The file's binary part: one buffer view per array, with an accessor for each block."""

    def __init__(self, gltf):
        self.gltf = gltf
        self.data = bytearray()
        self.views = []
        self.accessors = []

    def add_vectors(self, vectors: np.ndarray, starts: np.ndarray) -> dict[int, int]:
        """The accessor of each block that is not empty."""
        numbers = self._add(
            vectors.astype("<f4"),
            starts,
            self.gltf.BufferView(target=self.gltf.ARRAY_BUFFER, byteStride=12),
            componentType=self.gltf.FLOAT,
            type=self.gltf.VEC3,
        )
        first = starts[list(numbers)]
        low, high = np.minimum.reduceat(vectors, first), np.maximum.reduceat(vectors, first)
        for number, least, most in zip(numbers.values(), low.tolist(), high.tolist(), strict=True):
            self.accessors[number].min, self.accessors[number].max = least, most
        return numbers

    def add_indices(self, triangles: np.ndarray, starts: np.ndarray) -> dict[int, int]:
        """The same for the corners of triangles."""
        short = triangles.dtype == np.uint16
        return self._add(
            triangles.astype("<u2" if short else "<u4").reshape(-1),
            3 * starts,
            self.gltf.BufferView(target=self.gltf.ELEMENT_ARRAY_BUFFER),
            componentType=self.gltf.UNSIGNED_SHORT if short else self.gltf.UNSIGNED_INT,
            type=self.gltf.SCALAR,
        )

    def _add(self, array: np.ndarray, starts: np.ndarray, view, **form) -> dict[int, int]:
        view.buffer, view.byteOffset, view.byteLength = 0, len(self.data), array.nbytes
        self.data += array.tobytes()
        # pygltflib 1.16 pads the views that it writes, too.
        self.data += bytes(-len(self.data) % 4)
        width = array.nbytes // len(array)
        numbers = {}
        for block in np.flatnonzero(np.diff(starts)).tolist():
            first, end = map(int, starts[block : block + 2])
            numbers[block] = len(self.accessors)
            self.accessors.append(
                self.gltf.Accessor(
                    bufferView=len(self.views),
                    byteOffset=width * first,
                    count=end - first,
                    **form,
                )
            )
        self.views.append(view)
        return numbers
