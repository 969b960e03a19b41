# SPDX-License-Identifier: GPL-3.0-or-later
"""Balanced Segmentation in the MeshLab window, step by step as a person uses it."""

import re

import numpy as np
import pymeshlab
import pytest
from screen import vivid_colors, wait_until

SEGMENTATION = "Balanced Segmentation (SpheroSeg)"
MEASURES = "Segmentation Measures (SpheroSeg)"
SUBMESH_COUNT, TRIANGLES_PER_SUBMESH, SEED = range(3)
FAILURE = "Filter Failure"
# Of the large mesh; the more sub-meshes, the longer there is something to see.
LONG_SUBMESH_COUNT = "5000"
APPLIED = f"Applied filter: {SEGMENTATION}"


def load(path):
    """A MeshSet with an exported mesh, and the labels in its face quality."""
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(str(path))
    quality = meshes.current_mesh().face_scalar_array()
    labels = quality.astype(int)
    assert np.array_equal(labels, quality)
    return meshes, labels


def assert_balanced(labels, submesh_count):
    counts = np.bincount(labels)
    assert len(counts) == submesh_count
    assert counts.max() - counts.min() <= 1


def test_stands_in_the_menu_of_quality_measures(meshlab, cow):
    meshlab.start(cow)
    # First in alphabetical order among the filters of its menu, so no further key is needed.
    meshlab.open_filters_submenu("Quality Measure and Computations")
    meshlab.screenshot("menu")
    meshlab.screen.keys("Return")
    meshlab.wait_for_window(SEGMENTATION)
    meshlab.screenshot("dialog")
    assert meshlab.quit() == 0


def test_a_search_by_words_opens_the_dialog_with_defaults_for_the_mesh(meshlab, cow):
    meshlab.start(cow)
    meshlab.search("balanced segmentation")
    meshlab.screenshot("search")
    meshlab.screen.keys("Down", "Return")
    dialog = meshlab.wait_for_dialog(SEGMENTATION)
    meshlab.screenshot("dialog")
    assert dialog.copied_call() == "ms.compute_scalar_by_balanced_segmentation_per_face()"
    assert dialog.field_text(SUBMESH_COUNT) == "200"
    assert dialog.field_text(TRIANGLES_PER_SUBMESH) == "0"
    dialog.toggle_help()
    meshlab.screenshot("dialog-with-help")
    dialog.toggle_help()
    dialog.close()


def test_a_small_mesh_is_offered_fewer_submeshes(meshlab, small_mesh):
    meshlab.start(small_mesh)
    dialog = meshlab.open_filter(SEGMENTATION)
    meshlab.screenshot("dialog")
    assert 1 < int(dialog.field_text(SUBMESH_COUNT)) < 200


def test_the_dialog_fits_a_laptop_and_shows_advanced_parameters_on_demand(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    # 768 pixels less a panel of the desktop.
    assert dialog.window.height <= 740
    fields = len(dialog.text_fields())
    dialog.move_aside()
    dialog.toggle_advanced()
    meshlab.screenshot("advanced")
    # The list scrolls, so that Apply stays where it was.
    assert len(dialog.text_fields()) > fields
    assert dialog.window.height <= 740
    assert "in 200 sub-meshes" in dialog.apply()


def test_applying_colours_the_mesh_and_reports_to_the_log(meshlab, cow):
    meshlab.start(cow)
    before = vivid_colors(meshlab.canvas())
    dialog = meshlab.open_filter(SEGMENTATION)
    log = dialog.apply()
    dialog.close()
    meshlab.screenshot("coloured")
    assert vivid_colors(meshlab.canvas()) > before + 20
    summary = re.search(r"LOG: 2 (.*)", log)[1]
    assert "5804 triangles in 200 sub-meshes of 29 to 30" in summary
    # A person reads it: no number with more than four digits behind the point.
    assert not re.search(r"\.\d{5}", summary)


def test_changed_parameters_reach_the_exported_labels(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(SUBMESH_COUNT, "37")
    dialog.set_field(SEED, "5")
    meshlab.screenshot("changed")
    log = dialog.apply()
    dialog.close()
    meshes, labels = load(meshlab.export("labelled.ply"))
    assert_balanced(labels, 37)
    measures = meshes.apply_filter("get_segmentation_measures")
    assert f"{measures['boundary_edge_count']} boundary edges" in log
    assert measures["max_triangle_count_difference"] <= 1
    # Every sub-mesh has one colour.
    colors = meshes.current_mesh().face_color_matrix()
    assert len({(label, *color) for label, color in zip(labels, colors, strict=True)}) == 37


def test_triangles_per_submesh_takes_the_place_of_the_count(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(TRIANGLES_PER_SUBMESH, "100")
    assert "in 59 sub-meshes of 98 to 99" in dialog.apply()


def test_twice_the_same_then_another_count_then_reloaded(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.apply()
    _, first = load(meshlab.export("first.ply"))
    dialog.apply()
    _, second = load(meshlab.export("second.ply"))
    assert np.array_equal(first, second)
    dialog.set_field(SUBMESH_COUNT, "10")
    assert "in 10 sub-meshes" in dialog.apply()
    dialog.close()
    meshlab.screenshot("ten")


def test_reloading_takes_the_colours_away_and_the_filter_works_again(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.apply()
    dialog.close()
    coloured = vivid_colors(meshlab.canvas())
    meshlab.reload()
    meshlab.screenshot("reloaded")
    assert vivid_colors(meshlab.canvas()) < coloured - 20
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.apply()
    dialog.close()
    meshlab.screenshot("again")
    assert vivid_colors(meshlab.canvas()) == pytest.approx(coloured, rel=0.2)


def test_preview_shows_the_colours_and_takes_them_back(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    before = vivid_colors(meshlab.canvas())
    dialog.toggle_preview()
    meshlab.screenshot("preview")
    wait_until(lambda: vivid_colors(meshlab.canvas()) > before + 5, "the previewed colours")
    dialog.toggle_preview()
    meshlab.screenshot("preview-off")
    wait_until(lambda: vivid_colors(meshlab.canvas()) <= before + 2, "the colours to go")
    dialog.close()
    # MeshLab takes back no face quality, as the manual says.
    assert_balanced(load(meshlab.export("afterwards.ply"))[1], 200)


def test_an_edge_of_three_faces_gives_a_dialog_and_meshlab_goes_on(meshlab, finned_mesh, cow):
    meshlab.start(finned_mesh)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.press_apply()
    meshlab.wait_for_window(FAILURE)
    meshlab.screenshot("error")
    meshlab.dismiss(FAILURE)
    meshlab.wait_for_log("failed: .*1 edge with more than two faces")
    dialog.close()
    # Repaired by MeshLab's own filter, the same mesh is segmented.
    repair = meshlab.open_filter("Repair non Manifold Edges")
    repair.apply()
    repair.close()
    assert "Applied filter" in meshlab.open_filter(SEGMENTATION).apply()
    assert meshlab.quit() == 0


def test_impossible_counts_give_a_dialog_and_the_next_run_works(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    for count in ("0", "-3", "5805", "many"):
        dialog.set_field(SUBMESH_COUNT, count)
        dialog.press_apply()
        meshlab.wait_for_window(FAILURE)
        meshlab.screenshot(f"error-{count}")
        meshlab.dismiss(FAILURE)
    dialog.set_field(SUBMESH_COUNT, "20")
    assert "in 20 sub-meshes" in dialog.apply()


def test_without_a_mesh_the_filter_is_not_offered(meshlab):
    meshlab.start()
    meshlab.search("balanced segmentation")
    meshlab.screenshot("search")
    meshlab.screen.keys("Down", "Return")
    meshlab.screen.settle()
    assert meshlab.screen.find_window(SEGMENTATION) is None
    assert meshlab.is_running()


def test_the_measures_filter_reports_the_labels_in_the_log(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    segmented = dialog.apply()
    dialog.close()
    start = len(meshlab.log_text())
    meshlab.run_filter_without_parameters(MEASURES)
    measured = meshlab.log_text()[start:]
    edges = re.compile(r"(\d+) boundary edges")
    assert edges.search(segmented)[1] == edges.search(measured)[1]


def test_labels_of_the_copied_call_equal_those_of_the_window(meshlab, cow):
    meshlab.start(cow)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(SUBMESH_COUNT, "64")
    call = dialog.copied_call()
    dialog.apply()
    dialog.close()
    _, labels = load(meshlab.export("labelled.ply"))
    ms = pymeshlab.MeshSet()
    ms.load_new_mesh(str(cow))
    eval(call, {"ms": ms, "pymeshlab": pymeshlab})
    assert np.array_equal(ms.current_mesh().face_scalar_array(), labels)


def test_progress_moves_while_the_window_stays_alive(meshlab, large_mesh):
    meshlab.start(large_mesh)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.move_aside()
    dialog.set_field(SUBMESH_COUNT, LONG_SUBMESH_COUNT)
    start = len(meshlab.log_text())
    dialog.press_apply()
    levels = []

    def applied():
        levels.append(round(meshlab.progress_share(), 2))
        # One picture only: between two looks is no time to write more.
        if levels[-1] > 0 and not any(levels[:-1]):
            meshlab.screenshot("progress")
        return APPLIED in meshlab.log_text()[start:]

    wait_until(applied, "the large mesh to be segmented", seconds=300)
    running = [level for level in levels if level > 0]
    assert len(set(running)) >= 4
    assert running == sorted(running)
    assert max(running) > 0.5
    dialog.close()
    meshlab.screenshot("coloured")
    assert meshlab.quit() == 0


def begin(meshlab, submesh_count):
    """Until the first step of the filter shows; its dialog."""
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.move_aside()
    dialog.set_field(SUBMESH_COUNT, submesh_count)
    dialog.press_apply()
    wait_until(lambda: meshlab.progress_share() > 0, "the first step")
    return dialog


def test_pressing_apply_again_while_it_runs_does_no_harm(meshlab, large_mesh):
    meshlab.start(large_mesh)
    dialog = begin(meshlab, LONG_SUBMESH_COUNT)
    dialog.press_apply()
    meshlab.wait_for_window(FAILURE)
    meshlab.screenshot("refused")
    meshlab.dismiss(FAILURE)
    meshlab.wait_for_log("already running")
    meshlab.wait_for_log(re.escape(APPLIED), seconds=300)
    meshlab.screen.settle()
    dialog.apply(seconds=300)
    assert meshlab.quit() == 0


def test_a_layer_may_be_removed_while_it_runs(meshlab, small_mesh, large_mesh):
    meshlab.start(small_mesh, large_mesh)  # the last one is the current one
    begin(meshlab, "100000")  # some seconds, of which the search takes one
    meshlab.run_filter_without_parameters("Delete Current Mesh")
    meshlab.wait_for_window(FAILURE, seconds=120)
    meshlab.screenshot("refused")
    meshlab.dismiss(FAILURE)
    meshlab.wait_for_log("failed: The mesh was removed or changed while the filter ran")
    assert APPLIED not in meshlab.log_text()
    # The other layer is as it was, and the filter runs again.
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(SUBMESH_COUNT, "30")
    dialog.apply()
    dialog.close()
    _, labels = load(meshlab.export("labelled.ply"))
    assert len(labels) == 20 * 4**3
    assert_balanced(labels, 30)
    assert meshlab.quit() == 0
