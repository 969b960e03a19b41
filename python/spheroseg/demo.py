# SPDX-License-Identifier: GPL-3.0-or-later
"""The demonstration: segments a mesh that ships with PyMeshLab; `python -m spheroseg.demo DIR`."""

import argparse
import sys
from pathlib import Path

import pymeshlab
from rich.console import Console
from rich.table import Table

import spheroseg
from spheroseg import mesh_files, workers
from spheroseg.render import render_labels, write_png

SUBMESH_COUNT = 200

ROWS = {
    "triangle_count": "triangles",
    "submesh_count": "sub-meshes",
    "min_submesh_triangles": "triangles in the smallest sub-mesh",
    "max_submesh_triangles": "triangles in the largest sub-mesh",
    "boundary_edge_count": "boundary edges",
    "boundary_edge_ratio": "boundary edges over all edges",
    "disconnected_submesh_count": "disconnected sub-meshes",
    "bowtie_count": "bowties",
    "disk_count": "sub-meshes that are disks",
    "total_seconds": "seconds",
}


def main(output: Path) -> None:
    """Writes cow.ply (labels and colours) and cow.png to `output`, and prints the measures."""
    spheroseg.load_plugin()
    output.mkdir(parents=True, exist_ok=True)
    mesh_path, picture_path = output / "cow.ply", output / "cow.png"
    cow = mesh_files.sample_mesh("cow.obj")
    mesh_set = pymeshlab.MeshSet()
    mesh_set.load_new_mesh(str(cow))
    measures = mesh_set.compute_scalar_by_balanced_segmentation_per_face(
        submesh_count=SUBMESH_COUNT
    )
    mesh_files.save_ply(mesh_set, mesh_path, cow)

    mesh = mesh_set.current_mesh()
    image = render_labels(
        mesh.vertex_matrix(),
        mesh.face_matrix(),
        mesh.face_scalar_array().astype(int),
        mesh.face_color_matrix()[:, :3],
    )
    write_png(picture_path, image)

    table = Table("measure", "value", title=f"cow.obj in {SUBMESH_COUNT} sub-meshes")
    table.columns[1].justify = "right"
    for key, text in ROWS.items():
        value = measures[key]
        table.add_row(text, f"{value:.3f}" if isinstance(value, float) else f"{value:,}")
    console = Console()
    console.print(table)
    console.print(f"plugin:  {spheroseg.plugin_path()}", soft_wrap=True)
    console.print(f"mesh:    {mesh_path.resolve()}", soft_wrap=True)
    console.print(f"picture: {picture_path.resolve()}", soft_wrap=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        prog="python -m spheroseg.demo", description="Segments a mesh that ships with PyMeshLab."
    )
    parser.add_argument(
        "folder",
        metavar="DIR",
        nargs="?",
        type=Path,
        default=Path("out/demo"),
        help="of cow.ply and cow.png; default: %(default)s",
    )
    options = parser.parse_args()
    try:
        main(options.folder)
    except (spheroseg.PluginError, OSError) as error:
        sys.exit(f"{parser.prog}: {workers.explained(error)}")
