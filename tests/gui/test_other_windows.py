# SPDX-License-Identifier: GPL-3.0-or-later
"""The sphere as a layer, filter scripts, and the installation as MeshLab sees it."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pymeshlab
import pytest
from meshlab_window import MeshLabWindow, root_command
from screen import vivid_colors

from spheroseg import cli, install, plugin_path

REPOSITORY = Path(__file__).resolve().parents[2]
SEGMENTATION = "Balanced Segmentation (SpheroSeg)"
PARAMETRIZATION = "Spherical Parametrization (SpheroSeg)"
LAYERS = "Split into Sub-mesh Layers (SpheroSeg)"
SUBMESH_COUNT, _, SEED = range(3)


def labels_of(path):
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    return meshes.current_mesh().face_scalar_array().astype(int)


def test_the_sphere_appears_as_a_layer_of_its_own_with_the_colours(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.apply()
    dialog.close()
    dialog = meshlab.open_filter(PARAMETRIZATION)
    meshlab.screenshot("dialog")
    # Beyond two thirds of the screen, of a laptop's here, MeshLab would cut off the help.
    assert dialog.window.height <= 768 * 2 / 3
    dialog.toggle_only_check_box()
    assert dialog.copied_call().endswith("(new_layer = True)")
    log = dialog.apply()
    assert "0 flipped triangles" in log
    dialog.close()
    meshlab.select_layer(1)
    meshlab.hide_layer(0)
    assert vivid_colors(meshlab.canvas()) > 20
    meshlab.show_whole_scene()
    meshlab.screenshot("sphere")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(meshlab.export("sphere.ply")))
    sphere = meshes.current_mesh()
    assert sphere.face_number() == 5804
    radii = np.linalg.norm(sphere.vertex_matrix(), axis=1)
    assert radii == pytest.approx(np.ones(len(radii)), abs=1e-6)
    # All around: the triangles cover the whole sphere, so its hull holds the centre well inside.
    volume = meshes.get_geometric_measures()["mesh_volume"]
    assert volume > 0.9 * 4 / 3 * np.pi


def test_a_segmentation_after_the_parametrization_uses_its_map(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(PARAMETRIZATION)
    dialog.apply()
    dialog.close()
    log = meshlab.open_filter(SEGMENTATION).apply()
    assert "sphere_position does not fit" not in log


def test_a_saved_filter_script_gives_the_same_labels_everywhere(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(SUBMESH_COUNT, "24")
    dialog.set_field(SEED, "3")
    dialog.apply()
    dialog.close()
    by_hand = labels_of(meshlab.export("by_hand.ply"))
    script = meshlab.save_filter_script("history.mlx")
    meshlab.screenshot("saved")
    meshlab.reload()
    # The script stands in the history still, so that it can be applied at once.
    meshlab.apply_filter_script("triangles in .* sub-meshes")
    meshlab.screenshot("replayed")
    assert np.array_equal(labels_of(meshlab.export("replayed.ply")), by_hand)

    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(cow))
    meshes.load_filter_script(str(script))
    meshes.apply_filter_script()
    assert np.array_equal(meshes.current_mesh().face_scalar_array(), by_hand)


def test_a_loaded_filter_script_is_replayed_in_a_new_window(
    screen, meshlab_root, home, artefacts, cow
):
    script = home / "from_pymeshlab.mlx"
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(cow))
    meshes.compute_scalar_by_balanced_segmentation_per_face(submesh_count=12)
    meshes.save_filter_script(str(script))
    with MeshLabWindow(screen, meshlab_root, home, artefacts) as meshlab:
        meshlab.start(cow)
        meshlab.open_filter_script(script.name)
        meshlab.screenshot("loaded")
        meshlab.apply_filter_script("triangles in .* sub-meshes")
        labels = labels_of(meshlab.export("replayed.ply"))
    assert np.array_equal(labels, meshes.current_mesh().face_scalar_array())


@pytest.fixture
def meshlab_program(tmp_path, meshlab_root, bare_home):
    """The root's MeshLab as a program that can be asked for its version."""
    program = tmp_path / "bin" / "meshlab"
    program.parent.mkdir()
    command = root_command(meshlab_root, bare_home, ":0", "meshlab", "--version")
    quoted = " ".join("'" + part.replace("'", "'\\''") + "'" for part in command)
    program.write_text(f"#!/bin/sh\nexec {quoted}\n")
    program.chmod(0o755)
    return program


def test_install_plugin_asks_the_real_meshlab_and_the_filter_is_there_at_its_next_start(
    screen, meshlab_root, meshlab_program, bare_home, artefacts, desktop_plugin, cow, monkeypatch
):
    monkeypatch.setenv("HOME", str(bare_home))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setenv("PATH", f"{meshlab_program.parent}:{os.environ['PATH']}")
    assert install.meshlab_host("meshlab") == install.Host("2025.07", "float")
    assert cli.main(["install-plugin", "--plugin", str(desktop_plugin)]) == 0
    with MeshLabWindow(screen, meshlab_root, bare_home, artefacts) as meshlab:
        meshlab.start(cow)
        meshlab.open_filter(SEGMENTATION)
        meshlab.screenshot("found")


def test_without_the_plugin_the_search_does_not_find_it(
    screen, meshlab_root, bare_home, artefacts, cow
):
    with MeshLabWindow(screen, meshlab_root, bare_home, artefacts) as meshlab:
        meshlab.start(cow)
        meshlab.search("SpheroSeg")
        meshlab.screenshot("search")
        meshlab.screen.keys("Down", "Return")
        meshlab.screen.settle()
        assert meshlab.screen.find_window(SEGMENTATION) is None


def test_meshlab_names_a_plugin_that_does_not_fit_when_it_starts(
    screen, meshlab_root, bare_home, artefacts, monkeypatch
):
    monkeypatch.setenv("HOME", str(bare_home))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    folder = install.user_plugin_folder(install.Host("2025.07", "float"))
    folder.mkdir(parents=True)
    shutil.copy(plugin_path(), folder)
    with MeshLabWindow(screen, meshlab_root, bare_home, artefacts) as meshlab:
        meshlab.launch()
        meshlab.wait_for_window("Error while loading plugins")
        meshlab.screenshot("error")
        meshlab.dismiss("Error while loading plugins")
        meshlab.wait_for_window("MeshLab 20")


def test_a_plugin_in_double_precision_is_refused_by_the_command(
    meshlab_program, bare_home, monkeypatch, capsys
):
    monkeypatch.setenv("HOME", str(bare_home))
    arguments = ["--meshlab", str(meshlab_program), "--plugin", str(plugin_path())]
    assert cli.main(["install-plugin", *arguments]) == 2
    message = capsys.readouterr().err
    assert "double precision" in message
    assert "single precision" in message


def test_the_plugin_needs_nothing_that_the_meshlab_system_lacks(
    meshlab_root, bare_home, desktop_plugin
):
    shutil.copy(desktop_plugin, bare_home)
    command = root_command(
        meshlab_root, bare_home, ":0", "ldd", f"/home/user/{desktop_plugin.name}"
    )
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    # MeshLab's own library lies in MeshLab's folder and is in the process already.
    missing = [line for line in listed.splitlines() if "not found" in line]
    assert not [line for line in missing if "libmeshlab-common" not in line]


def test_each_submesh_becomes_a_layer_in_its_colour(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(SUBMESH_COUNT, "6")
    dialog.apply()
    dialog.close()
    meshlab.run_filter_without_parameters(LAYERS)
    meshlab.hide_layer(0)
    meshlab.screenshot("layers")
    assert vivid_colors(meshlab.canvas()) > 5
    meshlab.select_layer(3)
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(meshlab.export("layer.ply")))
    assert meshes.current_mesh().face_number() in (967, 968)
    assert meshlab.quit() == 0


def test_many_layers_are_made_while_their_list_is_hidden(meshlab, cow):
    """MeshLab builds the list anew for each layer, which takes minutes for these."""
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.apply()
    dialog.close()
    meshlab.run_filter_without_parameters(LAYERS, seconds=20.0)
    meshlab.screenshot("200-layers")
    meshlab.select_layer(1)  # the list is back
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(meshlab.export("layer.ply")))
    assert meshes.current_mesh().face_number() in (29, 30)


def test_the_filters_that_error_messages_name_exist_in_meshlab(meshlab_root):
    source = REPOSITORY / "filter_spheroseg" / "engine" / "validity.cpp"
    text = re.sub(r'"\s*\n\s*"', "", source.read_text())
    named = set(re.findall(r'\\"([A-Z][^"\\]*)\\"', text))
    assert {"Close Holes", "Merge Close Vertices"} <= named
    named.discard("Alpha Wrap")  # in MeshLab's own builds, but not in Debian's
    plugins = [path.read_bytes() for path in meshlab_root.glob("usr/lib/*/meshlab/plugins/*.so")]
    for name in named:
        spellings = (name.encode(), name.encode("utf-16-le"))
        assert any(s in plugin for plugin in plugins for s in spellings), name
