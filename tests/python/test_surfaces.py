# SPDX-License-Identifier: GPL-3.0-or-later
"""The surfaces of surfaces.py are what they claim to be, and the judge judges rightly."""

from collections import Counter

import numpy as np
import pytest
import recount
from judge import Judge, all_shares, best_difference, pieces, share_quality
from surfaces import SURFACES, globe, pinched_ring, pinched_spheres, plane

import spheroseg


@pytest.fixture(scope="module", params=SURFACES)
def surface(request):
    return SURFACES[request.param], *SURFACES[request.param].make()


def test_topology_is_the_one_named(surface):
    claim, vertices, faces = surface
    assert np.isfinite(vertices).all()
    assert faces.min() >= 0
    assert faces.max() < len(vertices)
    assert (faces[:, 0] != faces[:, 1]).all()
    assert (faces[:, 1] != faces[:, 2]).all()
    assert (faces[:, 2] != faces[:, 0]).all()
    judge = Judge(faces)
    edges = recount.edge_faces(faces)
    assert max(map(len, edges.values())) <= 2
    used = np.unique(faces)
    assert len(used) - len(edges) + len(faces) == claim.euler
    assert judge.component_of_face.max() + 1 == claim.components
    assert judge.fan_of_corner.max() + 1 - len(used) == claim.pinches
    border = [edge for edge, users in edges.items() if len(users) == 1]
    assert all(count % 2 == 0 for count in Counter(v for e in border for v in e).values())
    assert border_loop_count(judge) == claim.border_loops
    assert is_orientable(faces, judge) == claim.orientable
    directed = Counter(edge for a, b, c in faces.tolist() for edge in ((a, b), (b, c), (c, a)))
    assert (max(directed.values()) == 1) == claim.oriented


def border_loop_count(judge):
    """Pieces of border where border edges follow each other around one fan."""
    opposite = np.ones(3 * judge.face_count, dtype=bool)
    opposite[np.concatenate(judge.sides)] = False
    sides = np.flatnonzero(opposite)
    ahead = sides - sides % 3 + (sides + 1) % 3
    fan_count = judge.fan_of_corner.max() + 1
    nodes = len(sides) + fan_count
    own = np.arange(len(sides))
    links = np.concatenate(
        [
            np.column_stack((own, len(sides) + judge.fan_of_corner[corner]))
            for corner in (sides, ahead)
        ]
    )
    return len(np.unique(pieces(nodes, links)[: len(sides)])) if len(sides) else 0


def is_orientable(faces, judge):
    """No face is joined to its own back: two copies of each face, for its two sides."""
    one, other = judge.sides
    same_way = faces.ravel()[one] == faces.ravel()[other]
    a, b = judge.pairs.T
    back = np.where(same_way, judge.face_count, 0)
    links = np.concatenate(
        (
            np.column_stack((a, b + back)),
            np.column_stack((a + judge.face_count, b + judge.face_count - back)),
        )
    )
    side = pieces(2 * judge.face_count, links)
    return not (side[: judge.face_count] == side[judge.face_count :]).any()


def test_judge_agrees_with_the_plain_recount(surface):
    _, _, faces = surface
    faces = faces[:2500]
    generator = np.random.default_rng(4)
    judge = Judge(faces)
    for submesh_count in (2, 9):
        labels = np.concatenate(
            (np.arange(submesh_count), generator.integers(submesh_count, size=len(faces)))
        )[: len(faces)]
        expected = recount.measures(faces, labels)
        verdict = judge.judge(labels, submesh_count)
        for key, value in vars(verdict).items():
            assert value == expected[key], key


def test_a_pinch_of_the_input_is_no_bowtie():
    for _, faces in (pinched_spheres(2), pinched_ring()):
        assert Judge(faces).judge(np.zeros(len(faces), int), 1).bowtie_count == 0
    # Four faces around a vertex of valence 4, labelled crosswise: two bowties, one per sub-mesh.
    _, faces = globe(4, 2)
    assert Judge(faces).judge(np.array([0, 1, 0, 1, 2, 2, 2, 2]), 3).bowtie_count == 2


def test_a_strip_of_the_input_that_touches_itself_is_a_disk():
    corners = np.array([0, 1, 2, 3, 4, 5, 6, 0])  # the ends have this vertex in common, no edge
    faces = np.column_stack((corners[:-2], corners[1:-1], corners[2:]))
    labels = np.zeros(len(faces), int)
    vertices = np.random.default_rng(0).normal(size=(7, 3))
    for found in (recount.measures(faces, labels), spheroseg.measure(vertices, faces, labels)):
        assert (found["bowtie_count"], found["disk_count"]) == (0, 1)


def test_two_bowties_in_a_plane():
    # Squares of one label that touch in a corner only: one bowtie for each of the two labels.
    _, faces = plane(2, 2)
    squares = np.array([0, 1, 1, 0])
    verdict = Judge(faces).judge(np.repeat(squares, 2), 2)
    assert verdict.disconnected_submesh_count == 2
    assert verdict.bowtie_count == 2
    assert verdict.boundary_edge_count == 4


def test_best_difference_is_that_of_all_shares():
    generator = np.random.default_rng(5)
    for _ in range(300):
        sizes = tuple(int(n) for n in generator.integers(1, 25, size=generator.integers(1, 5)))
        submesh_count = int(generator.integers(len(sizes), min(sum(sizes), 20) + 1))
        brute = min(share_quality(sizes, s)[0] for s in all_shares(sizes, submesh_count))
        assert best_difference(np.array(sizes), submesh_count) == brute, (sizes, submesh_count)


def test_shares_of_two_components_by_hand():
    shares = list(all_shares((4, 9), 4))
    assert sorted(shares) == [(1, 3), (2, 2), (3, 1)]
    assert [share_quality((4, 9), s) for s in sorted(shares)] == [
        (1, 4, 4**2 + 3 * 3**2),
        (3, 5, 2 * 2**2 + 4**2 + 5**2),
        (8, 9, 1 + 1 + 2**2 + 9**2),
    ]
