# SPDX-License-Identifier: GPL-3.0-or-later
"""`fast` on surfaces of every kind: judged by judge.py, never by the plugin's own measures."""

import numpy as np
import pymeshlab
import pytest
from judge import Judge, all_shares, best_difference, share_quality
from surfaces import SURFACES, bone_with_holes, globe, joined, moebius_band, plane, soup, spheres

import spheroseg
from spheroseg.errors import InputError

FILTER = "compute_scalar_by_balanced_segmentation_per_face"


@pytest.fixture(scope="module", params=SURFACES)
def surface(request):
    vertices, faces = SURFACES[request.param].make()
    return vertices, faces, Judge(faces)


def submesh_counts(faces, judge):
    """2, 7, 50 and F / 64, as far as there are so many faces and no more components; or F."""
    components = len(judge.component_sizes())
    wanted = sorted({2, 7, 50, len(faces) // 64})
    return [k for k in wanted if components <= k <= len(faces)] or [len(faces)]


def assert_valid(judge, labels, submesh_count, measures):
    """Whole, balanced as the components allow, connected, no bowtie; and measured truthfully."""
    verdict = judge.judge(labels, submesh_count)
    best = best_difference(judge.component_sizes(), submesh_count)
    assert verdict.max_triangle_count_difference == best
    assert verdict.min_submesh_triangles >= 1
    assert verdict.disconnected_submesh_count == 0
    assert verdict.bowtie_count == 0
    for key, value in vars(verdict).items():
        assert measures[key] == value, key
    assert measures["best_max_triangle_count_difference"] == best
    assert measures["component_count"] == len(judge.component_sizes())
    assert measures["boundary_edge_ratio"] == verdict.boundary_edge_count / judge.edge_count


@pytest.mark.parametrize("effort", ["draft", "standard"])
def test_every_surface_is_cut_into_valid_submeshes(surface, effort):
    vertices, faces, judge = surface
    for submesh_count in submesh_counts(faces, judge):
        result = spheroseg.segment(vertices, faces, submesh_count, effort=effort)
        assert_valid(judge, result.labels, submesh_count, result.measures)


@pytest.mark.parametrize("make", [moebius_band, bone_with_holes])
def test_high_effort_is_valid_and_no_longer(make):
    vertices, faces = make()
    judge = Judge(faces)
    results = {
        effort: spheroseg.segment(vertices, faces, 30, effort=effort)
        for effort in ("draft", "high")
    }
    assert_valid(judge, results["high"].labels, 30, results["high"].measures)
    lengths = {effort: r.measures["boundary_edge_count"] for effort, r in results.items()}
    assert lengths["high"] <= lengths["draft"]


def test_filter_gives_the_same_for_any_thread_count_and_is_valid_for_any_seed(surface):
    vertices, faces, judge = surface
    submesh_count = submesh_counts(faces, judge)[-1]
    reference = spheroseg.segment(vertices, faces, submesh_count, effort="draft", thread_count=1)
    for seed, thread_count in ((0, 2), (0, 5), (1, 2), (2**31 - 1, 2)):
        mesh_set = pymeshlab.MeshSet()
        mesh_set.add_mesh(pymeshlab.Mesh(vertices, faces))
        report = mesh_set.apply_filter(
            FILTER,
            submesh_count=submesh_count,
            effort="draft",
            seed=seed,
            thread_count=thread_count,
        )
        labels = mesh_set.current_mesh().face_scalar_array().astype(int)
        assert_valid(judge, labels, submesh_count, report)
        if seed == 0:
            np.testing.assert_array_equal(labels, reference.labels)


def test_one_submesh_per_face_and_one_in_all(surface):
    vertices, faces, judge = surface
    if len(faces) <= 3000:
        labels = spheroseg.segment(vertices, faces, len(faces), effort="draft").labels
        np.testing.assert_array_equal(np.sort(labels), np.arange(len(faces)))
    component_count = len(judge.component_sizes())
    labels = spheroseg.segment(vertices, faces, component_count, effort="draft").labels
    # Each label is one component.
    pairs = np.unique(np.column_stack((labels, judge.component_of_face)), axis=0)
    assert len(pairs) == component_count


def test_turning_faces_round_keeps_the_result_valid_and_as_short():
    vertices, faces = SURFACES["torus"].make()
    judge = Judge(faces)
    turned = SURFACES["torus turned at random"].make()[1]
    counts = []
    for some_faces in (faces, turned):
        result = spheroseg.segment(vertices, some_faces, 48)
        assert_valid(judge, result.labels, 48, result.measures)
        counts.append(result.measures["boundary_edge_count"])
    assert max(counts) <= 1.05 * min(counts)


def test_coordinates_do_not_matter():
    vertices, faces = bone_with_holes()
    moved = np.random.default_rng(3).normal(size=vertices.shape)
    for other in (moved, 0 * vertices):
        np.testing.assert_array_equal(
            spheroseg.segment(other, faces, 20).labels,
            spheroseg.segment(vertices, faces, 20).labels,
        )


def test_coinciding_vertices_are_not_merged():
    vertices, faces = joined([plane(8, 8), plane(8, 8)])
    result = spheroseg.segment(vertices, faces, 6)
    assert result.measures["component_count"] == 2
    assert_valid(Judge(faces), result.labels, 6, result.measures)


@pytest.mark.parametrize("seed", range(6))
def test_components_share_the_submeshes_as_well_as_any_shares_could(seed):
    generator = np.random.default_rng(seed)
    sizes = [(int(generator.integers(3, 9)), int(generator.integers(2, 8))) for _ in range(4)]
    vertices, faces = joined([globe(*size) for size in sizes])
    judge = Judge(faces)
    face_counts = tuple(judge.component_sizes().tolist())
    for submesh_count in (4, 5, 6, 9, 14, 20):
        labels = spheroseg.segment(vertices, faces, submesh_count, effort="draft").labels
        pairs = np.unique(np.column_stack((judge.component_of_face, labels)), axis=0)
        shares = np.bincount(pairs[:, 0])
        best = min(share_quality(face_counts, s) for s in all_shares(face_counts, submesh_count))
        assert share_quality(face_counts, shares) == best
        counts = np.sort(np.bincount(labels))
        assert (counts**2).sum() == best[2], "components are not parted evenly"


def test_the_worked_example_of_the_manual():
    vertices, faces = joined([globe(30, 21), globe(10, 16), globe(5, 5)])
    judge = Judge(faces)
    assert judge.component_sizes().tolist() == [1200, 300, 40]
    report = spheroseg.segment(vertices, faces, 10)
    pairs = np.unique(np.column_stack((judge.component_of_face, report.labels)), axis=0)
    assert np.bincount(pairs[:, 0]).tolist() == [7, 2, 1]
    assert report.measures["max_triangle_count_difference"] == 132
    assert report.measures["best_max_triangle_count_difference"] == 132
    assert np.bincount(report.labels).max() == 172


def test_a_branch_that_can_not_be_halved_is_measured_truthfully():
    # A triangle with a triangle on each side: halves of two faces can not both be connected.
    faces = np.array([[0, 1, 2], [1, 0, 3], [2, 1, 4], [0, 2, 5]])
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0.0]])
    result = spheroseg.segment(vertices, faces, 2)
    verdict = Judge(faces).judge(result.labels, 2)
    assert verdict.disconnected_submesh_count == 0
    assert verdict.max_triangle_count_difference == 2
    assert result.measures["max_triangle_count_difference"] == 2
    assert result.measures["best_max_triangle_count_difference"] == 0


@pytest.mark.parametrize(
    ("arrays", "submesh_count", "words"),
    [
        (spheres(), 49, ["50 components", "(49)"]),
        (soup(), 100, ["triangle soup", "300 faces", "(100)"]),
        (soup(2), 1, ["triangle soup", "2 faces", "(1)"]),
    ],
)
def test_too_many_components_are_refused_with_both_numbers_and_the_cure(
    arrays, submesh_count, words
):
    with pytest.raises(InputError) as caught:
        spheroseg.segment(*arrays, submesh_count)
    cures = ['"Merge Close Vertices"', '"Remove Isolated pieces (wrt Face Num.)"']
    for word in words + cures:
        assert word in str(caught.value)
