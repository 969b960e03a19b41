# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures drawn without a display."""

import numpy as np
from surfaces import plane

from spheroseg.render import render_labels


def test_an_open_surface_is_seen_from_both_sides():
    vertices, faces = plane(6, 4)
    labels = np.arange(len(faces)) // 16
    colours = np.full((len(faces), 3), 0.5)
    shown = [
        render_labels(vertices, faces, labels, colours, size=(60, 40), view=(0, 0, side))
        for side in (1.0, -1.0)
    ]
    for image in shown:
        painted = (image < 255).any(axis=2)
        assert painted.mean() > 0.8
        # Dark lines between the three sub-meshes.
        assert (image[painted] < 100).any()


def test_a_face_without_area_is_not_drawn():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0.0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    labels = np.array([0, 1])
    image = render_labels(vertices, faces, labels, np.eye(3)[[0, 1]], size=(40, 20), view=(0, 0, 1))
    red = (image[..., 0] > image[..., 1]) & (image < 255).any(axis=2)
    assert not red.any()
    assert (image[..., 1] > image[..., 0]).any()
