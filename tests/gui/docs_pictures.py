# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pictures of docs/meshlab.md: real screenshots, cropped, in few colours.

Run by `make docs-pictures`, which sets what it needs.
"""

import os
import tempfile
from pathlib import Path

import pymeshlab
from meshlab_window import MeshLabWindow, prepare_home
from PIL import Image
from screen import Screen

from spheroseg import install

REPOSITORY = Path(__file__).resolve().parents[2]
PICTURES = REPOSITORY / "docs" / "images"
SEGMENTATION = "Balanced Segmentation (SpheroSeg)"
PARAMETRIZATION = "Spherical Parametrization (SpheroSeg)"
COW = Path(pymeshlab.__file__).parent / "tests" / "sample_meshes" / "cow.obj"
COLORS = 255


def keep(picture: Image.Image, name: str, box=None, width: int | None = None) -> None:
    """Writes a crop of a screenshot, scaled down to `width`."""
    picture = picture.convert("RGB").crop(box) if box else picture.convert("RGB")
    if width:
        height = round(picture.height * width / picture.width)
        picture = picture.resize((width, height), Image.Resampling.LANCZOS)
    PICTURES.mkdir(parents=True, exist_ok=True)
    small = picture.quantize(COLORS, dither=Image.Dither.NONE)
    small.save(PICTURES / f"meshlab-{name}.png", optimize=True)


def box_of(window):
    # The title bar that the window manager draws belongs to the picture.
    return (window.x, window.y - 20, window.x + window.width, window.y + window.height)


def show_the_side(meshlab: MeshLabWindow) -> None:
    """Turns the mesh by dragging and comes nearer by the wheel, as one does to look at it."""
    meshlab.screen.drag((300, 430), (480, 425))
    meshlab.screen.scroll_down(1)
    meshlab.screen.settle()


def picture_segmentation(meshlab: MeshLabWindow) -> None:
    meshlab.start(COW)
    meshlab.open_filters_submenu("Quality Measure and Computations")
    keep(meshlab.screenshot("menu"), "menu", (0, 0, 840, 520), width=640)
    meshlab.screen.keys("Escape", "Escape", "Escape")
    meshlab.search("balanced segmentation")
    keep(meshlab.screenshot("search"), "search", (790, 40, 1280, 140))
    meshlab.screen.keys("Down", "Return")
    dialog = meshlab.wait_for_dialog(SEGMENTATION)
    window = dialog.window
    box = (window.x, window.y, window.x + window.width, window.y + window.height)
    keep(meshlab.screenshot("dialog"), "dialog", box, width=430)
    dialog.apply()
    dialog.close()
    show_the_side(meshlab)
    whole = meshlab.screenshot("window")
    keep(whole, "window", width=860)
    keep(whole, "log", (848, 704, 1276, 834))
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.set_field(0, "6000")
    dialog.press_apply()
    failure = meshlab.wait_for_window("Filter Failure")
    meshlab.screen.settle()
    keep(meshlab.screenshot("error"), "error", box_of(failure))
    meshlab.dismiss("Filter Failure")


def picture_sphere(meshlab: MeshLabWindow) -> None:
    meshlab.start(COW)
    dialog = meshlab.open_filter(SEGMENTATION)
    dialog.apply()
    dialog.close()
    dialog = meshlab.open_filter(PARAMETRIZATION)
    dialog.toggle_only_check_box()
    dialog.apply()
    dialog.close()
    meshlab.select_layer(1)
    meshlab.hide_layer(0)
    meshlab.show_whole_scene()
    keep(meshlab.screenshot("sphere"), "sphere", (0, 0, 1280, 780), width=640)


def main() -> None:
    root = Path(os.environ["SPHEROSEG_GUI_ROOT"])
    shots = REPOSITORY / "out" / "gui" / "docs"
    with Screen() as screen:
        for take in (picture_segmentation, picture_sphere):
            with tempfile.TemporaryDirectory() as folder:
                home = prepare_home(Path(folder))
                os.environ["HOME"] = folder
                plugins = install.user_plugin_folder(install.Host("2025.07", "float"))
                plugins.mkdir(parents=True)
                install.install_plugin(plugins)
                with MeshLabWindow(screen, root, home, shots / take.__name__) as meshlab:
                    take(meshlab)


if __name__ == "__main__":
    main()
