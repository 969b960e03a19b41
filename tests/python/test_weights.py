# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights and initial labels through the Python API and the command line."""

import json

import numpy as np
import pytest
from mesh_paths import SAMPLE_FOLDER, load_arrays
from recount import weight_imbalance
from shapes import bumpy_sphere

import spheroseg
from spheroseg import cli
from spheroseg.baselines import load

LEAF = SAMPLE_FOLDER / "flat_leaf.ply"


@pytest.fixture(scope="module")
def leaf():
    return load_arrays(LEAF)


@pytest.fixture(scope="module")
def weights(leaf):
    return np.random.default_rng(2).integers(1, 11, len(leaf[1]))


def test_weights_are_balanced(leaf, weights):
    result = spheroseg.segment(*leaf, 12, balance="weight", face_weights=weights)
    found = result.measures["weight_imbalance"]
    assert found == pytest.approx(weight_imbalance(result.labels, weights))
    assert found <= 1.05


def test_boundaries_by_weight_are_little_longer_than_by_count():
    vertices, faces = bumpy_sphere(6, 1)
    k = len(faces) // 16
    weights = np.random.default_rng(1).integers(1, 11, len(faces))
    by_weight, by_count = (
        np.median(
            [
                spheroseg.segment(
                    vertices, faces, k, seed=seed, effort="standard", **options
                ).measures["boundary_edge_count"]
                for seed in range(1, 6)
            ]
        )
        for options in ({"balance": "weight", "face_weights": weights}, {})
    )
    # 1.06; where what a step has missed by little is not shortened any more: 1.11.
    assert by_weight < 1.08 * by_count


def test_weights_without_the_balance_are_an_error(leaf, weights):
    with pytest.raises(spheroseg.InputError, match="balance='weight'"):
        spheroseg.segment(*leaf, 12, face_weights=weights)


def test_weights_of_the_wrong_length_are_an_error(leaf, weights):
    with pytest.raises(spheroseg.InputError, match="one entry per face"):
        spheroseg.segment(*leaf, 12, balance="weight", face_weights=weights[1:])


def test_labels_that_are_valid_get_no_worse_and_are_not_changed(leaf):
    first = spheroseg.segment(*leaf, 12, effort="draft")
    labels = first.labels.copy()
    again = spheroseg.segment(*leaf, initial_labels=labels)
    assert (labels == first.labels).all()
    assert again.measures["submesh_count"] == 12
    assert again.measures["boundary_edge_count"] <= first.measures["boundary_edge_count"]


def test_random_labels_become_valid(leaf):
    labels = np.random.default_rng(3).integers(0, 9, len(leaf[1]))
    measures = spheroseg.segment(*leaf, initial_labels=labels).measures
    assert measures["max_triangle_count_difference"] <= 1
    assert measures["disconnected_submesh_count"] == 0
    assert measures["bowtie_count"] == 0


def test_fractional_labels_are_an_error(leaf):
    with pytest.raises(spheroseg.InputError, match="whole numbers"):
        spheroseg.segment(*leaf, initial_labels=np.full(len(leaf[1]), 0.5))


def test_the_command_line_takes_both_from_files(leaf, weights, tmp_path):
    np.save(tmp_path / "weights.npy", weights)
    np.savetxt(tmp_path / "start.txt", np.arange(len(weights)) * 8 // len(weights), fmt="%d")
    arguments = ["segment", LEAF, "-q", "--balance", "weight"]
    arguments += ["--weights", tmp_path / "weights.npy"]
    arguments += ["--initial-labels", tmp_path / "start.txt"]
    arguments += ["--labels", tmp_path / "out.npy", "--json", tmp_path / "out.json"]
    assert cli.main([str(argument) for argument in arguments]) == 0
    labels = np.load(tmp_path / "out.npy")
    measures = json.loads((tmp_path / "out.json").read_text())
    assert measures["submesh_count"] == 8
    assert measures["weight_imbalance"] == pytest.approx(weight_imbalance(labels, weights))
    same = spheroseg.segment(
        *leaf,
        balance="weight",
        face_weights=weights,
        initial_labels=np.arange(len(weights)) * 8 // len(weights),
    )
    assert (same.labels == labels).all()


def test_the_command_line_refuses_another_k_than_that_of_initial_labels(leaf, tmp_path, capsys):
    np.savetxt(tmp_path / "start.txt", np.arange(len(leaf[1])) * 8 // len(leaf[1]), fmt="%d")
    arguments = ["segment", str(LEAF), "-q", "--initial-labels", str(tmp_path / "start.txt")]
    assert cli.main([*arguments, "-k", "50"]) == 2
    said = capsys.readouterr().err
    assert (
        "submesh_count=50 asks for 50 sub-meshes, but k is the number of different initial "
        "labels, 8; leave submesh_count out"
    ) in said
    assert said.count("\n") == 1
    assert cli.main([*arguments, "-k", "8"]) == 0


@pytest.mark.parametrize("command", ["split", "export"])
def test_commands_that_segment_first_take_weights_from_a_file(command, leaf, weights, tmp_path):
    np.save(tmp_path / "weights.npy", weights)
    output = tmp_path / ("parts" if command == "split" else "blocks.npz")
    arguments = [command, str(LEAF), "--weights", str(tmp_path / "weights.npy"), "-o", str(output)]
    assert cli.main([*arguments, "-k", "12", "--balance", "weight"]) == 0
    expected = spheroseg.segment(*leaf, 12, balance="weight", face_weights=weights).labels
    assert expected.tolist() != spheroseg.segment(*leaf, 12, balance="weight").labels.tolist()
    if command == "split":
        entries = json.loads((output / "manifest.json").read_text())["submeshes"]
        counts = [entry["triangle_count"] for entry in entries]
    else:
        with np.load(output) as blocks:
            counts = np.diff(blocks["triangle_starts"]).tolist()
    assert counts == np.bincount(expected).tolist()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-k", "12"], "balance='weight'"),
        (["--labels", "labels.npy"], "--weights would make others"),
        ([], "has no labels"),
    ],
)
def test_weights_that_would_change_nothing_are_refused(
    options, message, weights, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    for name in ("weights", "labels"):
        np.save(tmp_path / f"{name}.npy", weights)
    arguments = ["export", str(LEAF), "--weights", "weights.npy", "-o", "o.npz", *options]
    assert cli.main(arguments) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.count("\n") == 1


def test_a_damaged_file_of_weights_is_called_that(tmp_path, capsys):
    path = tmp_path / "weights.txt"
    for text, reason in (
        ("1\nheavy\n", "line 2: expected a number, found 'heavy'"),
        ("# areas\n1\n\n2\n1_0 3\n", "line 5: expected a number, found '1_0'"),
        ("1\n\n2 # two\n3 4\n", "line 4: expected 1 number as in the lines before, found 2"),
        ("1 2\n3\n", "line 2: expected 2 numbers as in the lines before, found 1"),
        ("# none\n\n", "it holds no numbers"),
    ):
        path.write_text(text)
        assert cli.main(["segment", str(LEAF), "--balance", "weight", "--weights", str(path)]) == 2
        assert f"{path}: is no file of weights: {reason}\n" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["segment", "split"])
def test_weights_that_do_not_fit_are_refused_with_the_name_of_their_file(
    command, leaf, weights, tmp_path, capsys
):
    path = tmp_path / "weights.npy"
    np.save(path, weights[1:])
    arguments = [command, str(LEAF), "-k", "12", "--balance", "weight", "--weights", str(path)]
    assert cli.main([*arguments, *(["-o", str(tmp_path / "out")] * (command == "split"))]) == 2
    count = len(leaf[1])
    assert capsys.readouterr().err == (
        f"spheroseg {command}: {path}: face_weights must have one entry per face: {count}, "
        f"got {count - 1}\n"
    )


@pytest.mark.parametrize("name", ["metis_kway", "metis_recursive", "region_growing"])
def test_labels_of_other_methods_become_valid_and_mostly_stay(name):
    arrays = load_arrays(SAMPLE_FOLDER / "displaced_sphere.ply")
    given = load(name)(*arrays, 60, 1)
    before = spheroseg.measure(*arrays, given)
    result = spheroseg.segment(*arrays, initial_labels=given)
    after = result.measures
    assert after["submesh_count"] == len(np.unique(given))
    assert after["max_triangle_count_difference"] <= 1
    assert after["bowtie_count"] == after["disconnected_submesh_count"] == 0
    assert after["boundary_edge_count"] <= before["boundary_edge_count"]
    kept = np.mean(result.labels == given)
    # Region growing leaves parts of very different sizes, which have to give much away.
    assert kept > (0.2 if name == "region_growing" else 0.5)
