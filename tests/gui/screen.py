# SPDX-License-Identifier: GPL-3.0-or-later
"""A virtual X screen with a window manager, and hands and eyes on it (xdotool, screenshots)."""

import os
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from PIL import Image, ImageGrab

POLL_SECONDS = 0.05


def wait_until(condition: Callable[[], object], what: str, seconds: float = 20.0):
    """Returns the first true value of `condition`; TimeoutError naming `what` after `seconds`."""
    deadline = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise TimeoutError(f"waited {seconds:g} s in vain for {what}")
        time.sleep(POLL_SECONDS)


def vivid_colors(pixels: np.ndarray) -> int:
    """How many clearly different colours, grey ones aside, the picture has; noise is left out."""
    flat = pixels.reshape(-1, 3).astype(int)
    hue_like = flat - flat.min(axis=1, keepdims=True)
    vivid = flat[hue_like.max(axis=1) > 60] // 32
    _, counts = np.unique(vivid, axis=0, return_counts=True)
    return int((counts > 20).sum())


@dataclass(frozen=True)
class Window:
    """A visible top-level window; x, y, width and height are those of its content."""

    id: int
    title: str
    x: int
    y: int
    width: int
    height: int


class Screen:
    """An Xvfb of its own with openbox on it; use it as a context manager."""

    def __init__(self, width: int = 1280, height: int = 900):
        self.size = (width, height)
        self.display = ""
        self._server: subprocess.Popen | None = None
        self._manager: subprocess.Popen | None = None

    def __enter__(self) -> "Screen":
        read_end, write_end = os.pipe()
        geometry = f"{self.size[0]}x{self.size[1]}x24"
        self._server = subprocess.Popen(
            # Without -noreset the server begins anew when its last client leaves, which throws out
            # an openbox that comes in while xprop, asking for it, goes.
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", geometry]
            + ["-nolisten", "tcp", "-noreset"],
            pass_fds=[write_end],
            stderr=subprocess.DEVNULL,
        )
        os.close(write_end)
        with os.fdopen(read_end) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise RuntimeError("Xvfb did not start")
        self.display = f":{number}"
        self._manager = subprocess.Popen(
            ["openbox"], env=self._environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        try:
            wait_until(self._has_window_manager, "openbox to manage the screen")
        except TimeoutError:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for process in (self._manager, self._server):
            if process is not None:
                process.terminate()
                process.wait(timeout=10)

    @property
    def _environment(self) -> dict[str, str]:
        return {**os.environ, "DISPLAY": self.display}

    def _run(self, *command: object) -> subprocess.CompletedProcess:
        return subprocess.run(
            [str(part) for part in command],
            env=self._environment,
            capture_output=True,
            text=True,
            timeout=30,
            check=False,
        )

    def _has_window_manager(self) -> bool:
        return "window id" in self._run("xprop", "-root", "_NET_SUPPORTING_WM_CHECK").stdout

    def keys(self, *combinations: str) -> None:
        """Presses the combinations one after another, such as `ctrl+f`."""
        for combination in combinations:
            self._run("xdotool", "key", "--clearmodifiers", combination)

    def type_text(self, text: str) -> None:
        self._run("xdotool", "type", "--delay", "8", "--", text)

    def click(self, x: int, y: int, count: int = 1) -> None:
        self._run("xdotool", "mousemove", x, y)
        self._run("xdotool", "click", "--repeat", count, "--delay", "40", "1")

    def drag(self, start: tuple[int, int], end: tuple[int, int], steps: int = 10) -> None:
        """Moves the pointer from start to end with the left button pressed."""
        self._run("xdotool", "mousemove", *start, "mousedown", 1)
        for i in range(1, steps + 1):
            at = [round(a + (b - a) * i / steps) for a, b in zip(start, end, strict=True)]
            self._run("xdotool", "mousemove", *at)
        self._run("xdotool", "mouseup", 1)

    def scroll_down(self, clicks: int) -> None:
        self._run("xdotool", "click", "--repeat", clicks, "--delay", 40, 5)

    def move(self, window: Window, x: int, y: int) -> None:
        self._run("xdotool", "windowmove", window.id, x, y)

    def windows(self) -> list[Window]:
        """The visible windows of MeshLab that have a title of their own."""
        found = []
        listed = self._run("xdotool", "search", "--onlyvisible", "--class", "meshlab").stdout
        for window_id in listed.split():
            window = self._describe(int(window_id))
            if window is not None:
                found.append(window)
        return found

    def _describe(self, window_id: int) -> Window | None:
        title = self._run("xdotool", "getwindowname", window_id).stdout.strip()
        if not title or title.startswith("MeshLab_64bit"):
            return None
        shell = self._run("xwininfo", "-id", window_id).stdout
        values = dict(line.strip().split(":", 1) for line in shell.splitlines() if ": " in line)
        try:
            return Window(
                window_id,
                title,
                int(values["Absolute upper-left X"]),
                int(values["Absolute upper-left Y"]),
                int(values["Width"]),
                int(values["Height"]),
            )
        except KeyError:
            return None  # it closed between the two questions

    def find_window(self, title: str) -> Window | None:
        """The window whose title begins with `title`."""
        return next((w for w in self.windows() if w.title.startswith(title)), None)

    def clipboard(self) -> str:
        return self._run("xclip", "-selection", "clipboard", "-o").stdout

    def clear_clipboard(self) -> None:
        # xclip stays behind to serve the selection, so its output must not be waited for.
        subprocess.run(
            ["xclip", "-selection", "clipboard", "-i", "/dev/null"],
            env=self._environment,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=30,
            check=False,
        )

    def grab(self) -> Image.Image:
        return ImageGrab.grab(xdisplay=self.display)

    def pixels(self) -> np.ndarray:
        """The screen as an array of shape (height, width, 3)."""
        return np.asarray(self.grab())

    def settle(self, seconds: float = 5.0, quiet_seconds: float = 0.2) -> None:
        """Waits until the picture stands still; a blinking cursor does not prolong it for ever."""
        deadline = time.monotonic() + seconds
        before = self.pixels()
        while time.monotonic() < deadline:
            time.sleep(quiet_seconds)
            now = self.pixels()
            if np.array_equal(before, now):
                return
            before = now

    def save(self, path: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        self.grab().save(path)
        return path
