# SPDX-License-Identifier: GPL-3.0-or-later
"""Segmentation, parametrization and measures of meshes that are given as arrays."""

import math
import numbers
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pymeshlab
from numpy.typing import ArrayLike

from spheroseg._plugin import apply_filter, load_plugin
from spheroseg.arrays import as_face_weights, as_labels, as_mesh
from spheroseg.errors import InputError, counted

SEGMENT_FILTER = "compute_scalar_by_balanced_segmentation_per_face"
PARAMETRIZE_FILTER = "compute_spherical_parametrization_per_vertex"
MEASURE_FILTER = "get_segmentation_measures"
SPHERE_ATTRIBUTE = "sphere_position"

METHODS = ("fast", "all_pairs")
EFFORTS = ("draft", "standard", "high")
DEVICES = ("auto", "cpu", "cuda")
BALANCES = ("triangle_count", "weight")
WEIGHT_ATTRIBUTE = "spheroseg_weight"

# Option of `segment`: int, float, or the words that it may be.
_OPTIONS = {
    "triangles_per_submesh": int,
    "method": METHODS,
    "effort": EFFORTS,
    "device": DEVICES,
    "seed": int,
    "thread_count": int,
    "max_cohesion_iterations": int,
    "max_refinement_iterations": int,
    "time_limit_seconds": float,
    "balance": BALANCES,
    "weight_attribute": str,
}
_INT_LIMIT = 2**31
# Vertices and faces of the smallest closed mesh, for calls that only warm something up.
TETRAHEDRON = (np.eye(4, 3), np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [0, 2, 3]]))


@dataclass(frozen=True, eq=False)
class Segmentation:
    """Result of `segment`; `labels, measures = segment(...)` works as well.

    labels: int32 array of shape (F,), the sub-mesh of each face, in [0, k).
    measures: everything that the filter returns, by name (docs/measures.md).
    """

    labels: np.ndarray
    measures: dict[str, Any]

    def __iter__(self) -> Iterator[Any]:
        yield from (self.labels, self.measures)


@dataclass(frozen=True, eq=False)
class Parametrization:
    """Result of `parametrize`; `positions, measures = parametrize(...)` works as well.

    positions: float64 array of shape (V, 3), unit vectors; (0, 0, 1) for vertices of no face.
    measures: everything that the filter returns, by name (docs/measures.md).
    """

    positions: np.ndarray
    measures: dict[str, Any]

    def __iter__(self) -> Iterator[Any]:
        yield from (self.positions, self.measures)


def segment(
    vertices: ArrayLike,
    faces: ArrayLike,
    submesh_count: int | None = None,
    *,
    face_weights: ArrayLike | None = None,
    initial_labels: ArrayLike | None = None,
    **options: Any,
) -> Segmentation:
    """Cuts a mesh into sub-meshes whose triangle counts differ by at most one.

    vertices: (V, 3) numbers, finite where a face names the vertex. faces: (F, 3) integers in
    [0, V), three different ones each. No edge may have more than two faces; holes, handles and
    several components are fine (their sizes then limit how little the counts can differ). The
    method all_pairs needs one closed, oriented, two-manifold component of genus 0. Vertices that no
    face names are allowed.
    submesh_count: k, from the number of components to F; by default 200, or ceil(F / 10) if
    that is less.
    face_weights: (F,) finite numbers, none negative; with balance="weight", which without them
    takes the areas. initial_labels: (F,) whole numbers in [0, 2^24): repaired, balanced and refined
    instead of a new start; k is then the number of different ones, and no other may be asked for.
    options: triangles_per_submesh (k = ceil(F / value) instead), balance, method, effort, device,
    seed, thread_count, max_cohesion_iterations, max_refinement_iterations, time_limit_seconds;
    names, meanings and defaults are those of the filter.

    The same seed gives the same labels for any thread_count. The mesh is not changed, and faces
    keep their order. Raises InputError when the mesh or an option can not be used.
    """
    vertices, faces = as_mesh(vertices, faces)
    if submesh_count is not None:
        options["submesh_count"] = submesh_count
    parameters = segment_parameters(options)
    if initial_labels is None:
        mesh_set = _mesh_set(vertices, faces)
    else:
        labels = as_labels(initial_labels, len(faces), name="initial_labels")
        check_label_count(labels, parameters)
        mesh_set = labelled_mesh_set(vertices, faces, labels)
        parameters["initial_labels"] = "face_quality"
    if face_weights is not None:
        set_face_weights(mesh_set, face_weights, parameters)
    measures = run_filter(mesh_set, SEGMENT_FILTER, **parameters, colorize=False)
    labels = mesh_set.current_mesh().face_scalar_array().astype(np.int32)
    return Segmentation(labels, measures)


def parametrize(vertices: ArrayLike, faces: ArrayLike) -> Parametrization:
    """Maps a mesh, given as for the method all_pairs, onto the unit sphere; no triangle is flipped.

    Raises InputError when the mesh can not be used.
    """
    mesh_set = _mesh_set(*as_mesh(vertices, faces))
    measures = run_filter(mesh_set, PARAMETRIZE_FILTER)
    return Parametrization(sphere_positions(mesh_set), measures)


def measure(vertices: ArrayLike, faces: ArrayLike, labels: ArrayLike) -> dict[str, Any]:
    """Measures a labelling, whoever made it.

    vertices, faces: as for `segment`, but any surface will do. labels: (F,) whole numbers in
    [0, 2^24). Returns the measures by name. Raises InputError when an array can not be used.
    """
    vertices, faces = as_mesh(vertices, faces)
    return run_filter(
        labelled_mesh_set(vertices, faces, as_labels(labels, len(faces))), MEASURE_FILTER
    )


def labelled_mesh_set(
    vertices: np.ndarray, faces: np.ndarray, labels: np.ndarray
) -> pymeshlab.MeshSet:
    """A MeshSet with one mesh whose face quality holds the labels."""
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces, f_scalar_array=labels.astype(np.float64)))
    return mesh_set


def set_face_weights(
    mesh_set: pymeshlab.MeshSet, face_weights: ArrayLike, parameters: dict[str, Any]
) -> None:
    """Gives the current mesh the weights, and the filter's parameters the name of them."""
    if parameters.get("balance") != "weight":
        raise InputError("face weights need balance='weight'; without it triangles are counted")
    if "weight_attribute" in parameters:
        raise InputError("give either weights for the faces or weight_attribute, not both")
    mesh = mesh_set.current_mesh()
    weights = as_face_weights(face_weights, mesh.face_number())
    mesh.add_face_custom_scalar_attribute(weights, WEIGHT_ATTRIBUTE)
    parameters["weight_attribute"] = WEIGHT_ATTRIBUTE


def check_label_count(labels: np.ndarray, parameters: dict[str, Any]) -> None:
    """Raises InputError where `parameters` ask for another k than initial labels have."""
    label_count = len(np.unique(labels))
    wanted = {"submesh_count": parameters.get("submesh_count")}
    size = parameters.get("triangles_per_submesh", 0)
    if size > 0:
        wanted["triangles_per_submesh"] = -(-len(labels) // size)
    for name, count in wanted.items():
        if count not in (None, label_count):
            raise InputError(
                f"{name}={parameters[name]} asks for {counted(count, 'sub-mesh', 'es')}, but k is "
                f"the number of different initial labels, {label_count}; leave {name} out"
            )


def sphere_positions(mesh_set: pymeshlab.MeshSet) -> np.ndarray:
    """The `sphere_position` attribute of the current mesh: (V, 3) unit vectors."""
    return mesh_set.current_mesh().vertex_custom_point_attribute_matrix(SPHERE_ATTRIBUTE)


def run_filter(mesh_set: pymeshlab.MeshSet, name: str, **parameters: Any) -> dict[str, Any]:
    """Applies a filter of the plugin to the current mesh and returns its measures by name.

    Raises PluginError when the plugin is not there or this is a forked process in which it would
    hang, InputError when the filter refuses, KeyboardInterrupt when a Ctrl-C has cancelled it.
    """
    load_plugin()
    try:
        measures = apply_filter(mesh_set, name, parameters)
    except pymeshlab.PyMeshLabException as error:
        raise InputError(_filter_message(str(error))) from None
    return {
        key: np.asarray(value).ravel() if isinstance(value, np.ndarray) else value
        for key, value in sorted(measures.items())
    }


def plain(measures: dict[str, Any]) -> dict[str, Any]:
    """The measures with arrays as lists, for JSON."""
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in measures.items()
    }


def shortcomings(measures: dict[str, Any], balance: str = "triangle_count") -> str:
    """What the result of a segmentation has that `fast` avoids, as the filter's log says it; empty
    for none."""
    difference = measures["max_triangle_count_difference"]
    best = measures["best_max_triangle_count_difference"]
    found = []
    if balance == "triangle_count" and difference > 1:
        text = f"{difference} triangles between the largest and the smallest sub-mesh"
        only = ", the fewest that its components allow"
        found.append(text if difference > best else text + only)
        if not measures.get("may_be_balanced", True):
            found[-1] += (
                " (no cut into so many connected ones is balanced, as parts of the mesh hang on "
                "the rest by single edges)"
            )
    if measures["disconnected_submesh_count"] > 0:
        pieces = counted(measures["disconnected_submesh_count"], "sub-mesh", "es")
        found.append(f"{pieces} in more than one piece")
    if measures["bowtie_count"] > 0:
        found.append(counted(measures["bowtie_count"], "bowtie", "s"))
    return ", ".join(found)


def can_be_balanced(measures: dict[str, Any]) -> bool:
    """False where no cut of the mesh into so many connected sub-meshes has triangle counts that
    differ by at most one, as far as its segmentation has found out."""
    return measures["best_max_triangle_count_difference"] <= 1 and measures.get(
        "may_be_balanced", True
    )


def forget_prepared_mesh() -> None:
    """Makes the next call one on a mesh that the plugin has not seen, for a fair stop watch.

    The plugin keeps what it prepared for the last mesh; here that becomes a tetrahedron.
    """
    run_filter(_mesh_set(*TETRAHEDRON), SEGMENT_FILTER, submesh_count=2, colorize=False)


def segment_parameters(options: dict[str, Any]) -> dict[str, Any]:
    """Checks names and types of options; ranges are the filter's to check."""
    parameters = {}
    for name, value in options.items():
        kind = int if name == "submesh_count" else _OPTIONS.get(name)
        if kind is None:
            known = ["submesh_count", "face_weights", "initial_labels", *_OPTIONS]
            known.remove("weight_attribute")  # arrays have none
            raise InputError(f"segment has no option {name!r}; it has {', '.join(known)}")
        parameters[name] = _checked_option(name, value, kind)
    if parameters.get("weight_attribute") and parameters.get("balance") != "weight":
        raise InputError(
            f"weight_attribute={options['weight_attribute']!r} needs balance='weight'; without it "
            "triangles are counted"
        )
    return parameters


def _checked_option(name: str, value: Any, kind: type | tuple[str, ...]) -> Any:
    if isinstance(kind, tuple):
        if not isinstance(value, str) or value not in kind:
            raise InputError(f"{name} must be one of {', '.join(kind)}, got {value!r}")
        return value
    if kind is str:
        if not isinstance(value, str):
            raise InputError(f"{name} must be a string, got {value!r}")
        return value
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        raise InputError(f"{name} must be a number, got {value!r}")
    if kind is float:
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise InputError(f"{name} must be finite, got {value!r}")
        return number
    if not isinstance(value, numbers.Integral):
        raise InputError(f"{name} must be a whole number, got {value!r}")
    if not -_INT_LIMIT <= value < _INT_LIMIT:
        raise InputError(f"{name} must fit into 32 bits, got {value!r}")
    return int(value)


def _mesh_set(vertices: np.ndarray, faces: np.ndarray) -> pymeshlab.MeshSet:
    mesh_set = pymeshlab.MeshSet()
    mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces))
    return mesh_set


def _filter_message(message: str) -> str:
    """What the filter said, without the frame that PyMeshLab puts around it."""
    framed = re.match(r"Failed to apply filter:\s*'?\w+\.?\s*(?:Details:)?(.*)", message, re.DOTALL)
    return (framed[1] if framed else message).strip()
