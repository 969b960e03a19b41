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
    """Writes a PNG of the mesh with `face_colours` (F, 3) uint8."""
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
        direction, up = _view(vertices)
        plotter.view_vector(direction, viewup=up)
        plotter.camera.zoom(1.15)
        with atomic.atomic_path(path, ".png") as temporary:
            plotter.screenshot(str(temporary))
    finally:
        plotter.close()


def _view(vertices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """From the side on which the shape is thinnest, a little from above and from the right; y is
    up, as in most mesh files, unless the shape is seen along y."""
    thinnest = int(np.argmin(np.ptp(vertices, axis=0)))
    direction = np.full(3, 0.35)
    direction[thinnest] = 1.0
    up = np.zeros(3)
    up[2 if thinnest == 1 else 1] = 1.0
    return direction, up


def _segments(edges: np.ndarray) -> np.ndarray:
    return np.column_stack((np.full(len(edges), 2), edges)).ravel()
