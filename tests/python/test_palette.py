# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of sub-meshes, as everybody sees them."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest
from mesh_paths import REPOSITORY
from shapes import bumpy_sphere

from spheroseg.palette import PALETTE, colour_indices, palette
from spheroseg.submeshes import split_into_submeshes

# On linear RGB, after Machado, Oliveira, Fernandes: A Physiologically-based Model for Simulation of
# Color Vision Deficiency, 2009.
SIGHTS = {
    "normal": np.eye(3),
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}


def to_lab(rgb: np.ndarray, sight: np.ndarray) -> np.ndarray:
    """CIELAB (D65) of sRGB colours (n, 3), seen through a matrix on linear RGB."""
    share = rgb / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    linear = (linear @ np.asarray(sight).T).clip(0, 1)
    to_xyz = [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
    t = linear @ np.array(to_xyz).T / [0.95047, 1, 1.08883]
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    x, y, z = f.T
    return np.column_stack((116 * y - 16, 500 * (x - y), 200 * (y - z)))


@pytest.mark.parametrize("sight", SIGHTS)
def test_any_two_colours_are_far_apart_for_every_sight(sight):
    lab = to_lab(palette(len(PALETTE)), SIGHTS[sight])
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(lab, 2)) > 20


def test_colours_are_those_of_the_plugin():
    source = (REPOSITORY / "filter_spheroseg/engine/coloring.cpp").read_text()
    text = re.search(r"kPalette = \{(.*?)\};", source, re.DOTALL)[1]
    found = re.findall(r"\{(\d+), (\d+), (\d+)\}", text)
    assert tuple(tuple(map(int, colour)) for colour in found) == PALETTE


def test_the_palette_suffices_for_connected_submeshes():
    # Each triangle a sub-mesh, and each fan around some vertices one: many with many neighbours.
    vertices, faces = bumpy_sphere(4, 0)
    hubs = np.random.default_rng(0).permutation(len(vertices))[:300]
    labels = np.arange(len(faces))
    for hub in hubs:
        around = np.flatnonzero((faces == hub).any(axis=1))
        if np.array_equal(labels[around], around):
            labels[around] = around[0]
    labels = np.unique(labels, return_inverse=True)[1]
    k = labels.max() + 1
    submeshes = split_into_submeshes(vertices, faces, labels)
    colours = colour_indices(k, submeshes.neighbour_starts, submeshes.neighbours)
    owner = np.repeat(np.arange(k), np.diff(submeshes.neighbour_starts))
    assert np.all(colours[owner] != colours[submeshes.neighbours])
    assert colours.max() < len(PALETTE)
    assert np.bincount(colours).max() < 2 * k / len(PALETTE)
