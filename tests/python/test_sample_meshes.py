# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample meshes are what generate.py makes, and closed surfaces of genus 0."""

import subprocess
import sys

import numpy as np
import pytest
import recount
from mesh_paths import SAMPLE_FOLDER, SAMPLES


@pytest.fixture(scope="module")
def generated_folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("generated")
    subprocess.run([sys.executable, SAMPLE_FOLDER / "generate.py", folder], check=True)
    return folder


def test_the_generator_makes_exactly_these_files(generated_folder):
    assert sorted(path.name for path in generated_folder.iterdir()) == [
        path.name for path in SAMPLES
    ]


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
def test_the_generator_makes_the_same_bytes(path, generated_folder):
    assert (generated_folder / path.name).read_bytes() == path.read_bytes()


def test_there_are_six_or_more_and_they_stay_small():
    assert len(SAMPLES) >= 6
    assert sum(path.stat().st_size for path in SAMPLES) < 1_000_000


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
def test_each_is_one_closed_oriented_manifold_of_genus_zero(path, sample_arrays):
    assert recount.surface_faults(*sample_arrays[path.name]) == []


def test_they_hold_the_hard_cases_that_they_are_named_for(sample_arrays):
    assert len(sample_arrays["cube.obj"][1]) == 12
    assert np.bincount(sample_arrays["spindle.ply"][1].ravel()).max() == 500
    extent = np.ptp(sample_arrays["flat_leaf.ply"][0], axis=0)
    assert extent.max() > 100 * extent.min()
    assert median_aspect(*sample_arrays["sliver_rod.ply"]) > 50
    assert median_aspect(*sample_arrays["displaced_sphere.ply"]) < 2


def median_aspect(vertices, faces):
    """Longest edge over the height above it; 1.15 for an equilateral triangle."""
    corners = vertices[faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    doubled_area = np.linalg.norm(recount.area_vectors(vertices, faces), axis=1)
    return np.median(longest**2 / doubled_area)
