# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: one HTML file with all tables, pictures, plots and the 3D view inside."""

import base64
import gzip
import json
from pathlib import Path
from typing import Any

import numpy as np

from spheroseg import atomic
from spheroseg.arrays import as_single_precision
from spheroseg.dual_graph import build_dual_graph
from spheroseg.evaluate import paper, pictures, plots
from spheroseg.evaluate.folder import PAGE, arrays_file, stem
from spheroseg.evaluate.methods import METHODS
from spheroseg.evaluate.summary import in_order, sentences, summary, with_boundary
from spheroseg.evaluate.topology import TRIANGLE_BYTES, VERTEX_BYTES, Anatomy, anatomy
from spheroseg.palette import colour_indices, palette
from spheroseg.submeshes import split_into_submeshes

PAGE_FOLDER = Path(__file__).parent / "page"


def write_report(
    folder: Path,
    rows: list[dict],
    failed_meshes: list[dict],
    environment: dict[str, str],
    viewer_limit: int,
) -> Path:
    """Writes `report.html`, `pictures/*.png` and `plots/*.svg` below `folder`, whose `labels`
    hold the arrays that the rows name; returns the page's path."""
    import jinja2

    loader = jinja2.FileSystemLoader(PAGE_FOLDER)
    page = jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined
    ).get_template("report.html.j2")
    done = [row for row in rows if row["status"] == "done"]
    scenes = _scenes(folder, done, viewer_limit)
    path = folder / PAGE
    text = page.render(
        style=(PAGE_FOLDER / "style.css").read_text(),
        script=(PAGE_FOLDER / "viewer.js").read_text(),
        mesh_count=len({row["mesh"] for row in rows}),
        methods=[METHODS[name] for name in in_order(rows)],
        submesh_counts=sorted({row["submesh_count"] for row in rows}),
        summary=sentences(summary(done)),
        rows=_table_rows([row for row in rows if row["status"] != "left out"]),
        left_out=_left_out(rows),
        left_out_count=sum(row["status"] == "left out" for row in rows),
        failed_meshes=failed_meshes,
        environment=environment,
        vertex_bytes=VERTEX_BYTES,
        triangle_bytes=TRIANGLE_BYTES,
        **_plots(folder, done),
        **scenes,
    )
    atomic.write_text(path, text)
    return path


def _table_rows(rows: list[dict]) -> list[dict]:
    shown = []
    before = None
    for row in rows:
        group = row["mesh"], row["submesh_count"]
        shown.append(
            row
            | {
                "title": METHODS[row["method"]].title,
                "is_ours": METHODS[row["method"]].is_ours,
                "is_first": group != before,
                "paper": paper.lookup(
                    row["mesh_file"], row["triangle_count"], row["submesh_count"], row["method"]
                ),
            }
        )
        before = group
    return shown


def _left_out(rows: list[dict]) -> list[dict]:
    """What was left out of each mesh for one reason: values of k and methods, each once."""
    cases: dict[tuple[str, str], dict] = {}
    for row in rows:
        if row["status"] == "left out":
            new = {"mesh": row["mesh"], "reason": row["error"], "counts": {}, "titles": {}}
            case = cases.setdefault((row["mesh"], row["error"]), new)
            case["counts"][row["submesh_count"]] = None
            case["titles"][METHODS[row["method"]].title] = None
    return list(cases.values())


_EFFORTS_BY_USE = ("fast_standard", "fast_high", "fast_draft")


def _plots(folder: Path, done: list[dict]) -> dict[str, Any]:
    """Writes the diagrams and returns those of the page, each kind at the largest k that it has;
    empty where there is nothing to show."""
    titles = {name: METHODS[name].title for name in in_order(done)}
    files: dict[str, str] = {}
    by_k: dict[int, list[str]] = {}
    # One effort of fast is enough on the page: at most two diagrams per mesh.
    efforts = [name for name in _EFFORTS_BY_USE if name in titles][:1]
    for row in done:
        title = f"{row['mesh']}, k = {row['submesh_count']}: {titles[row['method']]}"
        svg = plots.iterations(row, title)
        if svg:
            files[f"iterations/{_stem(row)}"] = svg
            if row["method"] in ["all_pairs", *efforts]:
                by_k.setdefault(row["submesh_count"], []).append(svg)
    iteration_k = max(by_k, default=0)
    memory_k = max((row["submesh_count"] for row in done), default=0)
    if done:
        same_k = [row for row in done if row["submesh_count"] == memory_k]
        files["shared-memory"] = plots.shared_memory(same_k, titles)
    cut = with_boundary(done)
    if cut:
        titles = {name: titles[name] for name in in_order(cut)}
        files["quality-and-time"] = plots.quality_and_time(cut, titles)
    for name, svg in files.items():
        atomic.write_text(_made(folder / "plots" / f"{name}.svg"), svg)
    return {
        "iteration_k": iteration_k,
        "iteration_plots": by_k.get(iteration_k, []),
        "memory_k": memory_k,
        "memory_plot": files.get("shared-memory", ""),
        "quality_plot": files.get("quality-and-time", ""),
    }


def _scenes(folder: Path, done: list[dict], viewer_limit: int) -> dict[str, Any]:
    """Pictures, and the arrays of the 3D view for meshes up to the limit."""
    galleries, index, blocks, too_large = [], [], [], []
    for number, name in enumerate(dict.fromkeys(row["mesh"] for row in done)):
        with np.load(folder / arrays_file(name)) as arrays:
            vertices, faces = arrays["vertices"], arrays["faces"]
        vertices = _for_drawing(vertices, faces)
        graph = build_dual_graph(faces)
        labellings = []
        in_viewer = len(faces) <= viewer_limit
        for row in [row for row in done if row["mesh"] == name]:
            k = row["submesh_count"]
            labels = np.load(folder / "labels" / row["labels"])
            parts = anatomy(faces, graph, labels, k)
            colours = _label_colours(vertices, faces, labels, k)
            picture = _made(folder / "pictures" / f"{_stem(row)}.png")
            pictures.draw(vertices, faces, colours[labels], parts, picture)
            title = f"{METHODS[row['method']].title}, k = {k}"
            if not galleries or galleries[-1]["key"] != (name, k):
                group = {"key": (name, k), "title": f"{name}, k = {k}", "pictures": []}
                galleries.append(group)
            galleries[-1]["pictures"].append(
                {
                    "data": base64.b64encode(picture.read_bytes()).decode(),
                    "caption": _caption(row),
                }
            )
            if in_viewer:
                labellings.append({"title": title} | _labelling(labels, colours, parts))
        if in_viewer:
            positions, corners = f"positions-{number}", f"corners-{number}"
            blocks.append({"id": positions, "data": _packed(as_single_precision(vertices), "<f4")})
            blocks.append({"id": corners, "data": _packed(faces, "<u4")})
            title = f"{name} ({len(faces):,} triangles)"
            entry = {"title": title, "positions": positions, "corners": corners}
            index.append(entry | {"labellings": labellings})
        else:
            too_large.append(name)
    return {
        "galleries": galleries,
        # A "<" must not end the script element that holds the text.
        "viewer_index": json.dumps(index).replace("<", "\\u003c"),
        "blocks": blocks,
        "not_in_viewer": too_large,
    }


def _for_drawing(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The same shape with a bounding box from -1 to 1 along its longest side: single precision
    might not hold it in its place and size. Vertices that no face names, which may be anywhere, at
    the origin."""
    used = np.unique(faces)
    placed = np.zeros_like(vertices)
    # Half of each: the difference of two of them must not overflow.
    halves = vertices[used] / 2
    halves -= halves.min(axis=0) / 2 + halves.max(axis=0) / 2
    placed[used] = halves / (np.abs(halves).max() or 1)
    return placed


def _caption(row: dict) -> str:
    caption = f"{METHODS[row['method']].title}: {row['boundary_edge_count']:,} boundary edges"
    bowties = row["bowtie_count"]
    return caption + (f", {bowties} bowtie{'s' if bowties > 1 else ''} (red)" if bowties else "")


def _labelling(labels: np.ndarray, colours: np.ndarray, parts: Anatomy) -> dict[str, Any]:
    return {
        "labels": _packed(labels, "<u4"),
        "palette": _packed(colours, "u1"),
        "lines": _packed(parts.boundary_edges, "<u4"),
        "bowties": _packed(parts.bowtie_vertices, "<u4"),
        "counts": {
            "triangles": parts.triangle_counts.tolist(),
            "vertices": parts.vertex_counts.tolist(),
            "edges": parts.edge_counts.tolist(),
            "bowties": parts.bowtie_counts.tolist(),
        },
    }


def _label_colours(vertices, faces, labels, k: int) -> np.ndarray:
    submeshes = split_into_submeshes(vertices, faces, labels, k)
    indices = colour_indices(k, submeshes.neighbour_starts, submeshes.neighbours)
    return palette(int(indices.max()) + 1)[indices]


def _packed(array: np.ndarray, code: str) -> str:
    raw = np.ascontiguousarray(array, dtype=code).tobytes()
    return base64.b64encode(gzip.compress(raw, mtime=0)).decode()


def _stem(row: dict) -> str:
    return stem(row["mesh"], row["submesh_count"], row["method"])


def _made(path: Path) -> Path:
    """The path, after making its folder: a mesh's name may have folders in it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    return path
