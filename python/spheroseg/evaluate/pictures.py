# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of segmentations, drawn off-screen by PyVista: boundaries dark, bowties red."""

from pathlib import Path

import numpy as np

from spheroseg import atomic
from spheroseg.evaluate.topology import Anatomy

SIZE = (520, 440)
_BOUNDARY = "#222222"
_BOWTIE = "#e00000"


def draw(
    vertices: np.ndarray, faces: np.ndarray, face_colours: np.ndarray, parts: Anatomy, path: Path
) -> None:
    """Writes a PNG of the mesh, which lies around the origin, with `face_colours` (F, 3) uint8."""
    import pyvista

    # VTK tries a window system first and complains when there is none, which is no fault here.
    pyvista.vtk_verbosity("off")
    surface = pyvista.PolyData.from_regular_faces(vertices, faces)
    surface.cell_data["colour"] = face_colours
    plotter = pyvista.Plotter(off_screen=True, window_size=SIZE)
    try:
        plotter.set_background("white")
        plotter.add_mesh(surface, scalars="colour", rgb=True, ambient=0.25, diffuse=0.8)
        if len(parts.boundary_edges):
            plotter.add_mesh(
                pyvista.PolyData(vertices, lines=_segments(parts.boundary_edges)),
                color=_BOUNDARY,
                line_width=2,
                lighting=False,
            )
            plotter.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        if len(parts.bowtie_vertices):
            points = vertices[np.unique(parts.bowtie_vertices)]
            plotter.add_points(points, color=_BOWTIE, point_size=11, render_points_as_spheres=True)
        _place(plotter.camera, vertices)
        plotter.reset_camera_clipping_range()
        with atomic.atomic_path(path, ".png") as temporary:
            plotter.screenshot(str(temporary))
    finally:
        plotter.close()


def _place(camera, points: np.ndarray) -> None:
    """Looks at the origin from the side on which the shape is thinnest, a little from above and
    from the right, with all `points` just in view; y is up, as in most mesh files, unless the shape
    is seen along y."""
    thinnest = int(np.argmin(np.ptp(points, axis=0)))
    backward = np.full(3, 0.35)
    backward[thinnest] = 1.0
    backward /= np.linalg.norm(backward)
    up = np.eye(3)[2 if thinnest == 1 else 1]
    right = np.cross(up, backward)
    right /= np.linalg.norm(right)
    distance = 4 * np.linalg.norm(points, axis=1).max() or 1.0  # all in one point
    camera.focal_point = (0.0, 0.0, 0.0)
    camera.position = distance * backward
    camera.up = up

    depths = distance - points @ backward
    aside = np.abs(points @ right) / depths * SIZE[1] / SIZE[0]
    above = np.abs(points @ np.cross(backward, right)) / depths
    camera.view_angle = 2 * np.degrees(np.arctan(1.04 * max(aside.max(), above.max())))


def _segments(edges: np.ndarray) -> np.ndarray:
    return np.column_stack((np.full(len(edges), 2), edges)).ravel()
