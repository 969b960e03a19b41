# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives the real MeshLab application in its own system root, as a person would."""

import os
import re
import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
from PIL import Image
from screen import Screen, Window, wait_until

HOME_IN_ROOT = Path("/home/user")
PROGRAM = "MeshLab_64bit_fp"
# Where the menu stands in the window, and its submenus from top to bottom.
FILTERS_MENU = (116, 10)
FILTERS_SUBMENUS = [
    "Selection",
    "Cleaning and Repairing",
    "Create New Mesh Layer",
    "Remeshing, Simplification and Reconstruction",
    "Polygonal and Quad Mesh",
    "Color Creation and Processing",
    "Smoothing, Fairing and Deformation",
    "Quality Measure and Computations",
]
# Where the eye of the first layer stands, and the buttons of the dialog of filter scripts.
LAYER_LIST = (866, 111)
SCRIPT_BUTTONS = {"Save Script": 51, "Open Script": 137, "Apply Script": 480}
_SETTINGS = """\
[General]
lastTimeMeshLabVersionCheckedOnStart=Fri Jan 1 2100
dontRemindMeToSendEmail=true
dontRemindMeAboutUpgrade=true
"""
# In a mount namespace of its own: nothing stays mounted, however the program ends. No network.
_ENTER_ROOT = """
mount --bind "$1" "$2/home/user" && mount --bind /tmp/.X11-unix "$2/tmp/.X11-unix" &&
mount -t proc proc "$2/proc" || exit 97
root=$2; display=$3; user=$4; shift 4
exec chroot --userspec="$user" "$root" env -i HOME=/home/user DISPLAY="$display" \
    LANG=C.UTF-8 PATH=/usr/bin:/bin LIBGL_ALWAYS_SOFTWARE=1 XDG_RUNTIME_DIR=/tmp "$@"
"""


def root_command(root: Path, home: Path, display: str, *command: str) -> list[str]:
    """The command line that runs `command` inside the MeshLab root with `home` as its home."""
    unshare = ["unshare", "--mount", "--net", "sh", "-c", _ENTER_ROOT, "sh"]
    user = f"{os.getuid()}:{os.getgid()}"
    as_root = [] if os.geteuid() == 0 else ["sudo", "--non-interactive"]
    return [*as_root, *unshare, str(home), str(root), display, user, *command]


def prepare_home(home: Path) -> Path:
    """A home folder in which MeshLab asks no questions at its start."""
    settings = home / ".config" / "VCG" / f"{PROGRAM}.conf"
    settings.parent.mkdir(parents=True, exist_ok=True)
    settings.write_text(_SETTINGS)
    return home


class MeshLabWindow:
    """One run of MeshLab on a screen; a context manager that ends it if the test did not.

    Files are named as the person in front of it sees them, relative to the home folder.
    """

    def __init__(self, screen: Screen, root: Path, home: Path, artefacts: Path):
        self.screen = screen
        self.home = home
        self._root = root
        self._artefacts = artefacts
        self._shots = 0
        self._log_file = artefacts / "log.txt"
        self._process: subprocess.Popen | None = None
        self._main: Window | None = None

    def __enter__(self) -> "MeshLabWindow":
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is None or self._process.poll() is not None:
            return
        self.screenshot("at-the-end")
        self._process.kill()
        self._process.wait(timeout=10)

    # --- life -------------------------------------------------------------------------------

    def launch(self, *meshes: Path) -> None:
        """Starts MeshLab with copies of the meshes in its home."""
        self._artefacts.mkdir(parents=True, exist_ok=True)
        for mesh in meshes:
            shutil.copy(mesh, self.home / mesh.name)
        arguments = [str(HOME_IN_ROOT / mesh.name) for mesh in meshes]
        command = root_command(self._root, self.home, self.screen.display, "meshlab", *arguments)
        # The driver reads the file that MeshLab writes: a pipe that nobody empties would block it.
        with self._log_file.open("w") as log:
            self._process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)

    def start(self, *meshes: Path, seconds: float = 60.0) -> None:
        """Starts MeshLab with copies of the meshes in its home and waits until they are open."""
        self.launch(*meshes)
        # Kept, because a busy MeshLab does not answer questions about its windows.
        self._main = self.wait_for_window("MeshLab 20", seconds)
        for _ in meshes:
            self.wait_for_log("All files opened", seconds)
        self.screen.settle()

    def quit(self) -> int:
        """Leaves by the shortcut, declining to save; returns the exit status."""
        self.screen.keys("ctrl+q")
        deadline = time.monotonic() + 20
        while self._process.poll() is None and time.monotonic() < deadline:
            question = self.screen.find_window("MeshLab") or self.screen.find_window("Warning")
            if question is not None and question.width < 700:
                self.screen.keys("alt+d")
            time.sleep(0.1)
        return self._process.wait(timeout=1)

    def is_running(self) -> bool:
        return self._process.poll() is None

    # --- eyes -------------------------------------------------------------------------------

    def screenshot(self, name: str) -> Image.Image:
        """Keeps a picture of the screen among the test's artefacts."""
        self._shots += 1
        path = self.screen.save(self._artefacts / f"{self._shots:02d}-{name}.png")
        with Image.open(path) as picture:
            return picture.copy()

    def log_text(self) -> str:
        return self._log_file.read_text(errors="replace")

    def wait_for_log(self, pattern: str, seconds: float = 30.0, after: int = 0) -> re.Match:
        """Waits for a match of `pattern` in the log from character `after` on."""

        def look() -> re.Match | None:
            if not self.is_running():
                raise RuntimeError(f"MeshLab ended; its log:\n{self.log_text()[-2000:]}")
            return re.search(pattern, self.log_text()[after:])

        return wait_until(look, f"{pattern!r} in MeshLab's log", seconds)

    def wait_for_window(self, title: str, seconds: float = 20.0) -> Window:
        return wait_until(lambda: self.screen.find_window(title), f"window {title!r}", seconds)

    def wait_for_no_window(self, title: str, seconds: float = 20.0) -> None:
        wait_until(lambda: not self.screen.find_window(title), f"{title!r} to close", seconds)

    def canvas(self) -> np.ndarray:
        """Pixels of the area where the mesh is drawn, without its lower info band."""
        main = self._main
        pixels = self.screen.pixels()
        return pixels[main.y + 70 : main.y + 730, 4 : int(main.width * 0.65)]

    def progress_share(self) -> float:
        """How much of the progress bar in the status bar is filled, from 0 to 1."""
        main = self._main
        above_its_text = main.y + main.height - 24
        strip = self.screen.pixels()[
            above_its_text, main.x + main.width // 2 : main.x + main.width - 4
        ]
        # Blue up to where it is filled; the text on it is white.
        red, blue = strip[:, 0].astype(int), strip[:, 2].astype(int)
        filled = np.flatnonzero(blue - red > 60)
        return (filled[-1] + 1) / len(strip) if len(filled) else 0.0

    # --- hands ------------------------------------------------------------------------------

    def search(self, words: str) -> None:
        """Types into the search box and leaves its list open."""
        self.screen.keys("ctrl+f")
        self.screen.settle()
        self.screen.type_text(words)
        self.screen.settle()

    def open_filters_submenu(self, title: str) -> None:
        """Opens the Filters menu and in it the submenu; its first entry is then highlighted."""
        main = self._main
        self.screen.click(main.x + FILTERS_MENU[0], main.y + FILTERS_MENU[1])
        self.screen.settle()
        self._go_down_to(1 + FILTERS_SUBMENUS.index(title))
        self.screen.keys("Right")
        self.screen.settle()

    def run_filter_without_parameters(self, name: str, seconds: float = 30.0) -> None:
        """Finds a filter that has no dialog by the search box, which runs it."""
        start = len(self.log_text())
        self.search(name)
        self.screen.keys("Down", "Return")
        self.wait_for_log(re.escape(f"Applied filter: {name}"), seconds, start)
        self.screen.settle()

    def open_filter(self, name: str) -> "FilterDialog":
        """Finds a filter by the search box and opens its dialog."""
        self.search(name)
        self.screen.keys("Down", "Return")
        return self.wait_for_dialog(name)

    def wait_for_dialog(self, name: str) -> "FilterDialog":
        self.wait_for_window(name)
        self.screen.settle()
        return FilterDialog(self, name)

    def dismiss(self, title: str) -> None:
        """Answers a message box with its default button."""
        self.screen.keys("Return")
        self.wait_for_no_window(title)
        self.screen.settle()

    def select_layer(self, index: int) -> None:
        self._click_layer(index, 40)

    def hide_layer(self, index: int) -> None:
        self._click_layer(index, 10)

    def _click_layer(self, index: int, right: int) -> None:
        main = self._main
        self.screen.click(main.x + LAYER_LIST[0] + right, main.y + LAYER_LIST[1] + 32 * index)
        self.screen.settle()

    def show_whole_scene(self) -> None:
        self.screen.keys("ctrl+h")
        self.screen.settle()

    def _open_script_dialog(self) -> Window:
        self.screen.click(self._main.x + FILTERS_MENU[0], self._main.y + FILTERS_MENU[1])
        self.screen.settle()
        self._go_down_to(0)
        self.screen.keys("Return")
        return self.wait_for_window("Dialog")

    def _go_down_to(self, entry: int) -> None:
        """In the open Filters menu; "Show current filter script" is entry 0."""
        # "Apply filter" above it can be chosen only when a filter was applied before.
        above = 2 if "Applied filter" in self.log_text() else 1
        self.screen.keys(*["Down"] * (above + entry))

    def _press_in_script_dialog(self, button: str) -> None:
        dialog = self.screen.find_window("Dialog") or self._open_script_dialog()
        self.screen.settle()
        right = SCRIPT_BUTTONS[button]
        self.screen.click(dialog.x + right, dialog.y + dialog.height - 28)
        self.screen.settle()

    def save_filter_script(self, name: str) -> Path:
        """Saves the history of filters; returns the file on this side."""
        self._press_in_script_dialog("Save Script")
        self.wait_for_window("Save Filter Script")
        self.screen.type_text(str(HOME_IN_ROOT / name))
        self.screen.keys("Return")
        wait_until((self.home / name).is_file, "the saved script")
        self.screen.keys("Escape")
        self.wait_for_no_window("Dialog")
        return self.home / name

    def open_filter_script(self, name: str) -> None:
        """Puts a saved script into the place of the history."""
        self._press_in_script_dialog("Open Script")
        self.wait_for_window("Open Filter Script")
        self.screen.type_text(str(HOME_IN_ROOT / name))
        self.screen.keys("Return")
        self.wait_for_no_window("Open Filter Script")
        self.screen.settle()

    def apply_filter_script(self, done: str, seconds: float = 60.0) -> None:
        """Applies the script and waits for `done` in the log: MeshLab itself says nothing."""
        start = len(self.log_text())
        self._press_in_script_dialog("Apply Script")
        self.wait_for_log(done, seconds, start)
        self.screen.settle()

    def export(self, name: str) -> Path:
        """Exports the current layer with all that it has; returns the file on this side."""
        start = len(self.log_text())
        self.screen.keys("ctrl+shift+e")
        self.wait_for_window("Save")
        self.screen.settle()
        self.screen.type_text(str(HOME_IN_ROOT / name))
        self.screen.keys("Return")
        self.wait_for_window("Choose Saving Options")
        self.screen.settle()
        self.screen.keys("Return")
        self.wait_for_log("Saved Mesh", after=start)
        self.screen.settle()
        return self.home / name

    def reload(self) -> None:
        """Reads the current mesh from its file again."""
        start = len(self.log_text())
        # "Reload all": the shortcut of "Reload" is also that of the menu "Render".
        self.screen.keys("ctrl+shift+r")
        self.wait_for_log("reloaded", after=start)
        self.screen.settle()


class FilterDialog:
    """A filter's dialog: a floating panel whose buttons stand at fixed distances from its foot."""

    def __init__(self, meshlab: MeshLabWindow, name: str):
        self.meshlab = meshlab
        self.screen = meshlab.screen
        self.name = name

    @property
    def window(self) -> Window:
        return self.meshlab.wait_for_window(self.name)

    def _click(self, x_share: float, above_foot: int) -> None:
        window = self.window
        self.screen.click(
            window.x + int(window.width * x_share), window.y + window.height - above_foot
        )

    def apply(self, seconds: float = 60.0) -> str:
        """Applies the filter, waits for its end and returns what it wrote into the log."""
        start = len(self.meshlab.log_text())
        self.press_apply()
        self.meshlab.wait_for_log(re.escape(f"Applied filter: {self.name}"), seconds, start)
        self.screen.settle()
        return self.meshlab.log_text()[start:]

    def press_apply(self) -> None:
        self._click(0.75, 22)

    def close(self) -> None:
        self._click(0.25, 22)
        self.meshlab.wait_for_no_window(self.name)
        self.screen.settle()

    def move_aside(self) -> None:
        """To the left edge, where it does not cover the progress bar."""
        self.screen.move(self.window, 0, 20)
        self.screen.settle()

    def reset(self) -> None:
        self._click(0.25, 50)
        self.screen.settle()

    def toggle_help(self) -> None:
        self._click(0.75, 50)
        self.screen.settle()

    def toggle_advanced(self) -> None:
        """Of the segmentation, by the arrow below the last parameter."""
        self._click(0.5, 233)
        self.screen.settle()

    def toggle_preview(self) -> None:
        self._click(0.03, 169)
        self.screen.settle()

    def toggle_only_check_box(self) -> None:
        """Of a filter with one parameter."""
        self._click(0.517, 211)
        self.screen.settle()

    def copied_call(self) -> str:
        """The text of "Copy PyMeshLab call to clipboard"."""
        self.screen.clear_clipboard()
        self._click(0.5, 90)
        return wait_until(lambda: self.screen.clipboard().strip(), "the copied call")

    def picture(self) -> np.ndarray:
        window = self.window
        whole = self.screen.pixels()
        return whole[window.y : window.y + window.height, window.x : window.x + window.width]

    def text_fields(self) -> list[tuple[int, int]]:
        """Screen positions of the text fields, from top to bottom: they are the white strips."""
        window = self.window
        x = window.width - 60
        white = (self.picture()[:, x] == 255).all(axis=1)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], white.astype(int), [0]])))
        strips = zip(edges[::2], edges[1::2], strict=True)
        return [
            (window.x + x, window.y + int(top + bottom) // 2)
            for top, bottom in strips
            if 12 <= bottom - top <= 30
        ]

    def field_text(self, index: int) -> str:
        """What stands in a text field, read through the clipboard."""
        self.screen.clear_clipboard()
        self.screen.click(*self.text_fields()[index])
        self.screen.keys("ctrl+a", "ctrl+c")
        return wait_until(lambda: self.screen.clipboard().strip(), f"text of field {index}")

    def set_field(self, index: int, text: str) -> None:
        self.screen.click(*self.text_fields()[index])
        self.screen.keys("ctrl+a")
        self.screen.type_text(text)
        self.screen.keys("Tab")
        self.screen.settle()
